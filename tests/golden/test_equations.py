"""Equations of a small model as text and LaTeX, word for word, and what functions of them give.

`pytest --update` writes the forms anew.
"""

from __future__ import annotations

import random
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.planar_trees import random_tree
from support.spatial_trees import spatial_tree

from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import Equations, mass_matrix_program, model_program
from m4e_fmi.multibody.symbolic.printing import intermediates
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.units import parse_unit

FOLDER = Path(__file__).with_name("equations")
CART = FOLDER / "cart.model.yaml"
FORMS = {
    "cart.txt": lambda equations: equations.text(reactions=True),
    "cart.tex": lambda equations: equations.text(latex=True),
}


@pytest.mark.parametrize("name", FORMS)
def test_form(name: str, request: pytest.FixtureRequest) -> None:
    text, golden = FORMS[name](Equations(load_model(CART))).rstrip("\n") + "\n", FOLDER / name
    if request.config.getoption("--update"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


def models() -> list[Model]:
    """All joints and loads, tables, added mass."""
    return [load_model(CART), *(random_tree(seed, size=6, wet=seed % 2) for seed in range(3))]


class Case:
    """A model at random, and M and f there by the program that runs."""

    def __init__(self, model: Model) -> None:
        self.equations = Equations(model)
        program = model_program(model, inputs=())
        r = np.random.default_rng(5)
        n = len(program.states) // 2
        self.p = np.array([v.start for v in program.parameters])
        wet = [k for k, v in enumerate(program.parameters) if v.name.startswith("added_mass")]
        size = round(len(wet) ** 0.5)
        self.p[wet] = np.eye(size).flat  # so that M stays positive definite
        values = dict(zip((v.name for v in program.parameters), self.p, strict=True))
        x = r.uniform(-1, 1, 2 * n)
        program = program.with_start(values)
        rates = Engine(program).rates(0.7, x)
        tunnel = [v.derivative_of is not None for v in program.states]
        self.q, self.u = x[~np.array(tunnel)], x[tunnel]
        matrix = mass_matrix_program(model).with_start(values)
        self.M = Engine(matrix).outputs(0.7, x).reshape(n, n)
        self.f = self.M @ rates[tunnel]

    def check(self, M: np.ndarray, f: np.ndarray) -> None:
        # one formulation against another, in double precision
        np.testing.assert_allclose(M, self.M, rtol=1e-12, atol=1e-12 * np.abs(self.M).max())
        np.testing.assert_allclose(f, self.f, rtol=1e-10, atol=1e-10 * np.abs(self.f).max())


@pytest.mark.parametrize("model", models(), ids=lambda model: model.name)
def test_functions_by_sympy_give_m_and_f(model: Model) -> None:
    import sympy

    case = Case(model)
    equations, scalars = case.equations, case.equations.assembly.scalars
    p = [*scalars.parameters.values(), *chain(*scalars.added_mass)]
    arguments = [sympy.Symbol("t", real=True), [*scalars.q], [*scalars.u], p]
    tables = {
        name: partial(np.interp, xp=t.times, fp=parse_unit(t.unit).factor * np.array(t.values))
        for name, t in model.tables.items()
    }
    both = [equations.mass_matrix, equations.forcing]
    M, f = sympy.lambdify(arguments, both, [tables, "numpy"])(0.7, case.q, case.u, case.p)
    case.check(M, f.ravel())


@pytest.mark.parametrize("latex", [False, True])
def test_long_pages_name_what_they_repeat(latex: bool) -> None:
    """Of ten bodies with all kinds of loads: 274 KB in full, with lines of 129 KB."""
    model = random_tree(3, size=10)
    text = Equations(model).text(latex=latex)
    # some 300 lines of 30 to 60 characters; the longest is a sum of ten bodies' parts
    assert len(text) < 40_000
    assert max(map(len, text.splitlines())) < 2_000


def test_pages_of_trees_in_space_are_short() -> None:
    equations = Equations(spatial_tree(1, size=7, loads=False, kinds=["revolute"]))
    assert len(equations.text()) < 200_000


def test_intermediates_put_back_give_the_equations() -> None:
    import sympy
    from sympy.core.function import AppliedUndef

    equations = Equations(random_tree(2, size=6))
    expressions: list[Any] = [*equations.mass_matrix, *equations.forcing]
    reduced: list[Any]
    shared, reduced = intermediates(expressions, equations.q.flat())
    names = [symbol.name for symbol, _ in shared]
    assert len(set(names)) == len(names) > 20
    atoms = set().union(*(e.free_symbols | e.atoms(AppliedUndef) for e in expressions))
    r = random.Random(3)
    point = {atom: sympy.Rational(r.randint(-999, 999), 700) for atom in atoms}
    values: dict[Any, Any] = dict(point)
    for symbol, value in shared:
        values[symbol] = sympy.N(value.xreplace(values), 40)
    for expression, short in zip(expressions, reduced, strict=True):
        difference = short.xreplace(values) - expression.xreplace(point)
        # 40 digits, of which sums of some ten numbers lose a few
        assert abs(difference.evalf(40)) < 1e-30
