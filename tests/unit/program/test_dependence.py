"""Kinds of dependency, against what the derivatives themselves depend on."""

from __future__ import annotations

import pytest
from support.chains import hanging_chain
from support.runtime_programs import every_operation

from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, jacobian
from m4e_fmi.program.dependence import kinds


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
