"""Random trees in the plane: B, Ḃ and the mass matrix; outputs are the derivatives they say."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from support.planar_trees import DIGITS, STEP, Reference, random_tree
from support.programs import Evaluated, random_values
from support.sampling import blocks

from m4e_fmi.multibody import closed_form, model_program, topology
from m4e_fmi.multibody.assembly import Scalars, assemble
from m4e_fmi.multibody.closed_form import column_rates, velocity_transformation
from m4e_fmi.program import tangent
from m4e_fmi.space import PLANE

BLOCKS, TREES = 10, 20


class Kinematics(Reference):
    """Of every body from its pose alone, by difference quotients in mpmath."""

    def jacobians(self) -> tuple[np.ndarray, np.ndarray]:
        """B = ∂(x, z, θ)/∂q and Ḃ = Σ ∂B/∂q_k u_k, each (3 bodies, coordinates)."""
        n = len(self.q)
        B, B_dot = (np.zeros((3 * len(self.tree.links), n)) for _ in range(2))
        for j in range(n):
            now, ahead, behind = (self.column(j, side * STEP) for side in (0, 1, -1))
            B[:, j] = now
            B_dot[:, j] = (ahead - behind) / (2 * STEP)
        return B, B_dot

    def column(self, j: int, time: object) -> np.ndarray:
        """∂(x, z, θ)/∂q_j after a time along u."""
        moved = [q + time * u for q, u in zip(self.q, self.u, strict=True)]
        ahead, behind = ([q + s * STEP * (k == j) for k, q in enumerate(moved)] for s in (1, -1))
        rise = np.array(self._poses(ahead)) - np.array(self._poses(behind))
        return rise.ravel() / (2 * STEP)


@pytest.mark.verifies(
    "B, Ḃ and mass matrices of 80 trees with up to 12 bodies; 200 (make verify)",
    independent="positions alone, mpmath in 140 digits",
    tolerance="1e-12",
)
@pytest.mark.parametrize("block", blocks(4, BLOCKS))
def test_velocity_transformations(block: int) -> None:
    """M = Bᵀ(𝓜 + A)B, of doubles; it is positive definite."""
    for seed in range(TREES * block, TREES * (block + 1)):
        drawn = random_tree(seed, size=1 + seed % 12, wet=int(seed % 4 == 0))
        model = replace(drawn, loads={})
        tree = topology(model)
        values = random_values(model_program(model), seed)
        with mpmath.workdps(DIGITS):
            reference = Kinematics(model, values)
            B, B_dot = reference.jacobians()
            inertia = np.array(reference._inertia().tolist(), float)
            q, u = (list(map(float, part)) for part in (reference.q, reference.u))
        rows = range(1, 3 * len(reference.wet) + 1)
        assembly = assemble(
            model,
            tree,
            Scalars(
                q=q, u=u, time=0.0, body_wrench={}, point_force={}, effort={},
                parameters={name: p.value for name, p in model.parameters.items()},
                added_mass=[[values[f"added_mass[{i},{j}]"] for j in rows] for i in rows],
            ),
        )  # fmt: skip
        for k in range(len(tree.links)):
            for expected, found in (
                (B, velocity_transformation(tree, assembly.frames, k)),
                (B_dot, column_rates(tree, assembly.frames, assembly.scalars.u, k)),
            ):
                got = np.zeros((3, len(q)))
                for j, column in found.items():
                    got[:, j] = [column[c] for c in PLANE]
                # sums of at most 25 products of numbers up to 24
                assert got == pytest.approx(expected[3 * k : 3 * k + 3], rel=0, abs=1e-12)
        mass_matrix, composed = B.T @ inertia @ B, np.zeros((len(q), len(q)))
        for i, row in enumerate(closed_form.mass_matrix(assembly)):
            for j, entry in row.items():
                composed[i, j] = entry
        assert composed == pytest.approx(mass_matrix, rel=0, abs=1e-12 * np.abs(mass_matrix).max())
        assert np.linalg.eigvalsh(mass_matrix + mass_matrix.T).min() > 0


@pytest.mark.parametrize("seed", range(20))
def test_outputs_are_the_derivatives_they_say(seed: int) -> None:
    """Along the motion: velocities of positions, accelerations of velocities, powers of works."""
    program = model_program(random_tree(seed, size=1 + seed % 8, wet=seed % 2))
    values, evaluated = random_values(program, seed), Evaluated(program)
    rates = evaluated.rates(values, t=0.7)
    now = {**values, **evaluated.outputs(values, t=0.7)}
    along = {**rates, "time": 1.0}
    change = {**values, **{f"d({name})": rate for name, rate in along.items()}}
    slopes = Evaluated(tangent(program, along)).outputs(change, t=0.7)
    slopes |= {f"d({name})": rate for name, rate in rates.items()}
    pairs = {v.name: v.derivative_of for v in (*program.outputs, *program.states)}
    pairs = {name: base for name, base in pairs.items() if base}
    assert len(pairs) >= 3
    for name, base in pairs.items():
        # some hundred operations in doubles, conditions below 1e4, twice
        assert now[name] == pytest.approx(slopes[f"d({base})"], rel=1e-9, abs=1e-9), name
