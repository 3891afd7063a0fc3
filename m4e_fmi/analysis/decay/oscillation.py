"""Free oscillation with linear and quadratic damping, and its derivatives by all parameters.

    ẍ + 2ζω ẋ + b |ẋ| ẋ + ω² (x − x₀) = 0

In the phase θ = ω t and with x − x₀ = A ξ, ẋ = A ω η it has two parameters, ζ and β = b A:

    ξ' = η,   η' = −2ζ η − β |η| η − ξ
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TOLERANCE = 1e-11
"""Of a step of the integration, relative, and absolute in units of the amplitude; errors of a
record of ten periods are below 1e-8."""


class Shape(NamedTuple):
    """Parameters of a motion in units of its amplitude A and of time.

    `omega` ω [1/s], `ratio` ζ, `quadratic` β = b A, `start` (x(0) − x₀)/A, `speed` ẋ(0)/(A ω),
    `rest` x₀/A.
    """

    omega: float
    ratio: float
    quadratic: float
    start: float
    speed: float
    rest: float


def oscillation(shape: Shape, time: Floats) -> tuple[Floats, Floats]:
    """x/A (n,) [1] at `time` (n,) [s] from 0 on, and its derivatives (n, 6) in units of the shape.

    Both are nan where the motion grows without bound.
    """
    from scipy.integrate import ODEintWarning, odeint

    begin = np.zeros(10)
    begin[:2] = shape.start, shape.speed
    begin[4] = begin[9] = 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ODEintWarning)
        found, told = odeint(
            _rates,
            begin,
            shape.omega * time,
            args=(shape.ratio, shape.quadratic),
            rtol=TOLERANCE,
            atol=TOLERANCE,
            mxstep=20_000,
            full_output=True,
        )
    if "successful" not in str(told["message"]) or not np.isfinite(found).all():
        return np.full(len(time), np.nan), np.full((len(time), 6), np.nan)
    columns = [time * found[:, 1], *found.T[2:6], np.ones(len(time))]
    return shape.rest + found[:, 0], np.stack(columns, axis=1)


def _rates(y: Floats, _: float, ratio: float, quadratic: float) -> tuple[float, ...]:
    """Rates of ξ, η, and of the derivatives of both by ratio, quadratic, start and speed."""
    xi, eta, x_ratio, x_quadratic, x_start, x_speed, *by = y.tolist()
    size = abs(eta)
    slope = -2.0 * (ratio + quadratic * size)
    v_ratio, v_quadratic, v_start, v_speed = by
    return (
        eta,
        -(2.0 * ratio + quadratic * size) * eta - xi,
        v_ratio,
        v_quadratic,
        v_start,
        v_speed,
        slope * v_ratio - x_ratio - 2.0 * eta,
        slope * v_quadratic - x_quadratic - size * eta,
        slope * v_start - x_start,
        slope * v_speed - x_speed,
    )
