"""Systems as their files and arguments give them (mistakes: tests/corpus/system_file.yaml)."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main
from m4e_fmi.cosim import Component, FmuFile, Kind, Simulation, load_system
from m4e_fmi.cosim.system.component import KIND_GROUP, kinds
from m4e_fmi.cosim.system.processes import Limits
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import load

GOOD = """\
name: pair
description: a mass on a spring
components:
  body: {fmu: mass.fmu, start: {body.m.x: 1.0}, step_size: 1/3 ms}
  total: {kind: sum, inputs: [one], unit: N, start: {one: 0.5}}
connections:
  - body.m <-> total.one
buses: {b: {x: '1', y.z: m}}
simulation: {start_time: -500 ms, stop_time: 1/6 min, step_size: 100 ms, output_interval: 0.5 s}
"""
PENDULUM = Path(__file__).parents[4] / "examples/double_pendulum/double_pendulum.model.yaml"


def test_a_good_file_is_understood(tmp_path: Path) -> None:
    path = tmp_path / "system.yaml"
    path.write_text(GOOD)
    (tmp_path / "mass.fmu").touch()
    read = load_system(path)
    body, total = read.components
    assert (read.name, read.folder) == ("pair", tmp_path)
    assert body.source == FmuFile(tmp_path / "mass.fmu")
    assert (dict(body.start), body.step_size) == ({"body.m.x": 1.0}, "1/3 ms")
    assert isinstance(total.source, Kind)
    assert total.source.name == "sum"
    assert dict(total.start) == {"one": 0.5}
    assert read.connections == ("body.m <-> total.one",)
    assert read.buses == {"b": {"x": "1", "y.z": "m"}}
    assert read.simulation == Simulation(10.0, 0.1, output_interval=0.5, start_time=-0.5)


def test_what_is_given_in_python_is_checked_too() -> None:
    given = FmuFile(Path("mass.fmu"))
    for wrong, match in (
        (lambda: Simulation(stop_time=0, step_size=0.1), "stop_time"),
        (lambda: Simulation(1, 0.1, algorithm="gauss_sidel"), "did you mean 'gauss_seidel'"),
        (lambda: Component("a", given, process="there"), "'there' is unknown"),
        (lambda: Component("a", given, process="here", limits=Limits(call=1.0)), "no limits"),
    ):
        with pytest.raises(InputError, match=match):
            wrong()


def test_kinds_are_known_as_soon_as_they_are_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a folder that was looked into before, too."""
    monkeypatch.syspath_prepend(str(tmp_path))
    assert {"table", "sea"} <= set(kinds())
    assert "late" not in kinds()
    info = tmp_path / "late-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: late\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{KIND_GROUP}]\nlate = late.kind\n")
    assert kinds()["late"].value == "late.kind"
    monkeypatch.undo()
    assert "late" not in kinds()


def test_a_simulation_is_written_as_csv_too(tmp_path: Path) -> None:
    path = tmp_path / "swing.csv"
    command = ["simulate", str(PENDULUM), "--stop-time", "0.1", "--no-plot"]
    assert main([*command, "--output-file", str(path)]) == 0
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    results = load(path.with_suffix(".nc"))
    series = results.series
    assert header == ["time [s]", *(f"{name} [{one.unit}]" for name, one in series.items())]
    table = np.array(rows, dtype=float)
    assert np.array_equal(table[:, 0], results.time)
    assert np.array_equal(table[:, 1:].T, [one.values for one in series.values()])
