"""Delay of a signal through a chain of components, as the phase of an oscillation.

A unit mass on a unit spring moves as cos(t); each component of the chain is y' = u − y, which turns
the phase by 45 degrees. At 1 rad/s a phase error is a delay in seconds.
"""

from __future__ import annotations

from math import atan2, pi

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system

from m4e_fmi.cosim import Simulation

STEP, PERIODS = 0.1, 5


def delay(fmus: Fmus, algorithm: str, options: str, count: int) -> float:
    """Delay [s] of the last of `count` components over the last period."""
    # listed against the flow: the order is found
    parts = {f"c{k}": f"lag{options}" for k in reversed(range(count))} | {"a": f"mass{options}"}
    links = ["a.body.m.x -> c0.u, units ignored"]
    links += [f"c{k}.y -> c{k + 1}.u" for k in range(count - 1)]
    start = {"a": {"stiffness": 1.0, "body.m.x": 1.0}}
    settings = Simulation(STEP * round(2 * pi * PERIODS / STEP), STEP, algorithm)
    chain = system(fmus, parts, *links, start=start, simulation=settings)
    rows, _ = observed(chain, f"c{count - 1}.y", certify=False)
    t, y = np.array(rows[-round(2 * pi / STEP) :]).T
    waves = np.column_stack([np.cos(t), np.sin(t)])
    cosine, sine = np.linalg.lstsq(waves, y, rcond=None)[0]
    return atan2(sine, cosine) - count * pi / 4


@pytest.mark.verifies(
    "delay of a signal through one to three components: none, but H/2 each with `jacobi`",
    analytic="phase of first-order lags",
    tolerance="2.5e-3 s",
)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize(
    ("algorithm", "options", "expected"),
    [
        ("jacobi", "+state", STEP / 2),
        ("gauss_seidel", "+state", 0.0),
        ("corrector", "+state", 0.0),
        ("corrector", "+state+inputs", 0.0),
        ("implicit", "+state", 0.0),
    ],
)
def test_delay(c_fmu: Fmus, algorithm: str, options: str, expected: float, count: int) -> None:
    found = delay(c_fmu, algorithm, options, count)
    # H²/4, what held values change of a phase beyond the delay; transients are e^(-25) by then
    assert found / count == pytest.approx(expected, abs=2.5e-3)
