"""Comparison of two records: known differences, interpolation, phase, gaps, units, names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import m4e_fmi
from m4e_fmi.analysis.comparison.alignment import aligned
from m4e_fmi.analysis.comparison.measures import normalised, phase, scales
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Series

TIME = np.linspace(0.0, 60.0, 1201)
OMEGA = 0.9


def results(
    time: np.ndarray,
    folder: Path = Path(),
    name: str = "ours.nc",
    unit: str = "m",
    **values: np.ndarray,
) -> Results:
    series = {n: Series(n, unit, "", v) for n, v in values.items()}
    return Results(folder / name, time, {"buoy": series}, {})


def test_a_record_beside_itself_differs_by_nothing() -> None:
    one = results(TIME, z=np.sin(TIME), still=0.0 * TIME)
    found = m4e_fmi.compare(one, one, tolerance=0.0)
    assert found.is_within
    assert found.notes == ()
    for each in found.differences.values():
        assert (each.rms, each.largest, each.nrmse, each.interpolated) == (0.0, 0.0, 0.0, "")


def test_measures_of_a_known_difference() -> None:
    """An offset of 0.1 m from a sine of 2 m, beside Eq. (10) written out."""
    reference = 2.0 * np.sin(TIME)
    found = m4e_fmi.compare(
        results(TIME, z=reference + 0.1), results(TIME, z=reference), tolerance=0.02
    )["buoy.z"]
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


def test_another_origin_is_noted() -> None:
    reference = np.sin(TIME)
    shifted = m4e_fmi.compare(results(TIME, z=1.05 * reference - 2.0), results(TIME, z=reference))
    assert "buoy.z: differs by -1.99" in shifted.notes[0]
    scaled = m4e_fmi.compare(results(TIME, z=1.05 * reference), results(TIME, z=reference))
    assert scaled.notes == ()


def test_differences_are_divided_as_asked() -> None:
    time = np.linspace(0.0, 20.0 * np.pi, 2001)
    reference = 3.0 + np.cos(time)
    for name, scale in (("range", 2.0), ("amplitude", 1.0), ("value", 4.0)):
        found = m4e_fmi.compare(
            results(time, z=reference + 0.1), results(time, z=reference), relative_to=name
        )["buoy.z"]
        assert found.largest_share == pytest.approx(0.1 / scale, rel=1e-6)


def test_a_reference_of_zero() -> None:
    """Without a floor any difference is infinite; Eq. (9) has a floor."""
    one, zero = results(TIME, z=np.full(len(TIME), 1e-6)), results(TIME, z=0.0 * TIME)
    found = m4e_fmi.compare(one, zero, tolerance=1e9)
    assert not found.is_within
    assert np.isinf(found["buoy.z"].nrmse)
    assert m4e_fmi.compare(one, zero, floor=1e-4)["buoy.z"].nrmse == pytest.approx(0.01)
    assert normalised(np.array([0.0, 1.0]), 0.0).tolist() == [0.0, np.inf]


@pytest.mark.parametrize("shift", [-1.0, 0.2, 2.5])
@pytest.mark.parametrize("ratio", [0.7, 1.0, 1.3])
def test_phase_and_amplitude_of_a_sine_are_exact(shift: float, ratio: float) -> None:
    reference = 1.0 + 2.0 * np.sin(OMEGA * TIME)
    values = 5.0 + 2.0 * ratio * np.sin(OMEGA * (TIME - shift))
    found = phase(TIME, values, reference)
    assert found.period == pytest.approx(2.0 * np.pi / OMEGA, rel=1e-6)
    assert found.amplitude_ratio == pytest.approx(ratio, rel=1e-6)
    assert found.time_shift == pytest.approx(shift, abs=1e-5)
    assert found.share == pytest.approx(1.0, abs=1e-6)


def test_phase_of_an_irregular_record() -> None:
    """A shifted sea: the shift, as all of its lines have it, but for the ends of the record."""

    def sea(time: np.ndarray) -> np.ndarray:
        rng = np.random.default_rng(2)
        omega, angle = np.linspace(0.5, 1.5, 60), rng.uniform(0.0, 2.0 * np.pi, 60)
        size = np.exp(-(((omega - 0.8) / 0.15) ** 2))
        return np.cos(np.outer(time, omega) + angle) @ size

    time = np.linspace(0.0, 600.0, 6001)
    found = phase(time, 0.9 * sea(time - 0.3), sea(time))
    assert found.time_shift == pytest.approx(0.3, abs=0.03)
    assert found.amplitude_ratio == pytest.approx(0.9, rel=0.01)
    assert 0.0 < found.share < 1.0


def test_no_phase_has_a_reason() -> None:
    assert "constant" in phase(TIME, TIME, np.ones(len(TIME))).reason
    assert "2 periods" in phase(TIME, TIME, np.sin(0.1 * TIME)).reason
    assert "needed" in phase(TIME[:5], TIME[:5], TIME[:5]).reason


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


def test_jumps_are_interpolated_linearly() -> None:
    """A square wave: no overshoot, as a cubic polynomial has."""
    fine = np.linspace(0.0, 60.0, 601)
    square = np.sign(np.sin(fine + 0.01))
    coarse = fine[3:-3:7] + 0.04
    found = aligned(coarse, 0.0 * coarse, fine, square)
    assert np.max(np.abs(found.reference)) <= 1.0 + 1e-12
    assert found.interpolated == "linear" or "linear at the others" in found.interpolated


def test_nothing_is_extrapolated_and_gaps_are_not_bridged() -> None:
    fine = np.linspace(0.0, 10.0, 101)
    values = np.where((fine > 4.05) & (fine < 4.55), np.nan, fine)
    coarse = np.linspace(-5.0, 20.0, 101) + 0.01
    found = aligned(coarse, coarse, fine, values)
    assert found.time.min() >= 0.0
    assert found.time.max() <= 10.0
    assert not np.any((found.time > 4.0) & (found.time < 4.6))
    assert found.left_out == 3  # 4.01, 4.26, 4.51
    assert found.reference == pytest.approx(found.time)


def test_long_steps_are_gaps() -> None:
    fine = np.delete(np.linspace(0.0, 10.0, 101), slice(40, 60))
    coarse = np.linspace(0.0, 10.0, 21) + 0.01
    found = aligned(coarse, coarse, fine, fine)
    assert found.left_out == 4  # 4.01 to 5.51
    assert not np.any((found.time > 3.9) & (found.time < 6.0))


def test_whole_numbers_hold() -> None:
    fine = np.linspace(0.0, 1.0, 11)
    found = aligned(np.array([0.05, 0.55]), np.zeros(2), fine, np.floor(fine * 2.0), held=True)
    assert found.reference.tolist() == [0.0, 1.0]


def test_units_of_a_table_are_converted(tmp_path: Path) -> None:
    table = tmp_path / "tank.csv"
    rows = "\n".join(f"{t:.3f},{1e3 * np.sin(t):.9g},{np.sin(t):.9g}" for t in TIME)
    table.write_text(f"t [s],Heave [mm],buoy.y\n{rows}\n")
    ours = results(TIME, z=np.sin(TIME), y=np.sin(TIME))
    found = m4e_fmi.compare(ours, table, mapping={"Heave [mm]": "buoy.z"})
    assert repr(found) == repr(m4e_fmi.compare(ours, table, mapping={"Heave": "buoy.z"}))
    assert found["buoy.z"].largest < 1e-9 * 2.0
    assert "buoy.z: 'Heave' converted from mm to m" in found.notes
    assert "buoy.y: 'buoy.y' says no unit: taken as m" in found.notes


def test_names_without_a_component_stand_for_the_only_one(tmp_path: Path) -> None:
    table = tmp_path / "other.csv"
    table.write_text("t,z,w\n" + "\n".join(f"{t},{t},{t}" for t in TIME))
    found = m4e_fmi.compare(results(TIME, z=TIME, y=TIME), table)
    assert list(found.differences) == ["buoy.z"]
    assert (found.only_here, found.only_there) == (("buoy.y",), ("w",))
    assert any("the only one so called" in note for note in found.notes)


def test_only_the_part_between_two_times_counts() -> None:
    other = np.where(TIME < 10.0, 9.0, np.sin(TIME))
    one, reference = results(TIME, z=np.sin(TIME)), results(TIME, z=other)
    found = m4e_fmi.compare(one, reference, start_time=10.0, stop_time=20.0)["buoy.z"]
    assert (found.time[0], found.time[-1], found.largest) == (10.0, 20.0, 0.0)


def test_wrong_requests_are_refused_together() -> None:
    one, late = results(TIME, z=TIME), results(TIME + 100.0, z=TIME)
    with pytest.raises(InputError, match=r"no time in common: ours\.nc has 0 to 60 s"):
        m4e_fmi.compare(one, late)
    with pytest.raises(InputError, match="no variable has the same name"):
        m4e_fmi.compare(one, results(TIME, w=TIME))
    with pytest.raises(InputError, match="m and kg are of different dimension"):
        m4e_fmi.compare(one, results(TIME, unit="kg", z=TIME))
    with pytest.raises(InputError) as caught:
        m4e_fmi.compare(one, one, mapping={"buoy.zz": "buoy.z"}, variables=["buoy.y"])
    assert len(caught.value.problems) == 2
    with pytest.raises(InputError) as caught:
        m4e_fmi.compare(one, one, tolerance=-1.0, relative_to="rnage", start_time=2.0, stop_time=1)
    assert len(caught.value.problems) == 3


def test_a_record_of_gaps_is_not_within() -> None:
    reference = results(TIME, z=np.full(len(TIME), np.nan))
    found = m4e_fmi.compare(results(TIME, z=TIME), reference, tolerance=1e9)
    assert found.beyond == ("buoy.z",)
    assert any("no rows in common" in note for note in found.notes)


def test_comparisons_are_shown_in_a_few_lines() -> None:
    many = {f"v{k}": np.sin(TIME + 0.001 * k) for k in range(50)}
    one = results(TIME, Path(), "ours.nc", "m", **many)
    other = results(TIME, v0=TIME, v9=np.sin(TIME))
    found = m4e_fmi.compare(one, other, tolerance=0.1)
    assert repr(found).startswith("Comparison of 'ours.nc' with 'ours.nc', beyond the tolerance of")
    assert len(repr(found).splitlines()) <= 20
    assert "rows" in repr(found["buoy.v9"])
    assert found.worst[0].name == "buoy.v0"


def test_sizes_of_one_row() -> None:
    found = scales(np.array([1.0]), np.array([-2.0]))
    assert (found.range, found.amplitude, found.value) == (0.0, 0.0, 2.0)


def test_signs_factors_and_origins_are_mapped() -> None:
    """A reference that counts downwards, in another unit, from another time."""
    one = results(TIME, z=np.sin(TIME), force=100.0 * np.cos(TIME))
    other = Results(
        Path("other.nc"),
        TIME + 1000.0,
        {
            "tool": {
                "down": Series("down", "mm", "", -1000.0 * np.sin(TIME) + 250.0),
                "kips": Series("kips", "s", "", 0.5 * np.cos(TIME)),
                "kips * 2": Series("kips * 2", "m", "", np.cos(TIME)),
            }
        },
        {},
    )
    mapping = {
        "tool.down * -1 + 0.25": "buoy.z",
        "tool.kips * 200, units ignored": "buoy.force",
    }
    found = m4e_fmi.compare(one, other, mapping=mapping, time_shift=-1000.0)
    for name in ("buoy.z", "buoy.force"):
        assert found[name].rms < 1e-9
        assert len(found[name].time) == len(TIME)
    assert "other.nc: -1000 s added to its times" in found.notes
    assert "buoy.z: 'tool.down' * -1 + 0.25" in found.notes
    whole = m4e_fmi.compare(one, other, mapping={"tool.kips * 2": "buoy.force"}, time_shift=-1000.0)
    assert whole["buoy.force"].reference_name == "tool.kips * 2"
    with pytest.raises(InputError, match=r"no time in common.*\n.*--time-shift"):
        m4e_fmi.compare(one, other, mapping=mapping)
    with pytest.raises(InputError, match=r"no time in common from 900 s"):
        m4e_fmi.compare(one, one, start_time=900.0)
    with pytest.raises(InputError, match=r"expected no factor 0"):
        m4e_fmi.compare(one, other, mapping={"tool.down * 0": "buoy.z"}, time_shift=-1000.0)


def test_a_file_that_ends_early_is_within_no_tolerance() -> None:
    """A run that failed may be within all tolerances until then; a short reference may be met."""
    whole, part = results(TIME, z=np.sin(TIME)), results(TIME[:601], z=np.sin(TIME[:601]))
    for one, other, lacking in ((whole, part, ()), (part, whole, ((30.0, 60.0),))):
        found = m4e_fmi.compare(one, other, tolerance=0.0)
        assert np.ravel(found.lacking) == pytest.approx(np.ravel(lacking))
        assert found.is_within == (not lacking)
        assert found.beyond == ()
        assert found.notes[0].startswith("only 0 to 30 s are in both files: ours.nc 0 to ")
        chosen = m4e_fmi.compare(one, other, stop_time=30.0, tolerance=0.0)
        assert chosen.notes == ()
        assert chosen.is_within
        late = m4e_fmi.compare(one, other, start_time=10.0, tolerance=0.0)
        assert late.notes != ()
        assert late.is_within == (not lacking)
        assert m4e_fmi.compare(one, other).is_within  # without a tolerance
    late = results(TIME[200:], z=np.sin(TIME[200:]))
    assert m4e_fmi.compare(late, whole, tolerance=0.0).lacking == ((0.0, 10.0),)
    few = TIME[::240]  # 12 s apart, two of which are two fifths of the reference
    reference = results(few, z=np.sin(few))
    found = m4e_fmi.compare(results(TIME[:901], z=np.sin(TIME[:901])), reference, tolerance=0.0)
    assert found.lacking == ((45.0, 60.0),)
    assert m4e_fmi.compare(results(TIME[:1151], z=np.sin(TIME[:1151])), reference).lacking == ()
    assert m4e_fmi.compare(whole, results(TIME[:-2], z=np.sin(TIME[:-2]))).notes == ()


def test_customary_units_of_a_reference(tmp_path: Path) -> None:
    """A second meaning of g, lb and kt is taken where only that one fits, and this is told."""
    units = {"m": "ft", "N": "kip", "Pa": "psi", "rad": "deg", "rad/s": "rpm", "kg": "lb"}
    factors = {"ft": 0.3048, "kip": 4448.2216152605, "psi": 6894.757293168, "lb": 0.45359237,
               "deg": np.pi / 180, "rpm": np.pi / 30}  # fmt: skip
    second = (
        ("N", "lb", 4.4482216152605, "lbf"),
        ("m/s2", "g", 9.80665, "standard gravity"),
        ("m/s", "kt", 1852 / 3600, "knots"),
        ("kg", "g", 1e-3, ""),
        ("t", "kt", 1e3, ""),
    )
    cases = [(own, other, factors[other], "") for own, other in units.items()]
    path = tmp_path / "tool.csv"
    for own, other, factor, taken in (*cases, *second):
        rows = [f"{t!r},{v!r}" for t, v in zip(TIME.tolist(), np.sin(TIME).tolist(), strict=True)]
        path.write_text("\n".join([f"time [s],x [{other}]", *rows]), encoding="utf-8")
        ours = results(TIME, unit=own, x=factor * np.sin(TIME))
        found = m4e_fmi.compare(ours, path)
        assert found["buoy.x"].largest < 1e-9 * factor, (own, other)
        assert any(f"'x' converted from {other} to {own}" in note for note in found.notes)
        assert any(f"{other} taken as {taken}" in n for n in found.notes) == bool(taken)
    for other, told in (("g", "of different dimension"), ("ton", "not a unit known here")):
        path.write_text(f"time [s],x [{other}]\n0,1\n1,2\n2,3\n", encoding="utf-8")
        with pytest.raises(InputError, match=told):
            m4e_fmi.compare(results(TIME, unit="m", x=TIME), path)


def test_two_records_with_dates_are_compared_at_their_dates(tmp_path: Path) -> None:
    """The reference begins 2 s later; an offset from UTC in one only leaves that open."""

    def logger(name: str, first: int, zone: str = "") -> Path:
        rows = [f"2026-03-01 12:00:{first + k:02d}.000{zone},{(first + k) ** 2}" for k in range(20)]
        path = tmp_path / name
        path.write_text("\n".join(["TIMESTAMP,x [m]", *rows]), encoding="utf-8")
        return path

    found = m4e_fmi.compare(logger("a.csv", 0), logger("b.csv", 2))
    assert found["x"].largest == 0.0
    assert len(found["x"].time) == 18
    assert any("its times count from the first row of a.csv" in note for note in found.notes)
    found = m4e_fmi.compare(logger("a.csv", 0), logger("b.csv", 2, "Z"))
    assert found["x"].largest == 21.0**2 - 19.0**2
    assert any("each counts from its own first row" in note for note in found.notes)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_values_that_are_lacking_are_within_no_tolerance(bad: float) -> None:
    """A run that grew without bound does not pass as a test; a gap in the reference is none."""
    right = np.sin(TIME)
    broken = np.where(TIME < 20.0, right, bad)
    found = m4e_fmi.compare(results(TIME, z=broken), results(TIME, z=right), tolerance=0.01)
    assert found["buoy.z"].lacking == int(np.sum(TIME >= 20.0))
    assert found.beyond == ("buoy.z",)
    assert any("no finite value in" in note for note in found.notes)
    back = m4e_fmi.compare(results(TIME, z=right), results(TIME, z=broken), tolerance=0.01)
    assert back["buoy.z"].lacking == 0
    assert back.is_within
    coarse = TIME[::7]  # of the reference: ours are interpolated
    found = m4e_fmi.compare(results(TIME, z=broken), results(coarse, z=right[::7]), tolerance=0.01)
    assert found["buoy.z"].lacking == int(np.sum(coarse >= 20.0))


def test_rows_that_are_missing_are_within_no_tolerance() -> None:
    """A gap without rows makes the record the coarser one: the rest alone does not pass."""
    kept = (TIME < 20.0) | (TIME > 40.0)
    whole, part = results(TIME, z=np.sin(TIME)), results(TIME[kept], z=np.sin(TIME[kept]))
    found = m4e_fmi.compare(part, whole, tolerance=0.01)
    gone = int(np.sum(~kept))
    assert (found["buoy.z"].lacking, found["buoy.z"].left_out) == (gone, gone)
    assert found.beyond == ("buoy.z",)
    assert any(f"no finite value in {gone} rows" in note for note in found.notes)
    back = m4e_fmi.compare(whole, part, tolerance=0.01)
    assert (back["buoy.z"].lacking, back["buoy.z"].left_out) == (0, gone)
    assert back.is_within
    assert any(f"{gone} rows left out" in note for note in back.notes)
    even = m4e_fmi.compare(results(TIME[::9], z=np.sin(TIME[::9])), whole, tolerance=0.01)
    assert (even["buoy.z"].lacking, even["buoy.z"].left_out) == (0, 0)
