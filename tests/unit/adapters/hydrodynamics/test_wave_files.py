"""Tables of waves: units in the names of columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config.waves import Record, SpectrumTable
from m4e_adapters.hydrodynamics.seas.wave_files import read_density, read_record
from m4e_fmi.errors import InputError


def table(folder: Path, header: str, rows: np.ndarray) -> None:
    lines = [header, *(",".join(f"{v:.12g}" for v in row) for row in rows)]
    (folder / "w.csv").write_text("\n".join(lines), "utf-8")


def test_units_of_a_record(tmp_path: Path) -> None:
    time = np.arange(40.0)
    table(tmp_path, "time [ms],elevation [mm]", np.stack([1e3 * time, 500 * np.sin(time)], 1))
    found = read_record(Record(spectrum="record", file="w.csv"), tmp_path)
    assert found.interval == pytest.approx(1.0)
    assert found.elevation == pytest.approx(0.5 * np.sin(time))


def test_units_of_a_spectrum(tmp_path: Path) -> None:
    rows = np.array([[0.1, 0.0], [0.2, 2.0], [0.3, 0.0]])
    section = SpectrumTable(spectrum="table", file="w.csv")
    table(tmp_path, "frequency [Hz],density [cm2/Hz]", rows * [1, 1e4])
    found = read_density(section, tmp_path)
    assert found.omega == pytest.approx(2 * np.pi * rows[:, 0])
    assert found.density == pytest.approx(rows[:, 1] / (2 * np.pi))
    table(tmp_path, "omega [rad/s],density [m2/Hz]", rows)
    with pytest.raises(InputError, match=r"'density \[m2/Hz\]' is not in a unit of m2.s/rad"):
        read_density(section, tmp_path)
