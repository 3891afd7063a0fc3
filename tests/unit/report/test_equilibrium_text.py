"""An equilibrium as text: arrays of outputs have one line each."""

from __future__ import annotations

from m4e_fmi.analysis import equilibrium
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.report import equilibrium_text, equilibrium_values


def held(*outputs: str) -> Program:
    """A mass that comes to rest at x = 2 m, and outputs of x, 2x, …."""
    recorder = Recorder("held", "Mass on a spring")
    x = recorder.state(Variable("x", "m", "Place"))
    v = recorder.state(Variable("v", "m/s", "Speed"))
    recorder.rate("x", v)
    recorder.rate("v", 2.0 - x - v)
    for k, name in enumerate(outputs, start=1):
        recorder.output(Variable(name, "m", "Multiple"), k * x)
    return recorder.program()


def test_an_array_has_a_line_of_its_range() -> None:
    nodes = [f"line.node_x[{k}]" for k in range(1, 22)]
    point = equilibrium(held(*nodes, "line.fairlead_x"))
    lines = equilibrium_text(point).splitlines()
    start = lines.index("outputs that are not zero:") + 1
    assert [line.split() for line in lines[start:]] == [
        ["line.node_x[…]", "2", "to", "42", "m", "(21", "values)"],
        ["line.fairlead_x", "44", "m"],
        ["the", "21", "values", "of", "arrays:", "--json"],
    ]
    assert set(nodes) <= set(equilibrium_values(point))


def test_few_elements_have_a_line_each() -> None:
    lines = equilibrium_text(equilibrium(held("p[1]", "p[2]", "p[3]", "p[1].x"))).splitlines()
    shown = [line.split()[0] for line in lines[lines.index("outputs that are not zero:") + 1 :]]
    assert shown == ["p[1]", "p[2]", "p[3]", "p[1].x"]
