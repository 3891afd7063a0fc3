"""Files of drift: units, bodies, conventions and the point of the moments."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.drift_files import RHO, G, write_mean, write_qtf

from m4e_adapters.hydrodynamics.config import Drift, Water
from m4e_adapters.hydrodynamics.drift.far_field import write_csv
from m4e_adapters.hydrodynamics.drift.files import read_drift
from m4e_adapters.hydrodynamics.drift.tables import MeanDrift, Qtf

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


def test_length_scale_body_and_plane(tmp_path: Path) -> None:
    path = write_mean(
        tmp_path / "hull.9", mean, omega=OMEGA, directions=AROUND, modes=range(1, 13), ulen=20.0
    )
    table = read(path, body=2, length_scale=20.0)
    expected = [[[mean(w, beta, m) for m in (7, 8, 12)] for beta in AROUND] for w in OMEGA]
    assert table.values == pytest.approx(np.array(expected), abs=1e-5)
    assert "heave, roll and pitch are left out" in table.notes[0]
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=(0.0, 180.0))
    table = read(path, center=(0.0, -2.0))
    assert [motion.name for motion in table.motions] == ["surge"]
    assert table.values.shape == (3, 2, 1)


def test_a_csv_file_is_as_it_was_written_and_pairs_of_directions_are_left_out(
    tmp_path: Path,
) -> None:
    path = write_mean(tmp_path / "hull.8", mean, omega=OMEGA, directions=AROUND)
    with path.open("a") as file:
        file.write("  5.0 0.0 45.0 1 9.0 0.0 9.0 0.0\n")
    table = read(path)
    assert isinstance(table, MeanDrift)
    assert table.notes == ("1 rows of pairs of directions are left out",)
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
