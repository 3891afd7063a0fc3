"""Files of waves: units of columns; records at their place, and doubts about them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap, Record
from m4e_adapters.hydrodynamics.config.waves import AnyWaves, SpectrumTable
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.spectra import TAPERED
from m4e_adapters.hydrodynamics.seas.system_seas import components_of, lines_on
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, elevation
from m4e_adapters.hydrodynamics.seas.wave_files import read_density, read_record
from m4e_adapters.sea import SeaConfig, sea_program
from m4e_fmi.files.document import Document
from m4e_fmi.program import evaluated


def write(path: Path, rows: np.ndarray, header: str = "time,elevation") -> Path:
    lines = [header, *(",".join(f"{v:.15g}" for v in row) for row in rows)]
    path.write_text("\n".join(lines), "utf-8")
    return path


def test_units_of_columns(tmp_path: Path) -> None:
    time = np.arange(40.0)
    rows = np.stack([1e3 * time, 500 * np.sin(time)], 1)
    write(tmp_path / "r.csv", rows, "time [ms],elevation [mm]")
    record = read_record(Record(spectrum="record", file="r.csv"), tmp_path)
    assert record.interval == pytest.approx(1.0)
    assert record.elevation == pytest.approx(0.5 * np.sin(time))
    rows = np.array([[0.1, 0.0], [0.2, 2.0], [0.3, 0.0]])
    write(tmp_path / "s.csv", rows * [1, 1e4], "frequency [Hz],density [cm2/Hz]")
    spectrum = read_density(SpectrumTable(spectrum="table", file="s.csv"), tmp_path)
    assert spectrum.omega == pytest.approx(2 * np.pi * rows[:, 0])
    assert spectrum.density == pytest.approx(rows[:, 1] / (2 * np.pi))


def systems(waves: AnyWaves, folder: Path = Path()) -> tuple[WaveSystem, ...]:
    return wave_systems(waves, depth=math.inf, gravity=9.81, folder=folder)


def jonswap(height: float = 2.5, period: float = 8.0) -> Components:
    waves = Jonswap(spectrum="jonswap", significant_height=height, peak_period=period, seed=5)
    return components_of(systems(waves), {})


def test_a_record_is_reproduced_at_its_place_and_50_m_on(tmp_path: Path) -> None:
    """Within 1e-3 of its deviation, between its rows too. The shortest waves, of 12 peak
    frequencies, travel 50 m in 96 s: there from a fifth of the record on."""
    sea, times = jonswap(), 20.0 + 0.25 * np.arange(2400)
    write(tmp_path / "r.csv", np.stack([times, elevation(sea, times, 12.0)], 1))
    waves = Record(spectrum="record", file="r.csv", place=(12.0,))
    found = components_of(systems(waves, tmp_path), {})
    deviation = 2.5 / 4
    t = np.linspace(20.0 + 600 * (TAPERED + 0.01), 620.0 - 600 * (TAPERED + 0.01), 3001)
    there = elevation(found, t, 12.0) - elevation(sea, t, 12.0)
    assert np.abs(there).max() < 1e-3 * deviation
    late = t[t > 20.0 + 120.0][:-400]
    on = elevation(found, late, 62.0) - elevation(sea, late, 62.0)
    assert np.abs(on).max() < 1e-3 * deviation


def test_a_record_of_another_direction_is_at_its_place_still(tmp_path: Path) -> None:
    sea, times = jonswap(), 0.25 * np.arange(2400)
    write(tmp_path / "r.csv", np.stack([times, elevation(sea, times, 0.0)], 1))
    waves = "{spectrum: record, file: r.csv, place: [30, -8], direction: 70}"
    text = f"dimensions: 3\nwaves: {waves}\npoints: {{p: [30, -8, 0]}}\n"
    config = Document.parse(text).validate(SeaConfig)
    found = components_of(systems(config.waves, tmp_path), {})
    t = np.linspace(40.0, 560.0, 501)
    error = elevation(found, t, 30.0, -8.0) - elevation(sea, t, 0.0)
    assert np.abs(error).max() < 1e-3 * 2.5 / 4
    program = sea_program(config, name="s", folder=tmp_path)
    index = program.results[[v.name for v in program.outputs].index("p.elevation")]
    for turned in (math.radians(70.0), 1.0):  # the place keeps its record when the waves turn
        known = {**{v.name: v.start for v in program.parameters}, "wave.direction": turned}
        (value,) = evaluated(program.tape, [index], {**known, "time": 200.0}).values()
        assert value == pytest.approx(float(elevation(sea, 200.0, 0.0)), abs=1e-3)


def recorded(
    folder: Path, rows: np.ndarray, *, start: float = 0.0, step: float = 0.5
) -> WaveSystem:
    """A record with `rows` (n,) [m] in steps of `step` [s]."""
    times = start + step * np.arange(len(rows))
    write(folder / "r.csv", np.stack([times, rows], 1))
    (system,) = systems(Record(spectrum="record", file="r.csv"), folder)
    return system


MEASURED = elevation(jonswap(), 0.5 * np.arange(2400), 0.0)
"""Rows (n,) [m] of a sea of Hs 2.5 m, in steps of 0.5 s."""


def changed(first: int, last: int, value: float) -> np.ndarray:
    rows = MEASURED.copy()
    rows[first:last] = value
    return rows


@pytest.mark.parametrize(
    ("rows", "keys", "told"),
    [
        (MEASURED, {}, []),
        (
            changed(1000, 1001, 12.0),
            {},
            ["the farthest 12 m at t = 500 s", "% of its energy in waves of less than 2.5 rows"],
        ),
        (changed(1200, 1260, 0.25), {}, ["is 0.25 m from t = 600 to 629.5 s"]),
        # at t = 0 it is 5 times 1200 s - 5000 s = 1000 s after its first row
        (MEASURED, {"start": 5000.0}, ["repeats itself: at t = 0 s the sea is that of 1000 s"]),
        # a mean, and steps of 1 s in a sea of 4 s
        (
            elevation(jonswap(1.0, 4.0), np.arange(300.0), 0.0) + 0.1,
            {"step": 1.0},
            ["the mean of r.csv, 0.1", "% of its energy in waves of less than 2.5 rows"],
        ),
    ],
    ids=["none", "a spike", "a value that stands still", "a late start", "coarse"],
)
def test_doubts_about_a_record(
    rows: np.ndarray, keys: dict[str, float], told: list[str], tmp_path: Path
) -> None:
    system = recorded(tmp_path, rows, **keys)
    found = system.doubts({})
    assert len(found) == len(told)
    for text, said in zip(found, told, strict=True):
        assert said in text
    warnings = [line for line in lines_on([system]) if line.startswith("warning: ")]
    assert warnings == [f"warning: {text}" for text in found]


def test_the_ends_of_a_record_are_told_with_the_energy_that_they_lose(tmp_path: Path) -> None:
    """Half cosines leave 3/8 of the energy of two twentieths. Every record has them: no warning."""
    system = recorded(tmp_path, np.sin(2 * math.pi * 0.05 * np.arange(2400)))
    (told,) = system.notes()
    assert [*lines_on([system])] == [told]
    assert "r.csv is 1200 s long, repeats itself, and is tapered to 0 for 60 s at each" in told
    assert "takes 6.3 % of its energy" in told  # 2 times 0.05 times 5/8 is 6.25 %
    assert told.endswith("take t = 60 to 1140 s")
