"""Two unit masses on unit springs, to the walls and between them, in two FMUs: errors and orders.

Undamped, x1(0) = 1 m; other masters' errors after 10 s at H = 0.1 s are 0.811 (five of them, stale
feed-through), 0.413 (fresh) and 5.8e-3 (the best, with extrapolated inputs and two passes).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from support.small_systems import Fmus, system, watched

from m4e_fmi.cosim import Simulation, System

TIME = 10.0
STATES = ("a.body.m.x", "a.body.m.vx", "b.x", "b.vx")
_FAST = np.sqrt(3.0)  # rad/s, the second mode; the first is 1 rad/s
MOTION = (
    float(np.cos(TIME) + np.cos(_FAST * TIME)) / 2,
    -float(np.sin(TIME) + _FAST * np.sin(_FAST * TIME)) / 2,
    float(np.cos(TIME) - np.cos(_FAST * TIME)) / 2,
    -float(np.sin(TIME) - _FAST * np.sin(_FAST * TIME)) / 2,
)
"""x and v of both masses after 10 s, [m] and [m/s]."""
EXACT: dict[str, float] = dict(zip(STATES, MOTION, strict=True))
SETTINGS = Simulation(TIME, 0.1)


def two_masses(fmus: Fmus, first: str = "mass+state", second: str = "partner+state") -> System:
    parts, start = {"a": first, "b": second}, {"a": {"stiffness": 1.0, "body.m.x": 1.0}}
    return system(fmus, parts, "a.m <-> b.end", start=start, simulation=SETTINGS)


def two_places(fmus: Fmus, first: str, second: str) -> tuple[System, dict[str, float]]:
    """The same of two partners that tell one another their displacements, and its exact end."""
    links = ("a.x -> b.end.x", "b.x -> a.end.x")
    parts = {"a": first, "b": second}
    given = system(fmus, parts, *links, start={"a": {"x": 1.0}}, simulation=SETTINGS)
    return given, dict(zip(("a.x", "a.vx", "b.x", "b.vx"), MOTION, strict=True))


def two_integrators(fmus: Fmus, first: str, second: str) -> tuple[System, dict[str, float]]:
    """y1' = y2, y2' = -y1, of which nothing can be predicted but from the past; its exact end."""
    links = ("a.y -> b.u", "b.y -> a.u")
    start = {"a": {"y": 1.0}, "b": {"gain": -1.0}}
    given = system(fmus, {"a": first, "b": second}, *links, start=start, simulation=SETTINGS)
    return given, {"a.y": float(np.cos(TIME)), "b.y": -float(np.sin(TIME))}


def errors(
    given: System, exact: Mapping[str, float], steps: Sequence[float], algorithm: str = "corrector"
) -> np.ndarray:
    """The largest error at the end of a run with each of the steps [s]."""
    ends = [watched(given.changed(step_size=h, algorithm=algorithm), *exact)[-1] for h in steps]
    return np.abs(np.array(ends) - list(exact.values())).max(axis=1)


def orders(found: np.ndarray) -> np.ndarray:
    """Orders from each error to the next, of half the step."""
    return np.log2(found[:-1] / found[1:])
