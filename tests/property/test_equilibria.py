"""Random trees on springs settle: at rest, stable, and lower than where they started."""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest
from support.planar_trees import random_tree
from support.programs import Evaluated

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.model import Model, Point, TensionSpring, TorsionSpring
from m4e_fmi.multibody import model_program


def on_springs(seed: int) -> Model:
    """A random tree whose loads are springs: one from afar and one against turning at each body."""
    model = random_tree(seed, size=2 + seed % 8)
    r = random.Random(seed)
    points, loads = dict(model.points), {}
    for k, body in enumerate(model.bodies):
        points[f"eye{k}"] = Point(body, (0.3, 0.2))
        points[f"hook{k}"] = Point("ground", (r.uniform(-5, 5), r.uniform(5, 15)))
        ends = (f"hook{k}", f"eye{k}")
        loads[f"spring{k}"] = TensionSpring(ends, r.uniform(5, 50), r.uniform(1, 8))
        ends = ("ground", body)
        loads[f"twist{k}"] = TorsionSpring(ends, r.uniform(1, 5), r.uniform(-1, 1))
    return replace(model, points=points, loads=loads)


@pytest.mark.verifies(
    "equilibria: accelerations left, stability, energy that falls",
    analytic="statics",
    tolerance="1e-9",
)
@pytest.mark.parametrize("seed", range(20))
def test_trees_on_springs(seed: int) -> None:
    model = on_springs(seed)
    found = equilibrium(model)
    linear = linearize(model, at=found)
    # Newton's last step is below 1e-12, and stiffness by mass some 1e2
    assert np.abs(linear.rates).max() < 1e-9
    assert linear.mechanical is not None
    K = linear.mechanical.K
    # the stiffness of a conservative system is symmetric, and positive where it is stable
    assert pytest.approx(K.T, abs=1e-9 * np.abs(K).max()) == K
    assert np.linalg.eigvalsh(K).min() > 0
    assert modes(linear).stable
    evaluated = Evaluated(model_program(model))
    states = {v.name: found[v.name] for v in found.program.states}
    start, end = (evaluated.outputs(values)["energy.potential"] for values in ({}, states))
    assert end < start
