"""Kinds of dependency, against what the derivatives themselves depend on."""

from __future__ import annotations

import pytest
from support.chains import hanging_chain
from support.runtime_programs import every_operation

from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Scalar, Variable, jacobian, sin
from m4e_fmi.program.dependence import kinds


def recorded() -> tuple[Program, dict[str, Scalar]]:
    r = Recorder("p", "p")
    s = {name: r.parameter(Variable(name, "1", name, 2.0, tunable=name == "t")) for name in "pt"}
    s |= {name: r.input(Variable(name, "1", name)) for name in "uv"}
    s["x"] = r.state(Variable("x", "1", "x"))
    r.rate("x", s["u"])
    s["time"] = r.time
    return r.program(), s


def test_each_operation() -> None:
    program, s = recorded()
    p, t, u, v, x, time = (s[name] for name in ("p", "t", "u", "v", "x", "time"))
    cases = (
        (3.0 * u - v, {"u": "constant", "v": "constant"}),
        (p * u + v / p, {"u": "fixed", "v": "fixed", "p": "dependent"}),
        (t * p * u, {"u": "tunable", "t": "dependent", "p": "dependent"}),
        (u / x, {"u": "dependent", "x": "dependent"}),
        (2.0 / u, {"u": "dependent"}),
        (-u * time, {"u": "dependent", "time": "dependent"}),
        (sin(p) * u, {"u": "fixed", "p": "dependent"}),
        (sin(u) + x, {"u": "dependent", "x": "constant"}),
        (u * v + u, {"u": "dependent", "v": "dependent"}),
        (p + 1.0 * t, {"p": "constant", "t": "constant"}),
    )
    found = kinds(program, [value.index for value, _ in cases])
    assert [found[value.index] for value, _ in cases] == [expected for _, expected in cases]


@pytest.mark.parametrize(
    "program", [model_program(hanging_chain(3)), every_operation()], ids=["chain", "operations"]
)
def test_derivatives_vary_as_the_kinds_say(program: Program) -> None:
    """What ∂y/∂v depends on is allowed by the kind; what has no derivative is no dependency."""
    moving = [v.name for group in (program.states, program.inputs) for v in group]
    allowed = {
        "constant": set(),
        "fixed": {v.name for v in program.parameters if not v.tunable},
        "tunable": {v.name for v in program.parameters},
    }
    found = kinds(program, program.results)
    slopes = jacobian(program, of="outputs", by=moving)
    places = zip(slopes.row_indices, slopes.column_indices, slopes.program.results, strict=True)
    checked = 0
    for row, column, node in places:
        kind = found[program.results[row]][slopes.columns[column]]
        if kind != "dependent":
            assert slopes.program.dependencies(node) <= allowed[kind]
            checked += 1
    assert checked
