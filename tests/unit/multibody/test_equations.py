"""What `Equations` writes: outputs as expressions, and what is said of unknown inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import sympy
from support.programs import Evaluated, random_values

from m4e_fmi.errors import InputError
from m4e_fmi.model import load_model
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
