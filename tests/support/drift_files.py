"""WAMIT's files of drift and QTFs, written from functions of frequency."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from pathlib import Path

RHO, G = 1025.0, 9.81
Drift = Callable[[float, float, int], float]
"""D [N/m2, N.m/m2] of ω [rad/s], direction [deg] and motion from 1."""
Pairs = Callable[[float, float, int], complex]
"""Q_ij [N/m2, N.m/m2] of ω_i, ω_j [rad/s] and motion from 1, e^{−iωt}."""


def write_mean(
    path: Path,
    drift: Drift,
    *,
    omega: Sequence[float],
    directions: Sequence[float],
    modes: Sequence[int] = (1, 2, 6),
    ulen: float = 1.0,
) -> Path:
    lines = [" WAMIT    Numeric output"]
    for w in omega:
        for beta in directions:
            for mode in modes:
                value = drift(w, beta, mode) / _unit(mode, ulen)
                numbers = _numbers(complex(value))
                lines.append(f" {2 * math.pi / w:.12E} {beta:.6E} {beta:.6E} {mode:5d} {numbers}")
    path.write_text("\n".join(lines) + "\n")
    return path


def write_qtf(
    path: Path,
    pairs: Pairs,
    *,
    omega: Sequence[float],
    directions: Sequence[float] = (0.0,),
    modes: Sequence[int] = (1, 3, 5),
    both: bool = False,
) -> Path:
    lines = [" WAMIT    Numeric output"]
    for i, one in enumerate(omega):
        for j, other in enumerate(omega):
            if j > i and not both:
                continue
            for beta in directions:
                for mode in modes:
                    value = pairs(one, other, mode).conjugate() / _unit(mode, 1.0)
                    periods = f"{2 * math.pi / one:.12E} {2 * math.pi / other:.12E}"
                    lines.append(f" {periods} {beta:.6E} {beta:.6E} {mode:5d} {_numbers(value)}")
    path.write_text("\n".join(lines) + "\n")
    return path


def _unit(mode: int, ulen: float) -> float:
    return RHO * G * (ulen if (mode - 1) % 6 < 3 else ulen**2)


def _numbers(value: complex) -> str:
    modulus, phase = cmath.polar(value)
    return f"{modulus:.9E} {math.degrees(phase):.6E} {value.real:.12E} {value.imag:.12E}"
