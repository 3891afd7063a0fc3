"""Several programs as one: names, connections, algebraic loops, derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from support.planar_trees import random_tree
from support.programs import Evaluated

from m4e_fmi.multibody import topology
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import (
    AlgebraicLoopError,
    Connection,
    Program,
    Recorder,
    Variable,
    compose,
    jacobian,
    singular_loop,
)


def gain(name: str, factor: float, *, through: bool = True) -> Program:
    """y = factor · u + x with ẋ = −x + u; without `through` y = x."""
    r = Recorder(name, "")
    k = r.parameter(Variable("k", "1", "", start=factor))
    u = r.input(Variable("u", "m", "", start=0.5))
    x = r.state(Variable("x", "m", "", start=1.0))
    r.rate("x", u - x)
    r.output(Variable("y", "m", ""), k * u + x if through else x)
    r.calculate(Variable("twice", "1", ""), 2.0 * k)
    return r.program()


def link(source: str, target: str, factor: float = 1.0, offset: float = 0.0) -> Connection:
    def ends(text: str) -> tuple[str, str]:
        part, _, name = text.partition(".")
        return part, name

    return Connection(ends(source), ends(target), factor, offset)


def looped(J: list[list[float]]) -> Program:
    """z = J z + x in one part, x being 1, 2, …"""
    r = Recorder("all", "")
    u = [r.input(Variable(f"u{k}", "1", "")) for k in range(len(J))]
    for k, row in enumerate(J):
        total = r.parameter(Variable(f"x{k}", "1", "", start=k + 1.0))
        for gain, z in zip(row, u, strict=True):
            total = total + gain * z
        r.output(Variable(f"y{k}", "1", ""), total)
    links = [link(f"all.y{k}", f"all.u{k}") for k in range(len(J))]
    return compose("whole", {"all": r.program()}, links)


def values(program: Program, **given: float) -> dict[str, float]:
    """Outputs at the start values, others as given with __ for a dot."""
    names = {name.replace("__", "."): value for name, value in given.items()}
    start = {v.name: v.start for v in (*program.parameters, *program.inputs, *program.states)}
    return Evaluated(program).outputs(start | names)


def rates(program: Program, given: Mapping[str, float]) -> dict[str, float]:
    return Evaluated(program).rates(given)


def test_connections_with_factor_and_offset() -> None:
    parts = {"a": gain("a", 3.0), "b": gain("b", 5.0)}
    whole = compose("whole", parts, [link("a.y", "b.u", 2.0, 7.0)])
    assert [v.name for v in whole.inputs] == ["a.u"]
    assert [v.name for v in whole.states] == ["a.x", "b.x"]
    found = values(whole, a__u=0.5, a__x=1.0, b__x=10.0)
    assert found == {"a.y": 2.5, "b.y": 5.0 * (2.0 * 2.5 + 7.0) + 10.0}


def test_sources_may_be_states_rates_and_calculated_parameters() -> None:
    parts = {name: gain(name, factor) for name, factor in (("a", 3.0), ("b", 5.0), ("c", 7.0))}
    links = [link("a.x", "b.u"), link("a.der(x)", "c.u"), link("a.twice", "b.k")]
    whole = compose("whole", parts, links)
    assert [v.name for v in whole.parameters] == ["a.k", "c.k"]
    found = values(whole, a__u=0.5, a__x=1.25, b__x=0.0, c__x=0.0)
    assert found["b.y"] == 6.0 * 1.25
    assert found["c.y"] == 7.0 * (0.5 - 1.25)
    # what is calculated of a connected parameter follows it
    assert Evaluated(whole).calculated({"a.k": 3.0, "c.k": 7.0})["b.twice"] == 12.0


def test_a_parameter_that_varies_makes_outputs_of_what_was_calculated() -> None:
    whole = compose("whole", {"a": gain("a", 3.0), "b": gain("b", 5.0)}, [link("a.y", "b.k")])
    assert [v.name for v in whole.calculated] == ["a.twice"]
    assert values(whole, a__u=0.5, a__x=1.0, b__u=0.0)["b.twice"] == 2 * 2.5


def test_inputs_and_outputs_of_the_whole() -> None:
    parts = {"a": gain("a", 3.0), "b": gain("b", 5.0)}
    shared = {"drive": [("a", "u"), ("b", "u")]}
    whole = compose("whole", parts, [], inputs=shared, outputs={"answer": ("b", "y")})
    assert [v.name for v in whole.inputs] == ["drive"]
    found = values(whole, drive=2.0)
    assert (found["a.y"], found["b.y"], found["answer"]) == (7.0, 11.0, 11.0)


class TestLoops:
    def test_a_linear_loop_is_solved(self) -> None:
        parts = {"a": gain("a", 3.0), "b": gain("b", 0.25)}
        whole = compose("whole", parts, [link("a.y", "b.u"), link("b.y", "a.u", 2.0, 1.0)])
        assert not whole.inputs
        found = values(whole, a__x=1.0, b__x=4.0)
        # y_a = 3 (2 y_b + 1) + 1, y_b = y_a/4 + 4
        y_a = (3 * (2 * 4.0 + 1) + 1) / (1 - 3 * 2 * 0.25)
        assert found["a.y"] == pytest.approx(y_a, rel=1e-15)
        assert found["b.y"] == pytest.approx(0.25 * y_a + 4.0, rel=1e-15)

    @pytest.mark.parametrize("size", [2, 5, 9])
    def test_dense_loops(self, size: int) -> None:
        """z = J z + x of random J, with units that differ by factors of a million."""
        rng = np.random.default_rng(size)
        units = 10.0 ** rng.uniform(-3, 3, size)
        J = rng.normal(size=(size, size)) * units[:, None] / units
        given = rng.normal(size=size) * units
        found = values(looped(J.tolist()), **{f"all__x{k}": given[k] for k in range(size)})
        exact = np.linalg.solve(np.eye(size) - J, given)
        got = np.array([found[f"all.y{k}"] for k in range(size)])
        assert got / units == pytest.approx(exact / units, rel=1e-11)

    @pytest.mark.parametrize(
        "J",
        [
            [[1.0, 2.0], [3.0, 1.0]],
            [[1.0, 1e6], [3e-6, 1.0]],
            [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]],
            [[1.0 - 1e-9, 2.0], [3.0, 1.0 - 1e-9]],
            [[1.0 - 1e-14, 2.0], [3.0, 1.0 - 1e-14]],
        ],
    )
    def test_own_gains_of_one(self, J: list[list[float]]) -> None:
        """No pivot is on the diagonal of 1 - J, or only rounding, yet there is one solution."""
        exact = np.linalg.solve(np.eye(len(J)) - J, np.arange(1.0, len(J) + 1))
        found = values(looped(J))
        got = [found[f"all.y{k}"] for k in range(len(J))]
        assert got == pytest.approx(exact, rel=1e-14)

    def test_shares_of_pivots_tell_a_singular_loop(self) -> None:
        whole = compose("whole", {"a": gain("a", 0.5)}, [link("a.y", "a.u")])
        assert [loop.inputs for loop in whole.loops] == [("a.u",)]
        within = compose("outer", {"in": whole}, [])
        for program, prefix in ((whole, ""), (within, "in.")):
            start = {v.name: v.start for v in (*program.parameters, *program.states)}
            assert not singular_loop(program, start)
            for k in (1.0, 1.0 - 1e-12):
                assert singular_loop(program, start | {f"{prefix}a.k": k}) == f"{prefix}a.u"

    def test_rounding_is_no_pivot(self) -> None:
        with pytest.raises(AlgebraicLoopError, match="singular at the start"):
            looped([[1.0, 1e-17], [1e-17, 1.0]])


def moving(seed: int) -> Program:
    model = random_tree(seed, size=4)
    return recorded(model, topology(model), Recursion)


class TestDerivatives:
    """Derivatives go around the solved equations of each part, and are the same through them."""

    @staticmethod
    def joined(seed: int) -> Program:
        """Two multibody systems: the acceleration of one body pushes the other system."""
        parts = {"one": moving(seed), "two": moving(seed + 1)}
        force = next(v.name for v in parts["two"].inputs if "force_x" in v.name)
        source = next(v.name for v in parts["one"].outputs if v.name.endswith(".ax"))
        return compose("joined", parts, [link(f"one.{source}", f"two.{force}", 3.0)])

    @pytest.mark.parametrize("seed", [1, 5, 9])
    def test_they_are_equal(self, seed: int) -> None:
        whole = self.joined(seed)
        assert len(whole.solutions) == 2
        rng = np.random.default_rng(seed)
        groups = (*whole.parameters, *whole.inputs, *whole.states)
        given = {v.name: v.start or rng.uniform(-0.5, 0.5) for v in groups}
        around, through = (jacobian(program) for program in (whole, replace(whole, solutions=())))
        found = []
        for one in (around, through):
            entries = list(Evaluated(one.program).outputs(given).values())
            matrix = np.zeros((len(one.rows), len(one.columns)))
            matrix[list(one.row_indices), list(one.column_indices)] = entries
            found.append(matrix)
        scale = np.abs(found[1]).max()
        assert found[0] == pytest.approx(found[1], rel=0, abs=1e-11 * scale)
