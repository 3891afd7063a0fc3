"""Systems as their files and arguments give them (mistakes: tests/corpus/system_file.yaml)."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.cosim import FmuFile, Kind, Simulation, load_system
from m4e_fmi.cosim.system.component import KIND_GROUP, kinds

GOOD = """\
name: pair
description: a mass on a spring
components:
  body: {fmu: mass.fmu, start: {body.m.x: 1.0}, step_size: 1/3 ms}
  total: {kind: sum, inputs: [one], unit: N, start: {one: 0.5}}
connections:
  - body.m <-> total.one
simulation: {start_time: -500 ms, stop_time: 1/6 min, step_size: 100 ms, output_interval: 0.5 s}
"""


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
    assert read.simulation == Simulation(10.0, 0.1, output_interval=0.5, start_time=-0.5)


def test_kinds_are_known_where_they_are_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert {"table", "sea"} <= set(kinds())
    assert "late" not in kinds()
    info = tmp_path / "late-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: late\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{KIND_GROUP}]\nlate = late.kind\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert kinds()["late"].value == "late.kind"
    monkeypatch.undo()
    assert "late" not in kinds()
