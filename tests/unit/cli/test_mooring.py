"""`m4e-fmi mooring`: tables, files, pictures, and its refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

Said = Callable[..., str]
SYSTEM = """\
name: spread
components:
  lines:
    kind: mooring
    water: {density: 1025, depth: 50}
    line_types: {chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8,
      axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1}}
    anchors: {west: [-300, -50], east: [300, -50]}
    fairleads: {left: [-5, -4], right: [5, -4]}
    lines:
      l: {type: chain, from: west, to: left, unstretched_length: 305, segments: 12}
      r: {type: chain, from: east, to: right, unstretched_length: 305, segments: 12}
connections: []
simulation: {stop_time: 1, step_size: 0.05}
"""
MODEL = """\
name: box
bodies: {box: {mass: 1e5, inertia: 1e5}}
joints: {sea: {type: floating, child: box, initial: {x: 2}}}
points: {bow: {body: box, at: [5, -4]}, stern: {body: box, at: [-5, -4]}}
loads:
  hold: {type: body_force, body: box, force: [0, 2e6 - 1e6*body.box.z], moment: -1e7*body.box.theta}
"""


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "spread.yaml"
    path.write_text(SYSTEM, encoding="utf-8")
    return path


def test_a_system(system: Path, said: Said) -> None:
    printed = said("mooring", system)
    assert "spread: 2 lines in static equilibrium" in printed
    assert "force and stiffness about (0, 0, -4) m" in printed
    assert "note:" not in printed
    assert "wrote build/spread_mooring.png" in printed
    assert Path("build/spread_mooring.png").stat().st_size > 30_000


def test_numbers(system: Path, said: Said) -> None:
    given = ["--json", "--no-plot", "--directions", "0", "--about", "0", "0", "0"]
    found = json.loads(said("mooring", system, *given))
    assert found["about"] == [0.0, 0.0, 0.0]
    left, right = (found["lines"][name] for name in "lr")
    assert left["tensions"] == pytest.approx(right["tensions"], rel=1e-6)
    assert left["angles"][1] > left["angles"][0] == 0.0
    assert left["safety_factor"] is None
    (curve,) = found["offsets"]
    assert curve["offset"][0] == 0.0
    assert curve["pull"][0] == pytest.approx(0.0, abs=1.0)
    assert not Path("build/spread_mooring.png").exists()


def test_fairleads_are_where_the_system_is(system: Path, said: Said) -> None:
    """The box starts 2 m beside the middle, to which its lines pull it."""
    text = SYSTEM.replace("components:\n", "components:\n  box: {model: box.model.yaml}\n")
    links = "[box.point.stern <-> lines.left, box.point.bow <-> lines.right]"
    system.write_text(text.replace("connections: []", f"connections: {links}"), encoding="utf-8")
    Path("box.model.yaml").write_text(MODEL, encoding="utf-8")
    for start, x in (("values", 2.0), ("equilibrium", 0.0)):
        found = json.loads(said("mooring", system, "--json", "--no-plot", "--start", start))
        assert found["about"][0] == pytest.approx(x, abs=1e-4)


def test_lines_of_a_run(system: Path, said: Said) -> None:
    given = ["--no-plot", "--output-file", "run.nc"]
    said("run", system, *given, "--variables", "*")
    assert said("mooring", "run.nc", "--at", "0.5", "1").endswith("wrote build/run_lines.png\n")
    assert Path("build/run_lines.png").stat().st_size > 30_000
    assert "take times from 0 to 1 s" in said("mooring", "run.nc", "--at", "2", code=2)
    assert "--about is not for run.nc" in said(
        "mooring", "run.nc", "--about", "0", "0", "0", code=2
    )
    assert "--at is not for" in said("mooring", system, "--at", "1", code=2)
    said("run", system, *given)
    assert "--variables 'mooring.*'" in said("mooring", "run.nc", code=2)


def test_a_moordyn_file(tmp_path: Path, said: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    from m4e_adapters.moordyn import MooringConfig, mooring
    from m4e_fmi.files.document import Document

    monkeypatch.chdir(tmp_path)
    keys = SYSTEM[SYSTEM.index("    water") : SYSTEM.index("connections")]
    text = mooring(Document.parse(keys).validate(MooringConfig)).text
    Path("lines.txt").write_text(text, encoding="utf-8")
    assert "lines: 2 lines in static equilibrium" in said("mooring", "lines.txt", "--no-plot")


def test_strengths(system: Path, said: Said) -> None:
    """Offsets end where the first line is at its strength; one breaks, and the other is slack."""
    strong = "added_mass_coefficient: 1, breaking_strength: 5.0e+5}"
    system.write_text(SYSTEM.replace("added_mass_coefficient: 1}", strong), encoding="utf-8")
    found = json.loads(said("mooring", system, "--json", "--no-plot"))
    line, (curve, _) = found["lines"]["l"], found["offsets"]
    assert line["safety_factor"] == pytest.approx(5e5 / line["largest_tension"], rel=1e-12)
    assert max(curve["tensions"][-2]) < 5e5 < max(curve["tensions"][-1])
    assert curve["limit"] == "at its strength"
    assert found["broken"]["l"]["safety_factor"] > line["safety_factor"]
    assert "l: at its strength" in said("mooring", system, "--no-plot")


def test_one_of_two_bodies(system: Path, said: Said) -> None:
    given = ["--json", "--no-plot"]
    both = json.loads(said("mooring", system, *given))["stiffness"][0][0]
    one = json.loads(said("mooring", system, *given, "--fairleads", "left"))
    assert one["stiffness"][0][0] == pytest.approx(both / 2, rel=1e-6)
    assert one["about"] == [-5.0, 0.0, -4.0]
    told = said("mooring", system, "--fairleads", "lift", code=2)
    assert "spread has no fairlead lift" in told
    assert "did you mean 'left'" in told


def test_refusals(system: Path, said: Said) -> None:
    told = said("mooring", system, "--component", "line", code=2)
    assert "no mooring 'line'" in told
    assert "did you mean 'lines'" in told
    assert ".png" in said("mooring", system, "--output-file", "a.txt", code=2)
    Path("empty.txt").write_text("", encoding="utf-8")
    assert "error: " in said("mooring", "empty.txt", code=2)
    assert "error: " in said("mooring", "missing.yaml", code=2)
