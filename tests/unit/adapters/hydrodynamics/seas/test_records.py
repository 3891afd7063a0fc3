"""Files of waves: units of columns; records at their place, and doubts about them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap, Record
from m4e_adapters.hydrodynamics.config.waves import AnyWaves, SpectrumTable
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, elevation
from m4e_adapters.hydrodynamics.seas.wave_files import read_density, read_record
from m4e_adapters.hydrodynamics.seas.waves import TAPERED
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


"""Rows (n,) [m] of a sea of Hs 2.5 m, in steps of 0.5 s."""
