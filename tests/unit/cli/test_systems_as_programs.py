"""Commands that take the equations of a whole system."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from support.cart_systems import cart_system

from m4e_fmi.cli import main
from m4e_fmi.cosim import load, system_program
from m4e_fmi.simulate import simulate

SEED = 1
"""Two carts with pendulums, a take-off and a controller."""
FOREIGN = """\
name: with_line
components:
  m0: {model: m0.model.yaml}
  line:
    kind: mooring
    water: {density: 0, depth: 50}
    line_types: {t: {diameter: 0.1, mass_per_length: 1, axial_stiffness: 1e5, axial_damping: 100,
      drag_coefficient: 0, added_mass_coefficient: 0}}
    anchors: {top: [0, 0]}
    fairleads: [tip]
    lines: {l: {type: t, from: top, to: tip, unstretched_length: 2, segments: 2}}
connections: [m0.tip <-> line.tip]
simulation: {stop_time: 1, step_size: 0.1}
"""
CART = """\
name: cart
gravity: 0
bodies: {cart: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: cart, direction: [1, 0], initial: {q: 0.2}}}
loads: {spring: {type: joint_effort, joint: rail, effort: 20 - 50*joint.rail.q}}
"""
ON_A_SPRING = """\
name: held
components:
  cart: {{model: cart.model.yaml}}
  line: {{fmu: {fmu}}}
connections:
  - cart.body.cart.x -> line.end.x
  - cart.body.cart.vx -> line.end.vx
  - line.end.force_x -> cart.body.cart.force_x
simulation: {{stop_time: 1, step_size: 0.1}}
"""


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    cart_system(tmp_path, SEED)
    return "system.yaml"


def test_a_simulation_and_a_run_have_the_same_results(
    system: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", system, "--reference", "--algorithm", "corrector"]) == 0
    said = capsys.readouterr().out
    assert "against the solution as one program: largest error" in said
    assert main(["simulate", system, "--no-plot"]) == 0
    assert "energy balance closes to" in capsys.readouterr().out
    whole = load(tmp_path / "build" / f"system{SEED}_whole.nc")
    assert whole.time[-1] == 2.0
    assert set(whole.components) == {"m0", "m1", "pto", "pid"}
    coupled = load(tmp_path / "build" / f"system{SEED}.nc")
    assert np.abs(coupled["m0.body.bob.z"] - whole["m0.body.bob.z"]).max() < 1e-4


def test_a_simulation_warns_of_outputs_beyond_their_limits(
    system: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.analysis.rest_notes.limits_left", lambda _: ["it is outside"])
    assert main(["simulate", system, "--stop-time", "0.1", "--no-plot"]) == 0
    assert "warning: it is outside" in capsys.readouterr().err


def test_linearize_and_equilibrium(system: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["linearize", system, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["stable"]
    assert "S" in found["mechanical"]
    # the bob's place at rest, by the controller's target of the second cart
    wanted = ["--such-that", "m0.joint.rail.q", "3 cm", "--vary", "pto.anchor.x", "--json"]
    assert main(["equilibrium", system, *wanted]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["m0.joint.rail.q"] == pytest.approx(0.03, abs=1e-9)


def test_equations_as_operations_and_in_python(
    system: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for more, expected in (
        ([], "der(m0.joint.rail.q) = m0.joint.rail.u"),
        (["--code", "python"], "def rates("),
    ):
        assert main(["equations", system, *more]) == 0
        assert expected in capsys.readouterr().out


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_one_fmu_of_the_whole(system: str, tmp_path: Path, kind: str) -> None:
    assert main(["build", "--single", system]) == 0
    fmu = tmp_path / "build" / f"system{SEED}.fmu"
    z = "m0.body.bob.z"
    found = simulate_fmu(
        str(fmu),
        stop_time=2.0,
        output_interval=0.1,
        output=[z],
        fmi_type=kind,
        relative_tolerance=1e-9,
    )
    program = system_program(cart_system(tmp_path, SEED))
    exact = simulate(program, stop_time=2.0, output_interval=0.1, tolerance=1e-11)[z]
    assert np.abs(found[z] - exact).max() < 1e-5


@pytest.mark.usefixtures("system")
def test_what_is_no_equation_takes_part_at_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A line hangs from 0, 0 to the bob; left open, it is inputs."""
    (tmp_path / "line.yaml").write_text(FOREIGN, encoding="utf-8")
    assert main(["equilibrium", "line.yaml", "--open", "line"]) == 0
    inputs = "m0.point.tip.force_x, m0.point.tip.force_z"
    assert f"left open: line; inputs instead of it: {inputs}\n" in capsys.readouterr().err
    for command in (["equilibrium"], ["linearize", "--json"], ["simulate", "--no-plot"]):
        assert main([command[0], "line.yaml", "--settled", "line", *command[1:]]) == 0
        caught = capsys.readouterr()
        assert "settled: line: at rest from its start" in caught.err
        assert "line: warning: l is divided coarsely" in caught.err
        if command == ["equilibrium"]:
            assert "line.l.fairlead_tension" in caught.out
    assert (tmp_path / "build" / "with_line" / "line.fmu").is_file()
    elsewhere = ["--settled", "line", "--build-folder", "other"]
    assert main(["equilibrium", "line.yaml", *elsewhere]) == 0
    assert (tmp_path / "other" / "with_line" / "line.fmu").is_file()
    assert main(["run", "line.yaml", "--start", "equilibrium"]) == 0
    assert "starts at its equilibrium; moved most: m0.joint.hinge.q" in capsys.readouterr().err
    found = load(tmp_path / "build" / "with_line.nc")
    assert np.ptp(np.asarray(found["m0.joint.hinge.q"])) < 1e-6


@pytest.mark.parametrize("command", ["equilibrium", "linearize", "simulate"])
def test_start_values_of_what_is_settled(
    c_fmu: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    """A force of 20 N − 50 N/m x, and a spring of 30 N/m, which meet at 0.25 m."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cart.model.yaml").write_text(CART, encoding="utf-8")
    text = ON_A_SPRING.format(fmu=c_fmu("spring"))
    (tmp_path / "cart.yaml").write_text(text, encoding="utf-8")
    given = ["cart.yaml", "--settled", "line", "--start-value", "line.stiffness", "0.03 N/mm"]
    assert main([command, *given, *(["--no-plot"] if command == "simulate" else ["--json"])]) == 0
    out = capsys.readouterr().out
    if command != "simulate":
        found = json.loads(out)
        point = found if command == "equilibrium" else found["point"]
        assert point["cart.joint.rail.q"] == pytest.approx(0.25, rel=1e-9)


def test_a_system_is_animated_alike_as_a_run_and_as_a_program(
    system: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", system, "--animate"]) == 0
    assert main(["simulate", system, "--no-plot", "--animate", "whole.html"]) == 0
    told = capsys.readouterr().out
    pages = []
    for name in (f"build/system{SEED}.html", "whole.html"):
        assert f"wrote {name}" in told
        pages.append((tmp_path / name).read_text(encoding="utf-8"))
    first, second = (re.findall(r'"bodies":.*?"ropes"', page) for page in pages)
    assert len(first) == 1
    assert first == second
    main(["run", system, "--animate", "a.gif"])
    assert "an animation cannot be written as '.gif'\n      use .html" in capsys.readouterr().err
