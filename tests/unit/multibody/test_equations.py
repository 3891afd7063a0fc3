"""What `Equations` writes: outputs as expressions, and what is said of unknown inputs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import sympy
from support.planar_trees import random_tree
from support.programs import Evaluated, random_values
from support.spatial_trees import spatial_tree

from m4e_fmi.errors import InputError
from m4e_fmi.model import Body, Joint, Model, Parameter, load_model
from m4e_fmi.multibody import Equations, model_program

EXAMPLES = Path(__file__).parents[3] / "examples"
PENDULUM = EXAMPLES / "double_pendulum/double_pendulum.model.yaml"


def test_outputs_are_those_of_the_program() -> None:
    """Of places, velocities, loads and energies: no symbol of an acceleration is in them."""
    equations, program = Equations(load_model(PENDULUM)), model_program(PENDULUM)
    values = random_values(program, 1) | {v.name: v.start for v in program.parameters}
    values |= {v.name: 0.0 for v in program.inputs}
    expected = Evaluated(program).outputs(values)
    states = [values[v.name] for v in program.states]
    coordinates = [*equations.q.flat(), *equations.u.flat()]
    numbers: dict[Any, Any] = dict(zip(coordinates, [*states[::2], *states[1::2]], strict=True))
    numbers |= {sympy.Symbol(v.name, real=True): v.start for v in program.parameters}
    found = {
        name: sympy.sympify(e, strict=True).subs(numbers) for name, e in equations.outputs.items()
    }
    known = {name: float(e) for name, e in found.items() if e.is_number}
    assert {"body.lower.x", "body.lower.omega", "energy.total"} <= known.keys()
    assert known == pytest.approx({name: expected[name] for name in known}, rel=1e-12, abs=1e-12)


def test_an_unknown_input() -> None:
    equations = Equations(load_model(PENDULUM), inputs=["joint.knee.effort"])
    with pytest.raises(InputError, match=r"has no input joint\.knee\.effort"):
        _ = equations.assembly


def test_symbols_are_written_as_in_papers_and_never_two_alike() -> None:
    """Parameters that would look like another symbol keep their names."""
    names = ("L1", "L_1", "theta2", "rho_w", "kp", "A", "b12", "arm_length")
    bodies = {"one": Body("kp*A + rho_w + b12", "theta2"), "two": Body("L1*L_1", "arm_length")}
    joints = {
        "rail": Joint("prismatic", "one", direction=(1, 0)),
        "hinge": Joint("revolute", "two", "one", joint_to_child=(0.1, "L1/64")),
    }
    parameters = {name: Parameter(1, "1") for name in names}
    equations = Equations(Model("named", parameters=parameters, bodies=bodies, joints=joints))
    text, latex = equations.text(), equations.text(latex=True)
    assert re.search(r"body 2: two .* θ₂\n", text)
    assert "⎡ A kp + L1 L_1 + b₁₂ + ρ_w  " in text
    assert "L1 sin(θ₂)/64" in text
    assert "0.1 sin(θ₂)" in text
    assert r"A \, \mathrm{kp} + \mathrm{L1} \, \mathrm{L\_1} + b_{12} + \rho_{\mathrm{w}}" in latex
    assert r"\mathrm{arm}_{\mathrm{length}}" in latex


def test_simplified_entries_are_equal_and_shorter() -> None:
    """M of the double pendulum: L² m cos(θ₁ − θ₂)/2 by hand."""
    full, short = Equations(PENDULUM), Equations(PENDULUM, simplify=True)
    L, m = sympy.symbols("L m", real=True)
    assert short.mass_matrix[0, 1] == L**2 * m * sympy.cos(full.q[0] - full.q[1]) / 2
    for one, other in (
        (full.forcing, short.forcing),
        ([full.kinetic_energy], [short.kinetic_energy]),
    ):
        for a, b in zip(one, other, strict=True):
            assert sympy.count_ops(b) < sympy.count_ops(a)
            assert sympy.simplify(a - b) == 0
    assert "  M = ⎡ J + 5 L² m/4         L² m cos(θ₁ - θ₂)/2 ⎤\n" in short.text()


def test_short_equations_are_printed_whole() -> None:
    equations = Equations(PENDULUM)
    assert str(equations) == equations.text()
    long = Equations(random_tree(3, size=25))
    assert str(long) == repr(long)


def test_what_is_too_long_is_not_simplified() -> None:
    equations = Equations(spatial_tree(1, size=3, loads=False, kinds=["revolute"]), simplify=True)
    with pytest.raises(InputError, match="operations is not simplified"):
        equations.text()
