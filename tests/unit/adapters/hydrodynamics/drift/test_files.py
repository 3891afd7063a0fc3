"""Files of drift: what is read, and what is refused with file, line and remedy."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.drift_files import RHO, G, write_mean, write_qtf

from m4e_adapters.hydrodynamics.config import Drift, Water
from m4e_adapters.hydrodynamics.drift.far_field import write_csv
from m4e_adapters.hydrodynamics.drift.files import read_drift
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift, Qtf
from m4e_fmi.errors import InputError

OMEGA = (0.4, 0.7, 1.1)
AROUND = (0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0)
SPACE = (0.0, 0.0, -2.0)


def mean(w: float, beta: float, mode: int) -> float:
    """A force along the waves, and a moment; motions of body 2 are ten times those of body 1."""
    body, own = divmod(mode - 1, 6)
    angle = math.radians(beta)
    part = (math.cos(angle), math.sin(angle), 1.0, 1.0, 1.0, math.sin(2.0 * angle))[own]
    return 5e3 * w**2 * part * 10**body


def pairs(one: float, other: float, mode: int) -> complex:
    return (2.0 + mode) * 1e3 * one * other * complex(1.0, 0.5 * (one - other))


def read(path: Path, *, center: tuple[float, ...] = SPACE, **keys: object) -> MeanDrift | Qtf:
    section = Drift.model_validate({"file": path.name, **keys})
    water = Water(density=RHO, gravity=G)
    return read_drift(section, center=center, water=water, folder=path.parent).table


@pytest.mark.parametrize("suffix", [".7", ".8", ".9"])
def test_mean_drift(tmp_path: Path, suffix: str) -> None:
    path = write_mean(tmp_path / f"hull{suffix}", mean, omega=OMEGA, directions=AROUND)
    table = read(path)
    assert isinstance(table, MeanDrift)
    assert [motion.name for motion in table.motions] == ["surge", "sway", "yaw"]
    assert table.omega == pytest.approx(OMEGA)
    assert table.directions.tolist() == list(AROUND)
    expected = [[[mean(w, beta, m) for m in (1, 2, 6)] for beta in AROUND] for w in OMEGA]
    assert table.values == pytest.approx(np.array(expected), abs=1e-6)


def test_length_scale_and_body(tmp_path: Path) -> None:
    path = write_mean(
        tmp_path / "hull.9", mean, omega=OMEGA, directions=AROUND, modes=range(1, 13), ulen=20.0
    )
    table = read(path, body=2, length_scale=20.0)
    expected = [[[mean(w, beta, m) for m in (7, 8, 12)] for beta in AROUND] for w in OMEGA]
    assert table.values == pytest.approx(np.array(expected), abs=1e-5)
    assert "heave, roll and pitch are left out" in table.notes[0]


def test_in_the_plane_only_surge(tmp_path: Path) -> None:
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=(0.0, 180.0))
    table = read(path, center=(0.0, -2.0))
    assert [motion.name for motion in table.motions] == ["surge"]
    assert table.values.shape == (3, 2, 1)


def test_pairs_of_directions_are_left_out(tmp_path: Path) -> None:
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=AROUND)
    with path.open("a") as file:
        file.write("  5.0 0.0 45.0 1 9.0 0.0 9.0 0.0\n")
    assert read(path).notes == ("1 rows of pairs of directions are left out",)


def test_a_csv_file_is_as_it_was_written(tmp_path: Path) -> None:
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=AROUND)
    table = read(path)
    assert isinstance(table, MeanDrift)
    write_csv(table, tmp_path / "hull.csv")
    again = read(tmp_path / "hull.csv")
    assert again.values == pytest.approx(table.values, rel=1e-8, abs=1e-3)
    assert again.motions == table.motions


@pytest.mark.parametrize("both", [False, True])
def test_qtfs_are_conjugated_and_completed(tmp_path: Path, both: bool) -> None:
    path = write_qtf(tmp_path / "hull.12d", pairs, omega=OMEGA, both=both)
    table = read(path)
    assert isinstance(table, Qtf)
    assert [motion.name for motion in table.motions] == ["surge", "heave", "pitch"]
    expected = [[[pairs(a, b, m) for b in OMEGA] for a in OMEGA] for m in (1, 3, 5)]
    assert table.values[0] == pytest.approx(np.array(expected), rel=1e-9)
    diagonal = [[pairs(a, a, m).real for m in (1, 3, 5)] for a in OMEGA]
    assert table.mean.values[:, 0] == pytest.approx(np.array(diagonal), rel=1e-9)


def test_moments_about_the_centre_of_gravity(tmp_path: Path) -> None:
    """A force at the file's origin, 3 m ahead and 2 m above the centre: r × F."""
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=AROUND)
    plain, moved = read(path), read(path, reference_point=[3.0, 0.5, 0.0])
    surge, sway, yaw = np.moveaxis(plain.values, 2, 0)
    assert moved.values[:, :, 2] == pytest.approx(yaw + 3.0 * sway - 0.5 * surge)
    path = write_qtf(tmp_path / "hull.12d", pairs, omega=OMEGA)
    plain, moved = read(path), read(path, reference_point=[3.0, 0.0, 0.0])
    surge, heave, pitch = plain.values[0]
    assert moved.values[0, 2] == pytest.approx(pitch + 2.0 * surge - 3.0 * heave)


def line(number: int, text: str) -> Callable[[list[str]], list[str]]:
    return lambda lines: [*lines[: number - 1], text, *lines[number:]]


WRONG: dict[str, tuple[str, Callable[[list[str]], list[str]], dict[str, object], str]] = {
    "cut off": (".8", lambda rows: [*rows[:-1], rows[-1][:40]], {}, "hull.8:73:2: 3 numbers, exp"),
    "a row is missing": (".8", lambda rows: rows[:-1], {}, "1 of 72 values are missing"),
    "not a number": (".8", line(3, " 15.7 0.0 0.0 2 NaN 0.0 NaN 0.0"), {}, "hull.8:3:2: 'NaN'"),
    "other columns": (".8", line(3, " 0.0 0.0 1 9.0 0.0 9.0 0.0"), {}, "hull.8:3:2: 7 numbers"),
    "in other order": (".8", line(3, " 15.7 0.0 0.0 2 9.0 0.0 1.0 2.0"), {}, ":3:2: MOD 9 is not"),
    "a frequency of 0": (".8", line(3, " -1.0 0.0 0.0 2 9.0 0.0 9.0 0.0"), {}, ":3:2: the period"),
    "no such motion": (".8", line(3, " 5.0 0.0 0.0 1.5 9.0 0.0 9.0 0.0"), {}, ":3:2: motion 1.5"),
    "another body": (".8", lambda rows: rows, {"body": 2}, "hull.8:2:2: no row is of body 2"),
    "twice": (".8", lambda rows: [*rows, rows[-1]], {}, "hull.8:74:2: yaw at 1.1 rad/s, 315 deg"),
    "sums": (".12s", lambda rows: rows, {}, "forces of sums of frequencies are not computed"),
    "another suffix": (".dat", lambda rows: rows, {}, "the suffix '.dat' is not one of drift"),
    "a pair is missing": (".12d", lambda rows: rows[:-1], {}, "1 of 27 pairs are missing"),
    "not real": (
        ".12d",
        lambda rows: line(2, " ".join([*rows[1].split()[:5], "5 53.1 3 4"]))(rows),
        {},
        "hull.12d:2:1: surge at 0.4 and 0.4 rad/s has the imaginary part",
    ),
    "nothing": (".8", lambda rows: rows[:1], {}, "has no numbers"),
}


@pytest.mark.parametrize("fault", WRONG)
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, fault: str) -> None:
    suffix, change, keys, expected = WRONG[fault]
    path = tmp_path / f"hull{suffix}"
    if suffix == ".12d":
        write_qtf(path, pairs, omega=OMEGA)
    else:
        write_mean(path, mean, omega=OMEGA, directions=AROUND)
    path.write_text("\n".join(change(path.read_text().splitlines())) + "\n")
    with pytest.raises(InputError) as caught:
        read(path, center=SPACE, **keys)
    assert expected in str(caught.value)
    assert len(caught.value.problems) == 1


def test_a_matrix_that_is_not_hermitian(tmp_path: Path) -> None:
    """As that of sums of frequencies, which is symmetric."""

    def symmetric(one: float, other: float, mode: int) -> complex:
        return pairs(one, other, mode) if one >= other else pairs(other, one, mode)

    path = write_qtf(tmp_path / "hull.12d", symmetric, omega=OMEGA, both=True)
    with pytest.raises(InputError, match=r"hull\.12d:\d+:2: surge at 0.4 and 0.7 rad/s is not the"):
        read(path)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("omega,direction,surge,sway\n1,0,1,1\n", "no column 'yaw'"),
        ("omega,direction,surge,sway,yaw\n1,0,1,1,x\n", ":2:1: expected a finite number"),
        ("omega,direction,surge,sway,yaw\n0,0,1,1,1\n", ":2:1: omega 0 rad/s is not positive"),
        ("omega,direction,surge,sway,yaw\n", "has no rows"),
        (
            "omega,direction,surge,sway,yaw\n1,0,1,1,1\n1,90,1,1,1\n2,0,1,1,1\n",
            ":4:1: 3 of 12 values are missing: the first is surge at 2 rad/s, 90 deg",
        ),
    ],
)
def test_wrong_csv_files(tmp_path: Path, text: str, expected: str) -> None:
    path = tmp_path / "hull.csv"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read(path)
    assert expected in str(caught.value)


def test_keys_of_wamit_have_no_effect_on_csv(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'length_scale' has no effect on a CSV file"):
        read(tmp_path / "hull.csv", length_scale=2.0)


def test_no_such_file(tmp_path: Path) -> None:
    (tmp_path / "hull.8").write_text("")
    with pytest.raises(InputError, match=r"did you mean 'hull\.8'"):
        read(tmp_path / "hul.8")


def test_a_moment_needs_the_forces(tmp_path: Path) -> None:
    path = write_qtf(tmp_path / "hull.12d", pairs, omega=OMEGA, modes=(5,))
    with pytest.raises(InputError, match="pitch about another point needs surge"):
        read(path, reference_point=[0.0, 0.0, 1.0])
