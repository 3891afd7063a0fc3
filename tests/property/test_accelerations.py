"""Recursion and closed form against positions alone, in 50 digits, on random trees."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import pytest
from support.planar_trees import DIGITS, Reference, random_tree
from support.programs import Evaluated
from support.tape_values import exact_values

from m4e_fmi.model import Model
from m4e_fmi.multibody import topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.sensitivity import Recursion
from m4e_fmi.program import Program

ALGORITHMS = {"recursion": Recursion, "closed form": ClosedForm}


def random_values(program: Program, seed: int) -> dict[str, float]:
    """Random states, inputs and added mass: an unsymmetric one, but positive definite."""
    r = random.Random(seed)
    groups = (program.inputs, program.states)
    values = {v.name: r.uniform(-1, 1) for group in groups for v in group}
    for parameter in program.parameters:
        if not parameter.name.startswith("added_mass"):
            continue
        i, j = parameter.name.removeprefix("added_mass[").removesuffix("]").split(",")
        values[parameter.name] = r.uniform(2, 3) if i == j else r.uniform(-0.1, 0.1)
    return values


def velocity_rates(program: Program) -> list[int]:
    """Nodes of u̇: every second rate."""
    return list(program.rates[1::2])


def compared(model: Model, seed: int, algorithm: str) -> tuple[float, float]:
    """Relative error of u̇ in 50 digits and in doubles, by the largest acceleration."""
    program = recorded(model, topology(model), ALGORITHMS[algorithm])
    values = random_values(program, seed)
    with mpmath.workdps(DIGITS):
        reference = Reference(model, values).accelerations()
    with mpmath.workdps(50):
        largest = max(map(abs, reference))
        exact = exact_values(program, velocity_rates(program), values)
        doubles = list(Evaluated(program).rates(values).values())[1::2]

        def error(found: list[Any]) -> float:
            differences = (abs(a - b) for a, b in zip(found, reference, strict=True))
            return float(max(differences) / largest)

        return error(exact), error(doubles)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("seed", range(12))
def test_trees(seed: int, algorithm: str) -> None:
    model = random_tree(seed, size=2 + seed % 6, wet=seed % 2)
    exact, doubles = compared(model, seed, algorithm)
    # 50 digits, some hundred operations, condition below 1e4
    assert exact < 1e-43
    # double precision, 1e-16, times the same
    assert doubles < 1e-13


@pytest.mark.parametrize("seed", range(4))
def test_added_mass_between_bodies(seed: int) -> None:
    model = random_tree(100 + seed, size=4, wet=2 + seed % 2)
    exact, doubles = compared(model, seed, "closed form")
    assert exact < 1e-43
    assert doubles < 1e-13
