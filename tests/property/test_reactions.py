"""Newton and Euler for every single body of random trees, cut free from its joints.

The loads on a body are what they do, by virtual work in mpmath, when this body alone is moved. What
its joints exert are the program's outputs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import mpmath
import pytest
from support.planar_trees import DIGITS, Reference, random_tree
from support.programs import Evaluated, random_values
from support.tape_values import exact_values

from m4e_fmi.model import Model
from m4e_fmi.multibody import topology
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.recording import recorded
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.program import Program

ALGORITHMS = {"recursion": Recursion, "closed form": ClosedForm}
WRENCH = ("reaction_x", "reaction_z", "reaction_moment")


class CutFree(Reference):
    """Three more coordinates for each body move it alone; what acts at joints is left out."""

    def __init__(self, model: Model, values: Mapping[str, Any]) -> None:
        loads = {name: load for name, load in model.loads.items() if not hasattr(load, "joint")}
        free = {name: value for name, value in values.items() if not name.endswith(".effort")}
        super().__init__(replace(model, loads=loads), free)
        self.size = len(self.q)
        self.q += [mpmath.mpf(0)] * (3 * len(self.tree.links))
        self.u += [mpmath.mpf(0)] * (3 * len(self.tree.links))

    def poses(self, q: list[Any]) -> list[tuple[Any, Any, Any]]:
        moved = [q[k : k + 3] for k in range(self.size, len(q), 3)]
        pairs = zip(super().poses(q[: self.size]), moved, strict=True)
        return [(x + dx, z + dz, theta + turn) for (x, z, theta), (dx, dz, turn) in pairs]

    def load(self, row: int) -> Any:
        """Force or moment on one body: the work along the row-th of the coordinates added."""
        return self._work([mpmath.mpf(k == self.size + row) for k in range(len(self.q))])


def residuals(model: Model, values: Mapping[str, Any], found: Mapping[str, Any]) -> list[Any]:
    """(𝓜 + A)v̇ − loads − joints of every body, by the largest load on any."""
    reference = CutFree(model, values)
    order = [link.body for link in reference.tree.links]
    loads = [reference.load(row) for row in range(3 * len(order))]
    motion = mpmath.matrix([found[f"body.{b}.{a}"] for b in order for a in ("ax", "az", "alpha")])
    rest = [a - b for a, b in zip(reference._inertia() * motion, loads, strict=True)]
    for name, joint in model.joints.items():
        if joint.type == "floating":
            continue
        x, z, turn = (found[f"joint.{name}.{part}"] for part in WRENCH)
        back = [-reference.number(part) for part in joint.joint_to_child]
        hinge = reference.placed(reference.pose(joint.child, reference.q), back)
        for body, side in ((joint.child, 1), (joint.parent, -1)):
            if body == "ground":
                continue
            own = reference.pose(body, reference.q)
            arm = (hinge[0] - own[0], hinge[1] - own[1])
            row = 3 * order.index(body)
            rest[row] -= side * x
            rest[row + 1] -= side * z
            rest[row + 2] -= side * (turn + arm[1] * x - arm[0] * z)
    scale = max(map(abs, loads))
    return [part / scale for part in rest]


def outputs_of(program: Program, values: Mapping[str, float], *, exact: bool) -> dict[str, Any]:
    """States and outputs by name, in 50 digits or in doubles."""
    states = {v.name: values[v.name] for v in program.states}
    if not exact:
        return {**states, **Evaluated(program).outputs(values)}
    names = [v.name for v in program.outputs]
    return {
        **states,
        **dict(zip(names, exact_values(program, program.results, values), strict=True)),
    }


@pytest.mark.verifies(
    "reactions of every joint, all joints and loads",
    independent="Newton and Euler of each body, loads by virtual work in mpmath, 50 digits",
    tolerance="1e-43",
)
@pytest.mark.verifies(
    "the same in doubles",
    independent="Newton and Euler of each body, loads by virtual work in mpmath, 50 digits",
    tolerance="1e-12",
)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("seed", range(10))
def test_every_body_is_in_balance(seed: int, algorithm: str) -> None:
    wet = (0, 1, 0, 2)[seed % 4] if algorithm == "closed form" else seed % 2
    model = random_tree(seed, size=2 + seed % 6, wet=wet)
    program = recorded(model, topology(model), ALGORITHMS[algorithm])
    values = random_values(program, seed)
    with mpmath.workdps(50):
        found = outputs_of(program, values, exact=True)
    with mpmath.workdps(DIGITS):
        # 50 digits, some hundred operations, condition below 1e4
        assert max(map(abs, residuals(model, values, found))) < 1e-43
        # double precision, 1e-16, times the same
        found = outputs_of(program, values, exact=False)
        assert max(map(abs, residuals(model, values, found))) < 1e-12


def test_joints_exert_along_their_freedom_what_drives_them() -> None:
    """The effort of a hinge is its moment, that of a slider its force along the direction."""
    sliders = hinges = 0
    for seed in range(6):
        model = replace(random_tree(seed, size=6), loads={})
        program = recorded(model, topology(model), Recursion)
        values = random_values(program, seed)
        found = outputs_of(program, values, exact=False)
        for name, joint in model.joints.items():
            if joint.type == "floating":
                assert f"joint.{name}.reaction_x" not in found
                continue
            x, z, turn = (found[f"joint.{name}.{part}"] for part in WRENCH)
            effort = values.get(f"joint.{name}.effort")
            if joint.type == "revolute":
                hinges += 1
                assert turn == effort
                continue
            if joint.type != "prismatic":
                continue
            sliders += 1
            dx, dz = (model.parameters[str(part)].value for part in joint.direction or ())
            angle = mpmath.mpf(found.get(f"body.{joint.parent}.theta", 0.0))
            along = x * (mpmath.cos(angle) * dx + mpmath.sin(angle) * dz)
            along += z * (mpmath.cos(angle) * dz - mpmath.sin(angle) * dx)
            # double precision, 1e-16, times conditions below 1e4
            assert float(along / mpmath.hypot(dx, dz)) == pytest.approx(effort, abs=1e-11)
    assert min(sliders, hinges) > 5
