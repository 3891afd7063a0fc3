"""Systems as one program: loops through accelerations, own inputs, what is left open."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.programs import Evaluated

from m4e_fmi.cosim import load_system, save_system, system_program
from m4e_fmi.simulate import simulate

CART = """\
name: {name}
gravity: 0
parameters: {{k: {{value: 50, unit: N/m}}}}
bodies: {{cart: {{mass: {mass}, inertia: 1}}}}
joints: {{rail: {{type: prismatic, child: cart, direction: [1, 0], initial: {{q: 0.2}}}}}}
loads: {{spring: {{type: joint_effort, joint: rail, effort: -k*joint.rail.q}}}}
"""
TIMES = "simulation: {stop_time: 1, step_size: 0.01}\n"


def system(folder: Path, text: str, **masses: float) -> Path:
    for name, mass in masses.items():
        model = CART.format(name=name, mass=mass)
        (folder / f"{name}.model.yaml").write_text(model, encoding="utf-8")
    parts = "".join(f"  {name}: {{model: {name}.model.yaml}}\n" for name in masses)
    path = folder / "system.yaml"
    path.write_text(f"name: carts\ncomponents:\n{parts}{text}{TIMES}", encoding="utf-8")
    return path


def test_a_force_of_the_acceleration_is_a_mass(tmp_path: Path) -> None:
    """F = −3 kg · a in a loop through the connection: as 5 kg more than 2 kg."""
    added = "connections: ['a.body.cart.ax * -3 -> a.body.cart.force_x, units ignored']\n"
    looped = system_program(load_system(system(tmp_path, added, a=2)))
    (tmp_path / "heavy").mkdir()
    heavy = system_program(load_system(system(tmp_path / "heavy", "connections: []\n", a=5)))
    found, exact = (
        simulate(p, stop_time=1.0, output_interval=0.1, tolerance=1e-12)["a.joint.rail.q"]
        for p in (looped, heavy)
    )
    assert np.abs(found - exact).max() < 1e-12


def test_the_inputs_and_outputs_of_the_system(tmp_path: Path) -> None:
    text = """\
connections: ['a.body.cart.x * -10 -> b.body.cart.force_x, units ignored']
inputs: {push: [a.joint.rail.effort]}
outputs: {place: b.body.cart.x}
"""
    program = system_program(load_system(system(tmp_path, text, a=2, b=4)))
    names = [v.name for v in program.inputs]
    assert "push" in names
    assert "b.body.cart.force_x" not in names
    assert "place" in [v.name for v in program.outputs]
    states = {"a.joint.rail.q": 0.3, "b.joint.rail.q": 0.1}
    rates = Evaluated(program).rates({**states, "push": 7.0})
    assert rates["a.joint.rail.u"] == pytest.approx((7.0 - 50 * 0.3) / 2, rel=1e-14)
    assert rates["b.joint.rail.u"] == pytest.approx((-10 * 0.3 - 50 * 0.1) / 4, rel=1e-14)


def test_an_own_input_has_the_start_value_of_its_inputs(tmp_path: Path) -> None:
    """Those that differ in it, or in their units: tests/corpus/composition.yaml."""
    text = "connections: []\ninputs: {push: [a.body.cart.force_x, a.joint.rail.effort]}\n"
    path = system(tmp_path, text, a=2)
    given = {"a.body.cart.force_x": "4 N", "a.joint.rail.effort": 4}
    program = system_program(load_system(path).changed(start=given))
    assert [v.start for v in program.inputs if v.name == "push"] == [4.0]


def test_native_fmus_of_ours_are_the_programs_that_they_carry(tmp_path: Path) -> None:
    """Packed, and with a start value of the package; of others nothing is known."""
    text = "connections: ['a.body.cart.x * -10 -> b.body.cart.force_x, units ignored']\n"
    path = system(tmp_path, text, a=2, b=4)
    path.write_text(
        path.read_text("utf-8").replace("b.model.yaml}", "b.model.yaml, start: {k: 70}}"), "utf-8"
    )
    package = save_system(load_system(path), tmp_path / "carts.ssp", build_directory=tmp_path / "b")
    whole, packed = system_program(load_system(path)), system_program(load_system(package))
    assert packed.rates == whole.rates
    assert packed.states == whole.states
    assert packed.parameters == whole.parameters
    assert {v.name for v in packed.outputs} > {v.name for v in whole.outputs}  # energies, too
    one, other = (simulate(p, stop_time=1.0)["b.joint.rail.q"] for p in (whole, packed))
    assert np.array_equal(one, other)
    assert [v.start for v in packed.parameters if v.name == "b.k"] == [70.0]
    nothing = system_program(load_system(package), keep_open=["a", "b"])
    assert not nothing.states
