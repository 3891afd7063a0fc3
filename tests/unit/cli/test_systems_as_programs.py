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

from m4e_fmi.cosim import load, system_program
from m4e_fmi.simulate import simulate

Said = Callable[..., str]
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
def system(here: Path) -> str:
    cart_system(here, SEED)
    return "system.yaml"


def test_a_simulation_warns_of_outputs_beyond_their_limits(
    system: str, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("m4e_fmi.simulate.limits.limits_left", lambda _: ["it is outside"])
    text = said("simulate", system, "--stop-time", "0.1", "--no-plot")
    assert "warning: it is outside" in text


def test_a_simulation_and_a_run_have_the_same_results(system: str, said: Said) -> None:
    said("run", system, "--algorithm", "corrector")
    assert "energy balance closes to" in said("simulate", system, "--no-plot")
    coupled, whole = (load(f"build/system{SEED}{end}.nc") for end in ("", "_whole"))
    assert whole.time[-1] == 2.0
    assert set(whole.components) == {"m0", "m1", "pto", "pid"}
    assert np.abs(coupled["m0.body.bob.z"] - whole["m0.body.bob.z"]).max() < 1e-4


def test_linearize_equilibrium_and_equations(system: str, said: Said) -> None:
    found = json.loads(said("linearize", system, "--json"))
    assert found["stable"]
    assert "S" in found["mechanical"]
    # the bob's place at rest
    wanted = ["--such-that", "m0.joint.rail.q", "3 cm", "--vary", "pto.anchor.x", "--json"]
    found = json.loads(said("equilibrium", system, *wanted))
    assert found["m0.joint.rail.q"] == pytest.approx(0.03, abs=1e-9)
    assert "def rates(" in said("equations", system)


def test_one_fmu_of_the_whole(system: str, here: Path, said: Said) -> None:
    """As co-simulation and as model exchange."""
    said("build", "--single", system)
    z = "m0.body.bob.z"
    program = system_program(cart_system(here, SEED))
    exact = simulate(program, stop_time=2.0, output_interval=0.1, tolerance=1e-11)[z]
    for kind in ("CoSimulation", "ModelExchange"):
        found = simulate_fmu(
            f"build/system{SEED}.fmu", stop_time=2.0, output_interval=0.1, output=[z],
            fmi_type=kind, relative_tolerance=1e-9,
        )  # fmt: skip
        assert np.abs(found[z] - exact).max() < 1e-5


@pytest.mark.usefixtures("system")
def test_what_is_no_equation_takes_part_at_rest(here: Path, said: Said) -> None:
    """A line hangs from 0, 0 to the bob; left open, it is inputs."""
    (here / "line.yaml").write_text(FOREIGN, encoding="utf-8")
    inputs = "m0.point.tip.force_x, m0.point.tip.force_z"
    text = said("equilibrium", "line.yaml", "--open", "line")
    assert f"left open: line; inputs instead of it: {inputs}\n" in text
    for command in ("equilibrium", "linearize", "simulate"):
        more = ["--no-plot"] if command == "simulate" else []
        text = said(command, "line.yaml", "--settled", "line", *more)
        assert "settled: line: in static equilibrium" in text
        assert command != "equilibrium" or "line.l.fairlead_tension" in text
    said("run", "line.yaml", "--start", "equilibrium")
    assert np.ptp(np.asarray(load("build/with_line.nc")["m0.joint.hinge.q"])) < 1e-6


def test_start_values_of_what_is_settled(
    c_fmu: Callable[[str], Path], here: Path, said: Said
) -> None:
    """A force of 20 N − 50 N/m x, and a spring of 30 N/m, which meet at 0.25 m."""
    (here / "cart.model.yaml").write_text(CART, encoding="utf-8")
    (here / "cart.yaml").write_text(ON_A_SPRING.format(fmu=c_fmu("spring")), encoding="utf-8")
    given = ["cart.yaml", "--settled", "line", "--start-value", "line.stiffness", "0.03 N/mm"]
    said("simulate", *given, "--no-plot")
    for found in (
        json.loads(said("equilibrium", *given, "--json")),
        json.loads(said("linearize", *given, "--json"))["point"],
    ):
        assert found["cart.joint.rail.q"] == pytest.approx(0.25, rel=1e-9)


def test_a_system_is_animated_alike_as_a_run_and_as_a_program(system: str, said: Said) -> None:
    pages = []
    for name, command in (
        (f"build/system{SEED}.html", ["run", system, "--animate"]),
        ("whole.html", ["simulate", system, "--no-plot", "--animate", "whole.html"]),
    ):
        assert re.search(f"wrote .*{name}", said(*command))
        pages.append(Path(name).read_text(encoding="utf-8"))
    first, second = (re.findall(r'"bodies":.*?"ropes"', page) for page in pages)
    assert len(first) == 1
    assert first == second
