"""Programs that are equal, and others."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from m4e_fmi.program import Program, Recorder, Variable, sin


def spring(
    *, damping: float = 0.5, unit: str = "N/m", swapped: bool = False, garbage: int = 0
) -> Program:
    r = Recorder("spring", "mass on a spring")
    k = r.parameter(Variable("k", unit, "stiffness", start=4.0))
    x = r.state(Variable("x", "m", "position"))
    v = r.state(Variable("v", "m/s", "velocity"))
    for number in range(garbage):
        sin(x * number)
    drag: Any = damping * v
    r.rate("x", v)
    r.rate("v", -(drag + k * x) if swapped else -(k * x + drag))
    r.output(Variable("force", "N", "what the spring exerts"), k * x)
    return r.program()


def test_equal_programs() -> None:
    """Whatever else is on their tapes, in whatever order they were recorded."""
    program = spring()
    for other in (spring(), spring(garbage=3), spring(swapped=True)):
        assert other == program
        assert hash(other) == hash(program)


def test_other_operations_variables_and_names() -> None:
    less = replace(spring(), outputs=(), results=())
    others = (
        *(spring(damping=0.25), spring(unit="kN/m"), spring().with_start({"k": 5.0}), less),
        replace(spring(), name="other"),
    )
    assert all(other != spring() for other in others)
