"""Recursion and closed form against positions alone, in 50 digits, on random trees.

With every kind of joint and load. Numbers are doubles on both sides, so that 50 digits show all
that is wrong.
"""

from __future__ import annotations

import random
from typing import Any

import mpmath
import pytest
import sympy as sp
from support.energy_rates import imbalance
from support.planar_loads import interpolated, random_loads
from support.planar_trees import DIGITS, Numbers, Reference, random_tree
from support.programs import Evaluated, random_values
from support.sampling import blocks
from support.tape_values import exact_values

from m4e_fmi.model import Model
from m4e_fmi.model.loads import LOAD_TYPES
from m4e_fmi.multibody import Equations, model_program, topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import Program
from m4e_fmi.runtime.engine import Engine

BLOCKS, TREES = 10, 20
"""So many tests of so many trees."""


def all_random(program: Program, seed: int) -> dict[str, float]:
    """Random states, inputs, added mass, parameters and time."""
    r = random.Random(seed + 1000)
    values = {v.name: v.start * r.uniform(0.9, 1.1) for v in program.parameters}
    return values | random_values(program, seed) | {"time": r.uniform(-1.5, 3)}


def velocity_rates(program: Program) -> list[int]:
    """Nodes of u̇: every second rate."""
    return list(program.rates[1::2])


def check(model: Model, seed: int, algorithms: list[type[ClosedForm] | type[Recursion]]) -> None:
    programs = [recorded(model, topology(model), algorithm) for algorithm in algorithms]
    values = all_random(programs[0], seed)
    with mpmath.workdps(DIGITS):
        reference = Reference(model, values)
        expected = reference.accelerations()
        power = reference.input_work(reference.u)
    for program in programs:
        exact, doubles = errors(program, values, expected)
        # 50 digits, some hundred operations, condition below 1e4
        assert exact < 1e-43, f"tree {seed}"
        # double precision, 1e-16, times the same
        assert doubles < 1e-13, f"tree {seed}"
        if not reference.wet:  # added mass that is not symmetric has no energy
            assert imbalance(program, values, power) < 1e-30, f"tree {seed}"


def errors(program: Program, values: dict[str, float], expected: list[Any]) -> tuple[float, float]:
    """Relative error of u̇ in 50 digits and in doubles, by the largest acceleration."""
    with mpmath.workdps(50):
        largest = max(map(abs, expected))
        exact = exact_values(program, velocity_rates(program), values)
        state = {name: value for name, value in values.items() if name != "time"}
        rates = Evaluated(program).rates(state, t=values["time"])

        def error(found: list[Any]) -> float:
            differences = (abs(a - b) for a, b in zip(found, expected, strict=True))
            return float(max(differences) / largest)

        return error(exact), error(list(rates.values())[1::2])


@pytest.mark.verifies(
    "accelerations by recursion and closed form, all joints and loads",
    independent="from positions alone, mpmath in 50 digits",
    tolerance="1e-43",
)
@pytest.mark.verifies(
    "the same in doubles",
    independent="from positions alone, mpmath in 50 digits",
    tolerance="1e-13",
)
@pytest.mark.verifies(
    "accelerations of the equations of motion of 80 trees; 200 (make verify)",
    published="Sabet and Diaz-Flores Caminero, Eq. (5)",
    tolerance="1e-43",
)
@pytest.mark.parametrize("block", blocks(4, BLOCKS))
def test_trees(block: int) -> None:
    for seed in range(TREES * block, TREES * (block + 1)):
        model = random_tree(seed, size=1 + seed % 12, wet=int(seed % 4 == 0))
        check(model, seed, [Recursion, ClosedForm])


@pytest.mark.verifies(
    "symbolic equations, energies and powers", independent="what runs", tolerance="1e-13"
)
@pytest.mark.parametrize("seed", range(8))
def test_what_people_read_is_what_runs(seed: int) -> None:
    """Mass matrix, forcing, energy and powers of the symbolic equations, in 50 digits."""
    model = random_tree(300 + seed, size=3)
    equations = Equations(model)
    values = all_random(program := model_program(model), seed)
    values |= {v.name: 0.0 for v in program.inputs}
    symbols = [*equations.q, *equations.u, sp.Symbol("t", real=True)]
    symbols += [sp.Symbol(name, real=True) for name in model.parameters]
    tables = {
        name: lambda t, table=table: interpolated(table, t) for name, table in model.tables.items()
    }
    with mpmath.workdps(50):
        states = [mpmath.mpf(values[v.name]) for v in program.states]
        numbers = [*states[0::2], *states[1::2], mpmath.mpf(values["time"])]
        numbers += [mpmath.mpf(values[name]) for name in model.parameters]

        def evaluated(expression: Any) -> Any:
            return sp.lambdify(symbols, expression, [tables, "mpmath"], cse=True)(*numbers)

        forcing, mass_matrix = evaluated(equations.forcing), evaluated(equations.mass_matrix)
        found = list(mpmath.lu_solve(mass_matrix, forcing))
        found.append(evaluated(equations.kinetic_energy + equations.potential_energy))
        found += [evaluated(power) for power in equations.load_powers.values()]
        outputs = dict(zip((v.name for v in program.outputs), program.results, strict=True))
        names = ["energy.total", *(f"load.{name}.power" for name in equations.load_powers)]
        nodes = [*velocity_rates(program), *(outputs[name] for name in names)]
        expected = exact_values(program, nodes, values)
        for a, b in zip(found, expected, strict=True):
            # numbers of a model are decimals there and doubles here
            assert abs(a - b) < 1e-13 * (1 + abs(b))


@pytest.mark.parametrize("seed", range(4))
def test_added_mass_between_bodies(seed: int) -> None:
    check(random_tree(100 + seed, size=4, wet=2 + seed % 2), seed, [ClosedForm])


def test_the_trees_have_all_loads() -> None:
    joints = random_tree(1, size=6).joints
    drawn = (random_loads(Numbers(seed), joints).values() for seed in range(20))
    assert {type(load) for loads in drawn for load in loads} == set(LOAD_TYPES.values())


@pytest.mark.parametrize("seed", range(12))
def test_inputs_that_are_zero_change_no_bit(seed: int) -> None:
    """A simulation leaves them out, an FMU has them: both give the same."""
    model = random_tree(seed, size=1 + seed % 7, wet=seed % 3)
    without = model_program(model, inputs=())
    names = [v.name for v in without.outputs]  # all but the inputs' power
    full, bare = Engine(model_program(model), outputs=names), Engine(without)
    r = random.Random(seed)
    for _ in range(20):
        drawn = random_values(full.program, r.randrange(10**6))
        x = [drawn[v.name] for v in full.program.states]
        p = [drawn.get(v.name, v.start) for v in full.program.parameters]
        for engine in (full, bare):
            engine.set_parameters(p)
        assert full.rates(0.3, x).tolist() == bare.rates(0.3, x).tolist()
        assert full.outputs(0.3, x).tolist() == bare.outputs(0.3, x).tolist()
