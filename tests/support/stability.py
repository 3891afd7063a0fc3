"""The largest communication step with which a coupled pair of oscillators stays bounded."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, start
from m4e_fmi.errors import RunError

LONGEST = 8.0
"""A step [s] that is stable at this length is taken to be so at any."""


@dataclass(frozen=True)
class Pair:
    """Masses [kg], springs to the walls [N/m], and what is between: spring [N/m], damper [N·s/m].

    `loss` [N·s/m] is the damping of each mass to its wall.
    """

    masses: tuple[float, float] = (1.0, 1.0)
    walls: tuple[float, float] = (1.0, 1.0)
    loss: tuple[float, float] = (0.1, 0.1)
    coupling: float = 1.0
    damping: float = 0.0


PAIRS = {
    "spring 1 N/m, damper 0.1 N·s/m": Pair(damping=0.1),
    "spring 10": Pair(coupling=10.0),
    "spring 100, damper 1": Pair(coupling=100.0, damping=1.0),
    "spring 10, damper 1, masses 1 and 10": Pair((1.0, 10.0), coupling=10.0, damping=1.0),
    "spring 10, damper 1, masses 10 and 1": Pair((10.0, 1.0), coupling=10.0, damping=1.0),
    "quarter car": Pair((400.0, 40.0), (0.0, 1.5e5), (0.0, 0.0), 1.5e4, 1e3),
}
ALGORITHMS = {  # name in the table → algorithm, what the FMUs can do
    "jacobi": ("jacobi", "+state"),
    "gauss_seidel": ("gauss_seidel", "+state"),
    "corrector, held": ("corrector", "+state"),
    "corrector, followed": ("corrector", "+state+inputs"),
    "implicit, held": ("implicit", "+state"),
    "implicit, followed": ("implicit", "+state+inputs"),
}
OBSERVED = {
    "fd": ("a.body.m.x", "a.body.m.vx", "b.x", "b.vx", "b.end.force_x"),
    "dd": ("a.x", "a.vx", "b.x", "b.vx"),
}
Make = Callable[[float], System]
ROUNDING = 1e-12
"""Error of the course, over its size."""
TOO_LARGE = 1e100
"""A course that comes here grows, and squares of it would overflow."""
POINTS = 60
"""Steps whose course tells the eigenvalues."""


def pair(fmus: Callable[[str], Path], given: Pair, how: str, algorithm: str, options: str) -> Make:
    """`make(step)`: the pair as two FMUs, force against displacement (`fd`) or `dd`."""
    common = {"coupling": given.coupling, "damping": given.damping}
    second = {
        "mass": given.masses[1],
        "stiffness": given.walls[1],
        "wall_damping": given.loss[1],
        **common,
    }
    b = Component("b", FmuFile(fmus(f"partner{options}")), second)
    if how == "fd":
        first = {"mass": given.masses[0], "stiffness": given.walls[0], "damping": given.loss[0]}
        a = Component("a", FmuFile(fmus(f"mass{options}")), {**first, "body.m.x": 1.0})
        links: tuple[str, ...] = ("a.m <-> b.end",)
    else:
        first = {
            "mass": given.masses[0],
            "stiffness": given.walls[0],
            "wall_damping": given.loss[0],
            **common,
            "x": 1.0,
        }
        a = Component("a", FmuFile(fmus(f"partner{options}")), first)
        links = tuple(
            f"{source}.{value} -> {target}.end.{value}"
            for source, target in ("ab", "ba")
            for value in ("x", "vx")
        )

    def make(step: float) -> System:
        return System("pair", (a, b), links, Simulation(POINTS * step, step, algorithm))

    return make


def growth(system: System, names: tuple[str, ...]) -> float:
    """The largest magnitude of an eigenvalue of the step, from the course of `names`.

    The coupling of linear FMUs is linear in what it keeps from step to step, so each two points in
    a row follow linearly from the two before: the matrix is fitted, and its eigenvalues are those
    of the coupling, as far as the course excites them. inf if the run fails or ends `TOO_LARGE`.
    """
    rows = []
    try:
        with start(system, certify=False) as run:
            rows += [[point[name] for name in names] for point in run]
    except RunError:  # an overflow, or an implicit step without a solution
        return math.inf
    course = np.array(rows)
    if np.abs(course).max() > TOO_LARGE:
        return math.inf
    course = np.hstack([course[:-1], course[1:]])
    scale = np.linalg.norm(course[:-1], axis=1, keepdims=True)
    matrix = np.linalg.lstsq(course[:-1] / scale, course[1:] / scale, rcond=ROUNDING)[0]
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def largest_stable_step(make: Make, names: tuple[str, ...]) -> float:
    """The step [s] up to which nothing grows, to 1 %; `LONGEST` if that is stable as all before."""

    def grows(step: float) -> bool:
        return growth(make(round(step, 6)), names) > 1 + 1e-8

    steps = np.geomspace(2e-3, LONGEST, 40)
    first = next((k for k, step in enumerate(steps) if grows(step)), None)
    if first is None:
        return LONGEST
    low, high = steps[max(first - 1, 0)], steps[first]
    while high / low > 1.01:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if grows(middle) else (middle, high)
    return float(low)
