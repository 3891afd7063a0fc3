"""Comparison of two records: known differences, interpolation, phase, gaps, units, names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import m4e_fmi
from m4e_fmi.analysis.comparison.alignment import aligned
from m4e_fmi.analysis.comparison.measures import phase
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series

TIME = np.linspace(0.0, 60.0, 1201)
SINE = np.sin(TIME)
FINE = np.linspace(0.0, 10.0, 101)


def results(time: np.ndarray = TIME, unit: str = "m", **values: np.ndarray) -> Results:
    series = {n: Series(n, unit, "", v) for n, v in values.items()}
    return Results(Path("ours.nc"), time, {"buoy": series}, {})


def written(path: Path, head: str, time: np.ndarray, *columns: np.ndarray) -> Path:
    rows = (",".join(map(repr, row)) for row in np.stack([time, *columns], axis=1).tolist())
    path.write_text("\n".join([head, *rows]), encoding="utf-8")
    return path


def test_a_record_beside_itself_differs_by_nothing() -> None:
    one = results(z=SINE, still=0.0 * TIME)
    found = m4e_fmi.compare(one, one, tolerance=0.0)
    assert found.is_within
    assert found.notes == ()
    for each in found.differences.values():
        assert (each.rms, each.largest, each.nrmse, each.interpolated) == (0.0, 0.0, 0.0, "")


def test_measures_of_a_known_difference() -> None:
    """An offset of 0.1 m from a sine of 2 m, beside Eq. (10) written out."""
    found = m4e_fmi.compare(results(z=2.0 * SINE + 0.1), results(z=2.0 * SINE))["buoy.z"]
    assert found.rms == pytest.approx(0.1)
    assert found.largest == pytest.approx(0.1)
    assert found.sizes.range == pytest.approx(4.0, rel=1e-4)
    assert found.rms_share == pytest.approx(0.025, rel=1e-4)
    relative = np.abs(found.values - found.reference) / np.max(np.abs(found.reference))
    assert found.nrmse == pytest.approx(np.sqrt(np.mean(relative**2)), rel=1e-12)
    assert found.offset == pytest.approx(0.1)
    assert found.rms_beside_offset < 1e-12
    assert found.first_beyond(0.02) == 0.0
    assert found.first_beyond(0.03) is None


def test_a_reference_of_zero() -> None:
    """Without a floor any difference is infinite; Eq. (9) has a floor."""
    one, zero = results(z=np.full(len(TIME), 1e-6)), results(z=0.0 * TIME)
    found = m4e_fmi.compare(one, zero, tolerance=1e9)
    assert not found.is_within
    assert np.isinf(found["buoy.z"].nrmse)
    assert m4e_fmi.compare(one, zero, floor=1e-4)["buoy.z"].nrmse == pytest.approx(0.01)


def test_phase_of_an_irregular_record() -> None:
    """A shifted sea: the shift, as all of its lines have it, but for the ends of the record."""

    def sea(time: np.ndarray) -> np.ndarray:
        rng = np.random.default_rng(2)
        omega, angle = np.linspace(0.5, 1.5, 60), rng.uniform(0.0, 2.0 * np.pi, 60)
        return np.cos(np.outer(time, omega) + angle) @ np.exp(-(((omega - 0.8) / 0.15) ** 2))

    time = np.linspace(0.0, 600.0, 6001)
    found = phase(time, 0.9 * sea(time - 0.3), sea(time))
    assert found.time_shift == pytest.approx(0.3, abs=0.03)
    assert found.amplitude_ratio == pytest.approx(0.9, rel=0.01)
    assert 0.0 < found.share < 1.0
    for reference, reason in ((np.ones(len(TIME)), "constant"), (np.sin(0.1 * TIME), "2 periods")):
        assert reason in phase(TIME, TIME, reference).reason


def test_smooth_records_are_interpolated_cubically() -> None:
    """Between rows 0.1 s apart a sine is found to 3/128 (ω h)⁴; the estimate is near the error."""
    fine, coarse = np.linspace(0.0, 60.0, 601), np.linspace(0.03, 59.93, 151)
    found = aligned(coarse, np.sin(coarse), fine, np.sin(fine))
    assert found.interpolated == "cubic"
    assert found.time.tolist() == coarse.tolist()
    error = found.reference - np.sin(coarse)
    assert np.max(np.abs(error)) <= 3.0 / 128.0 * 0.1**4 * 1.01
    assert found.error == pytest.approx(np.sqrt(np.mean(error**2)), rel=1.0)
    back = aligned(fine, np.sin(fine), coarse, np.sin(coarse))
    assert back.time.tolist() == coarse.tolist()
    assert back.values == pytest.approx(found.reference)


def test_jumps_are_interpolated_linearly_and_whole_numbers_hold() -> None:
    """A square wave: no overshoot, as a cubic polynomial has."""
    fine = np.linspace(0.0, 60.0, 601)
    coarse = fine[3:-3:7] + 0.04
    found = aligned(coarse, 0.0 * coarse, fine, np.sign(np.sin(fine + 0.01)))
    assert np.max(np.abs(found.reference)) <= 1.0 + 1e-12
    assert found.interpolated == "linear" or "linear at the others" in found.interpolated
    found = aligned(np.array([0.5, 5.5]), np.zeros(2), FINE, np.floor(FINE / 5.0), held=True)
    assert found.reference.tolist() == [0.0, 1.0]


def test_nothing_is_extrapolated_and_gaps_are_not_bridged() -> None:
    """Values that are lacking, and rows: a step far above the others is a gap."""
    coarse = np.linspace(-5.0, 20.0, 101) + 0.01
    lacking = np.where((FINE > 4.05) & (FINE < 4.55), np.nan, FINE)
    removed = np.delete(FINE, slice(40, 60))
    for time, values, end, count in (
        (FINE, lacking, 4.6, 3),  # 4.01, 4.26, 4.51
        (removed, removed, 6.0, 8),  # 4.01 to 5.76
    ):
        found = aligned(coarse, coarse, time, values)
        assert 0.0 <= found.time.min() < found.time.max() <= 10.0
        assert not np.any((found.time > 3.9) & (found.time < end))
        assert found.left_out == count
        assert found.reference == pytest.approx(found.time)


def test_names_and_units_of_a_table(tmp_path: Path) -> None:
    """Without a component they stand for the only one; a file may say no unit."""
    head = "t [s],Heave [mm],buoy.y,z,w"
    path = written(tmp_path / "tank.csv", head, TIME, 1e3 * SINE, SINE, SINE, SINE)
    ours = results(h=SINE, y=SINE, z=SINE, x=SINE)
    found = m4e_fmi.compare(ours, path, mapping={"Heave [mm]": "buoy.h"})
    assert repr(found) == repr(m4e_fmi.compare(ours, path, mapping={"Heave": "buoy.h"}))
    assert [*found.differences] == ["buoy.h", "buoy.y", "buoy.z"]
    assert max(one.largest for one in found.differences.values()) < 1e-12
    assert "buoy.h: 'Heave' converted from mm to m" in found.notes
    assert "buoy.y: 'buoy.y' says no unit: taken as m" in found.notes
    assert (found.only_here, found.only_there) == (("buoy.x",), ("w",))
    assert any("the only one so called" in note for note in found.notes)


def test_signs_factors_and_origins_are_mapped() -> None:
    """A reference that counts downwards, in another unit, from another time."""
    one = results(z=SINE, force=100.0 * np.cos(TIME))
    columns = {
        "down": Series("down", "mm", "", -1000.0 * SINE + 250.0),
        "kips": Series("kips", "s", "", 0.5 * np.cos(TIME)),
        "kips * 2": Series("kips * 2", "m", "", 100.0 * np.cos(TIME)),
    }
    other = Results(Path("other.nc"), TIME + 1000.0, {"tool": columns}, {})
    for column, name in (
        ("tool.down * -1 + 0.25", "buoy.z"),
        ("tool.kips * 200, units ignored", "buoy.force"),
        ("tool.kips * 2", "buoy.force"),  # which is a name
    ):
        found = m4e_fmi.compare(one, other, mapping={column: name}, time_shift=-1000.0)
        assert found[name].rms < 1e-9
        assert len(found[name].time) == len(TIME)
    assert "other.nc: -1000 s added to its times" in found.notes


def test_a_file_that_ends_early_is_within_no_tolerance() -> None:
    """A run that failed may be within all tolerances until then; a short reference may be met."""
    whole, part = results(z=SINE), results(TIME[:601], z=SINE[:601])
    for one, other, lacking in ((whole, part, ()), (part, whole, ((30.0, 60.0),))):
        for start in (None, 10.0):
            found = m4e_fmi.compare(one, other, tolerance=0.0, start_time=start)
            assert np.ravel(found.lacking) == pytest.approx(np.ravel(lacking))
            assert found.is_within == (not lacking)
            assert found.beyond == ()
            assert found.notes[0].startswith("only ")
        chosen = m4e_fmi.compare(one, other, stop_time=30.0, tolerance=0.0)
        assert (chosen.notes, chosen.is_within) == ((), True)
        assert m4e_fmi.compare(one, other).is_within  # without a tolerance
    late = results(TIME[200:], z=SINE[200:])
    assert m4e_fmi.compare(late, whole, tolerance=0.0).lacking == ((0.0, 10.0),)
    reference = results(TIME[::240], z=SINE[::240])  # 12 s apart
    found = m4e_fmi.compare(results(TIME[:901], z=SINE[:901]), reference, tolerance=0.0)
    assert found.lacking == ((45.0, 60.0),)  # two fifths of its rows
    assert m4e_fmi.compare(results(TIME[:1151], z=SINE[:1151]), reference).lacking == ()
    assert m4e_fmi.compare(whole, results(TIME[:-2], z=SINE[:-2])).notes == ()


def test_customary_units_of_a_reference(tmp_path: Path) -> None:
    for own, other, factor in (
        ("m", "ft", 0.3048), ("N", "kip", 4448.2216152605), ("Pa", "psi", 6894.757293168),
        ("rad", "deg", np.pi / 180), ("rad/s", "rpm", np.pi / 30), ("kg", "lb", 0.45359237),
        ("kg", "g", 1e-3), ("t", "kt", 1e3),
    ):  # fmt: skip
        path = written(tmp_path / "tool.csv", f"time [s],x [{other}]", TIME, SINE)
        found = m4e_fmi.compare(results(unit=own, x=factor * SINE), path)
        assert found["buoy.x"].largest < 1e-9 * factor, (own, other)
        assert any(f"'x' converted from {other} to {own}" in note for note in found.notes)
    for other, told in (("g", "of different dimension"), ("ton", "not a unit known here")):
        path = written(tmp_path / "tool.csv", f"time [s],x [{other}]", TIME, SINE)
        with pytest.raises(InputError, match=told):
            m4e_fmi.compare(results(x=TIME), path)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_values_that_are_lacking_are_within_no_tolerance(bad: float) -> None:
    """A run that grew without bound does not pass as a test; a gap in the reference is none."""
    broken = results(z=np.where(TIME < 20.0, SINE, bad))
    coarse = TIME[::7]  # of the reference: ours are interpolated
    for reference in (results(z=SINE), results(coarse, z=SINE[::7])):
        found = m4e_fmi.compare(broken, reference, tolerance=0.01)
        assert found["buoy.z"].lacking == int(np.sum(reference.time >= 20.0))
        assert found.beyond == ("buoy.z",)
        assert any("no finite value in" in note for note in found.notes)
    back = m4e_fmi.compare(results(z=SINE), broken, tolerance=0.01)
    assert (back["buoy.z"].lacking, back.is_within) == (0, True)
    empty = m4e_fmi.compare(results(z=SINE), results(z=np.full(len(TIME), bad)), tolerance=1e9)
    assert empty.beyond == ("buoy.z",)
    assert any("no rows in common" in note for note in empty.notes)


def test_rows_that_are_missing_are_within_no_tolerance() -> None:
    """A gap without rows makes the record the coarser one: the rest alone does not pass."""
    kept = (TIME < 20.0) | (TIME > 40.0)
    whole, part, gone = results(z=SINE), results(TIME[kept], z=SINE[kept]), int(np.sum(~kept))
    found = m4e_fmi.compare(part, whole, tolerance=0.01)
    assert (found["buoy.z"].lacking, found["buoy.z"].left_out) == (gone, gone)
    assert found.beyond == ("buoy.z",)
    assert any(f"no finite value in {gone} rows" in note for note in found.notes)
    back = m4e_fmi.compare(whole, part, tolerance=0.01)
    assert (back["buoy.z"].lacking, back["buoy.z"].left_out, back.is_within) == (0, gone, True)
    assert any(f"{gone} rows left out" in note for note in back.notes)
    even = m4e_fmi.compare(results(TIME[::9], z=SINE[::9]), whole, tolerance=0.01)
    assert (even["buoy.z"].lacking, even["buoy.z"].left_out) == (0, 0)
