"""Trees in space against positions alone, in 50 digits, with every kind of joint and load."""

from __future__ import annotations

from typing import Any

import mpmath
import pytest
from support.energy_rates import imbalance
from support.programs import Evaluated, random_values
from support.sampling import blocks
from support.spatial_trees import DIGITS, SpatialReference, spatial_tree
from support.tape_values import exact_values

from m4e_fmi.multibody import topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import Program

ALGORITHMS = (Recursion, ClosedForm)
BLOCKS, TREES = 10, 4
EXACT, DOUBLES = 1e-40, 1e-12


def found_in(
    program: Program, nodes: list[int], values: dict[str, float], *, digits: int = 50
) -> list[Any]:
    with mpmath.workdps(digits):
        return exact_values(program, nodes, values)


def accelerations(program: Program) -> list[int]:
    """Places of u̇ among the rates, in the order of the links."""
    names = [v.name.rpartition(".")[2] for v in program.states]
    return [k for k, name in enumerate(names) if name in VELOCITIES]


VELOCITIES = ("vx", "vy", "vz", "omega_x", "omega", "omega_z", "u", "u1", "u2", "u3")


@pytest.mark.verifies(
    "accelerations in space by recursion and closed form, all joints, loads, added mass",
    independent="Newton and Euler from positions alone, mpmath in 50 digits",
    tolerance="1e-40",
)
@pytest.mark.verifies(
    "the same in doubles",
    independent="Newton and Euler from positions alone, mpmath in 50 digits",
    tolerance="1e-12",
)
@pytest.mark.parametrize("block", blocks(5, BLOCKS))
def test_trees(block: int) -> None:
    for seed in range(TREES * block, TREES * (block + 1)):
        wet = min(seed % 3, 1 + seed % 7)  # of more than one by the closed form alone
        model = spatial_tree(seed, size=1 + seed % 7, wet=wet)
        kinds = ALGORITHMS if wet < 2 else ALGORITHMS[1:]
        programs = [recorded(model, topology(model), algorithm) for algorithm in kinds]
        values = random_values(programs[0], seed)
        with mpmath.workdps(DIGITS):
            reference = SpatialReference(model, values)
            expected = reference.accelerations()
            power = reference.input_power()
        for program in programs:
            places = accelerations(program)
            largest = max(map(abs, expected))
            exact = found_in(program, [program.rates[k] for k in places], values)
            doubles = [*Evaluated(program).rates(values).values()]
            with mpmath.workdps(50):
                pairs = zip(exact, expected, strict=True)
                assert max(abs(a - b) for a, b in pairs) < EXACT * largest, f"tree {seed}"
                pairs = zip((doubles[k] for k in places), expected, strict=True)
                assert max(abs(a - b) for a, b in pairs) < DOUBLES * largest, f"tree {seed}"
            if not wet:  # added mass that is not symmetric has no energy
                assert imbalance(program, values, power) < 1e-30, f"tree {seed}"


@pytest.mark.verifies(
    "reactions in space, all joints and loads",
    independent="Newton and Euler of each body in mpmath",
    tolerance="1e-40",
)
@pytest.mark.parametrize("seed", range(12))
def test_every_body_is_in_balance(seed: int) -> None:
    algorithm = ALGORITHMS[seed % 2]
    wet = seed % 3 if algorithm is ClosedForm else seed % 3 % 2
    model = spatial_tree(100 + seed, size=2 + seed % 5, wet=wet)
    program = recorded(model, topology(model), algorithm)
    values = random_values(program, seed)
    names = [v.name for v in program.outputs]
    found = dict(zip(names, found_in(program, list(program.results), values), strict=True))
    with mpmath.workdps(DIGITS):
        reference = SpatialReference(model, values)
        order = [link.body for link in reference.tree.links]
        parts = ("ax", "ay", "az", "alpha_x", "alpha", "alpha_z")
        rest = reference.needed([found[f"body.{b}.{part}"] for b in order for part in parts])
        loads, efforts = reference.wrenches()
        rest = [a - b for a, b in zip(rest, loads, strict=True)]
        for link in reference.tree.links:
            if link.joint.type == "floating":
                continue
            name, k = f"joint.{link.joint_name}", reference.tree.index(link.body)
            force = mpmath.matrix([found[f"{name}.reaction_{axis}"] for axis in "xyz"])
            moment = mpmath.matrix(
                [found[f"{name}.reaction_{part}"] for part in ("moment_x", "moment", "moment_z")]
            )
            place, R = reference.now[k]
            hinge = place - R * reference.vector(link.joint.joint_to_child)
            reference._push(rest, link.body, *about(hinge - place, -force, -moment))
            if link.parent >= 0:
                arm = hinge - reference.now[link.parent][0]
                reference._push(rest, order[link.parent], *about(arm, force, moment))
        scale = max(map(abs, (*loads, *efforts)))
        assert max(map(abs, rest)) < EXACT * scale


def about(arm: Any, force: Any, moment: Any) -> tuple[Any, Any]:
    """A wrench about a point from which the force is at `arm`."""
    lever = [
        arm[1] * force[2] - arm[2] * force[1],
        arm[2] * force[0] - arm[0] * force[2],
        arm[0] * force[1] - arm[1] * force[0],
    ]
    return force, moment + mpmath.matrix(lever)
