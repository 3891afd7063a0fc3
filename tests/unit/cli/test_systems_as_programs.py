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


def test_simulate_has_the_times_of_the_system(
    system: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", system, "--no-plot"]) == 0
    assert "energy balance closes to" in capsys.readouterr().out
    results = load(tmp_path / "build" / f"system{SEED}_whole.nc")
    assert results.time[-1] == 2.0
    assert set(results.components) == {"m0", "m1", "pto", "pid"}


def test_a_simulation_warns_of_outputs_beyond_their_limits(
    system: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.analysis.rest_notes.limits_left", lambda _: ["it is outside"])
    assert main(["simulate", system, "--stop-time", "0.1", "--no-plot"]) == 0
    assert "warning: it is outside" in capsys.readouterr().err


def test_results_are_those_of_the_run(system: str, tmp_path: Path) -> None:
    assert main(["run", system, "--reference", "--algorithm", "corrector"]) == 0
    assert main(["simulate", system, "--no-plot"]) == 0
    coupled = load(tmp_path / "build" / f"system{SEED}.nc")
    whole = load(tmp_path / "build" / f"system{SEED}_whole.nc")
    z = "m0.body.bob.z"
    assert np.abs(coupled[z] - whole[z]).max() < 1e-4


def test_reference_is_told(system: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", system, "--reference"]) == 0
    assert "against the solution as one program: largest error" in capsys.readouterr().out


def test_reference_needs_an_estimate(system: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", system, "--no-certify"]) == 0
    assert "coupling error not known: it was not estimated, as asked" in capsys.readouterr().out
    assert main(["run", system, "--no-certify", "--reference"]) == 2
    assert "leave out --no-certify" in capsys.readouterr().err


def test_linearize_and_equilibrium(system: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["linearize", system, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["stable"]
    assert "S" in found["mechanical"]
    # the bob's place at rest, by the controller's target of the second cart
    wanted = ["--such-that", "m0.joint.rail.q", "3 cm", "--vary", "m1.joint.rail.effort"]
    assert main(["equilibrium", system, *wanted]) == 2
    assert "did you mean" in capsys.readouterr().err
    wanted[-1] = "m0.k"
    assert main(["equilibrium", system, *wanted[:-2], "--vary", "pto.anchor.x", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["m0.joint.rail.q"] == pytest.approx(0.03, abs=1e-9)


def test_equations_as_operations_and_in_python(
    system: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["equations", system]) == 0
    assert "der(m0.joint.rail.q) = m0.joint.rail.u" in capsys.readouterr().out
    assert main(["equations", system, "--code", "python"]) == 0
    assert "def rates(" in capsys.readouterr().out
    assert main(["equations", system, "--latex"]) == 2


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


def test_what_is_no_equation_is_named(
    system: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "line.yaml").write_text(FOREIGN, encoding="utf-8")
    for command in ("simulate", "linearize", "equilibrium", "equations"):
        assert main([command, "line.yaml"]) == 2
        told = capsys.readouterr().err
        assert "line is computed by Python code, not by equations" in told
        assert "--open line" in told
    assert main(["equilibrium", "line.yaml", "--open", "line"]) == 0
    told = capsys.readouterr().err
    inputs = "m0.point.tip.force_x, m0.point.tip.force_z"
    assert f"left open: line; inputs instead of it: {inputs}\n" in told
    assert main(["run", "line.yaml", "--reference"]) == 2
    assert main(["equilibrium", system, "--open", "nobody"]) == 2
    assert "there is no component 'nobody'" in capsys.readouterr().err


@pytest.mark.usefixtures("system")
def test_what_is_no_equation_takes_part_at_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A line hangs from 0, 0 to the bob."""
    (tmp_path / "line.yaml").write_text(FOREIGN, encoding="utf-8")
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
    bad = [*given[:3], "--start-value", "line.stifness", "30"]
    assert main([command, *bad]) == 2
    assert "did you mean 'stiffness'" in capsys.readouterr().err


def test_what_is_settled_cannot_vary(
    c_fmu: Callable[[str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "cart.model.yaml").write_text(CART, encoding="utf-8")
    path = tmp_path / "cart.yaml"
    path.write_text(ON_A_SPRING.format(fmu=c_fmu("spring")), encoding="utf-8")
    wanted = ["--such-that", "cart.joint.rail.q", "0.3", "--vary", "line.stiffness"]
    assert main(["equilibrium", str(path), "--settled", "line", *wanted]) == 2
    told = capsys.readouterr().err
    assert "line.stiffness cannot vary: line has no equations, from which the effect of" in told


def test_another_fmu_of_the_whole_is_replaced(
    system: str, capsys: pytest.CaptureFixture[str]
) -> None:
    note = f"build/system{SEED}.fmu replaces another FMU of that name"
    for more, told in (([], False), ([], False), (["--open", "pid"], True)):
        assert main(["build", "--single", system, "--no-documentation", *more]) == 0
        assert (note in capsys.readouterr().out) is told


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            ("  m1: {model: m1.model.yaml}", "  m1: {model: m1.model.yaml, step_size: 0.1}"),
            "m1 is stepped every 0.1 s, and holds its outputs between",
        ),
        (
            ("m1.joint.rail.effort, units ignored", "m1.joint.rail.effort, units ignored, delayed"),
            "this connection is delayed by a step",
        ),
    ],
)
def test_what_has_steps_is_named(
    system: str, change: tuple[str, str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = Path(system).read_text("utf-8")
    assert change[0] in text
    Path(system).write_text(text.replace(*change), encoding="utf-8")
    assert main(["simulate", system]) == 2
    assert told in capsys.readouterr().err


def test_flags_that_do_not_go_together(system: str, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, told in (
        (["build", "m0.model.yaml", "--single"], "--single is for a system"),
        (["build", system, "--single", "--ssp"], "--ssp packs a system"),
        (["build", system, "--open", "m0"], "--open is for the components"),
        (["simulate", "m0.model.yaml", "--open", "m0"], "--open is for the components"),
        (["build", system, "--settled", "m0"], "--settled is for the components"),
        (["equilibrium", "m0.model.yaml", "--settled", "m0"], "--settled is for the components"),
        (["linearize", system, "--settled", "m0"], "m0 is equations, which take part as they are"),
        (["simulate", system, "--animate", "a.gif"], "cannot be written as '.gif'"),
        (["build", system, "--single", "--inputs", "a"], "--inputs is for a model"),
    ):
        assert main(arguments) == 2
        assert told in capsys.readouterr().err


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


def test_a_system_that_shows_nothing_cannot_be_animated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "name: s\ncomponents: {sea: {kind: sea}}\nsimulation: {stop_time: 1, step_size: 0.1}\n"
    (tmp_path / "s.yaml").write_text(text, encoding="ascii")
    for command in ("run", "simulate"):
        assert main([command, "s.yaml", "--animate"]) == 2
        assert "leave out --animate" in capsys.readouterr().err
    assert main(["run", "s.yaml"]) == 0
