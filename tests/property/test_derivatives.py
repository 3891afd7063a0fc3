"""Derivatives against difference quotients in 100 digits, and against each other."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import mpmath
import pytest
from support.planar_trees import random_tree
from support.programs import Evaluated, random_values
from support.spatial_trees import spatial_tree
from support.tape_values import exact_values

from m4e_fmi import program as functions
from m4e_fmi.multibody import model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import Program, Recorder, Variable, jacobian, tangent
from m4e_fmi.program.tape import BINARY, UNARY

STEP = mpmath.mpf("1e-30")  # quotients are off by its square, and need 60 of the 100 digits
DIGITS = 100


def quotients(
    program: Program, nodes: Sequence[int], values: Mapping[str, Any], along: Mapping[str, float]
) -> list[Any]:
    """Difference quotients of `nodes` at `values` along a direction."""
    with mpmath.workdps(DIGITS):
        ahead, behind = (
            exact_values(
                program,
                nodes,
                {n: mpmath.mpf(v) + side * STEP * along.get(n, 0.0) for n, v in values.items()},
            )
            for side in (1, -1)
        )
        return [(a - b) / (2 * STEP) for a, b in zip(ahead, behind, strict=True)]


def largest_error(found: Sequence[Any], expected: Sequence[Any]) -> float:
    """Difference relative to 1 + the largest."""
    differences = [abs(a - b) for a, b in zip(found, expected, strict=True)]
    return float(max(differences) / (1 + max(map(abs, expected))))


def check_tangent(program: Program, seed: int, *, time: float = 0.0) -> None:
    """The tangent along all states, inputs, parameters and the time is a difference quotient."""
    r = random.Random(seed)
    values = {v.name: v.start for v in program.parameters} | random_values(program, seed)
    values["time"] = time
    along = {name: r.uniform(-1, 1) for name in values}
    expected = quotients(program, [*program.rates, *program.results], values, along)
    change = tangent(program, along)
    directions = {f"d({name})": value for name, value in along.items()}
    with mpmath.workdps(50):
        exact = exact_values(change, change.results, {**values, **directions})
        # 50 digits, conditions below 1e4, twice
        assert largest_error(exact, expected) < 1e-40


@pytest.mark.verifies(
    "derivatives of rates and outputs along states, inputs, parameters",
    independent="difference quotients, mpmath in 100 digits",
    tolerance="1e-40",
)
@pytest.mark.parametrize("algorithm", ["around the solution", "through it", "closed form"])
@pytest.mark.parametrize("seed", range(8))
def test_tangents_of_trees(seed: int, algorithm: str) -> None:
    """Along states, inputs, parameters and time at once; all rates and outputs."""
    model = random_tree(seed, size=2 + seed % 6, wet=seed % 2)
    kind = ClosedForm if algorithm == "closed form" else Recursion
    program = recorded(model, topology(model), kind)
    if algorithm == "through it":
        program = replace(program, solutions=())
    check_tangent(program, seed, time=0.7)


@pytest.mark.verifies(
    "the same of trees in space",
    independent="difference quotients, mpmath in 100 digits",
    tolerance="1e-40",
)
@pytest.mark.parametrize("algorithm", [Recursion, ClosedForm])
@pytest.mark.parametrize("seed", range(6))
def test_tangents_in_space(seed: int, algorithm: type[Recursion] | type[ClosedForm]) -> None:
    model = spatial_tree(200 + seed, size=2 + seed)
    program = recorded(model, topology(model), algorithm)
    check_tangent(program, seed)


@pytest.mark.verifies(
    "Jacobians in doubles",
    independent="difference quotients, mpmath in 100 digits",
    tolerance="1e-11",
)
@pytest.mark.parametrize("seed", range(6))
def test_jacobians_of_trees(seed: int) -> None:
    """Column j is the tangent along variable j, entry by entry; what is left out is zero."""
    program = recorded(m := random_tree(seed, size=6, wet=seed % 2), topology(m), Recursion)
    values = random_values(program, seed)
    for of, nodes in (("rates", program.rates), ("outputs", program.results)):
        matrix = jacobian(program, of)
        entries = list(Evaluated(matrix.program).outputs(values).values())
        places = list(zip(matrix.row_indices, matrix.column_indices, strict=True))
        assert places == sorted(set(places))
        assert matrix.columns == tuple(v.name for v in (*program.states, *program.inputs))
        assert len(matrix.rows) == len(nodes)
        for j, name in enumerate(matrix.columns):
            column = [0.0] * len(nodes)
            for (i, k), entry in zip(places, entries, strict=True):
                if k == j:
                    column[i] = entry
            expected = quotients(program, nodes, values, {name: 1.0})
            # some hundred operations in doubles, conditions below 1e4, twice
            assert largest_error(column, expected) < 1e-11


def test_added_mass_between_bodies() -> None:
    program = model_program(random_tree(3, size=3, wet=2))
    values = random_values(program, 3)
    along = {v.name: 1.0 for v in program.states}
    expected = quotients(program, program.rates, values, along)
    change = tangent(program, along)
    found = Evaluated(change).outputs({**values, **{f"d({n})": 1.0 for n in along}})
    assert largest_error(list(found.values())[: len(expected)], expected) < 1e-11


def one_operation(name: str) -> Program:
    r = Recorder("one", "")
    a, b = (r.input(Variable(n, "1", n)) for n in "ab")
    r.output(Variable("y", "1", "y"), a.record(name, *([b] if name in BINARY else [])))
    return r.program()


@pytest.mark.parametrize("point", [(0.3, 0.7), (0.8, 0.2)])
@pytest.mark.parametrize("name", sorted({*UNARY, *BINARY}))
def test_every_operation(name: str, point: tuple[float, float]) -> None:
    program = one_operation(name)
    values = dict(zip(["a", "b"], point, strict=True))
    for along in ({"a": 1.0}, {"b": 1.0}, {"a": 0.4, "b": -1.3}):
        expected = quotients(program, program.results, values, along)
        change = tangent(program, along)
        found = Evaluated(change).outputs({**values, **{f"d({n})": v for n, v in along.items()}})
        # a handful of operations
        assert found["d(y)"] == pytest.approx(float(expected[0]), rel=5e-15, abs=1e-15)


@pytest.mark.parametrize(
    ("name", "point", "expected"),
    [
        ("abs", (0.0, 0.0), (0.0, 0.0)),
        ("sign", (0.0, 0.0), (0.0, 0.0)),
        ("min", (2.0, 2.0), (0.5, 0.5)),
        ("max", (2.0, 2.0), (0.5, 0.5)),
    ],
)
def test_corners(name: str, point: tuple[float, float], expected: tuple[float, float]) -> None:
    program = one_operation(name)
    values = dict(zip(["a", "b"], point, strict=True))
    slopes = [
        Evaluated(tangent(program, [n])).outputs({**values, f"d({n})": 1.0})["d(y)"] for n in "ab"
    ]
    assert tuple(slopes) == expected


def test_a_power_has_a_slope_where_its_base_is_zero() -> None:
    r = Recorder("power", "")
    a = r.input(Variable("a", "1", "a"))
    r.output(Variable("y", "1", "y"), a**2.5 + functions.sin(a))
    found = Evaluated(tangent(r.program(), ["a"])).outputs({"a": 0.0, "d(a)": 1.0})
    assert found == {"d(y)": 1.0}
