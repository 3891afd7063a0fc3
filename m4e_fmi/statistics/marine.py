"""Wave energy: annual energy over sea states, power of waves."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.shown import short
from m4e_fmi.statistics.record import Floats

YEAR = 8766.0 * 3600.0
"""Mean year of 365.25 days [s]."""
MEGAWATT_HOUR = 3.6e9
"""In joules."""
SUM_ROUNDING = 1e-6
"""By how much probabilities of a table that was rounded may add up to more than 1."""


@short
@dataclass(frozen=True)
class AnnualEnergy:
    """Mean `energy` of a year [J] and its standard `error` [J] from the scatter over seeds.

    `covered` is the sum of the probabilities: that of the sea states which are counted.
    """

    energy: float
    error: float
    covered: float

    @property
    def megawatt_hours(self) -> float:
        """The energy in MWh."""
        return self.energy / MEGAWATT_HOUR


def annual_energy(
    power: ArrayLike, probability: ArrayLike, *, shared_seeds: bool = False
) -> AnnualEnergy:
    """Σ p·P over sea states, times 8766 h.

    `power` (…, n_seeds) [W] are means over time, `probability` (…,) [1] those of the sea states;
    what they lack to 1 counts as no power. The standard error is that of independent sea states,
    or, with `shared_seeds`, that over the sums of each seed. It is nan for one seed; both are nan
    where a power of a probable sea state is nan. InputError for shapes that do not fit, and
    probabilities that are negative or add up to more than 1.
    """
    watts, p = np.asarray(power, dtype=float), np.asarray(probability, dtype=float)
    if watts.ndim != p.ndim + 1 or watts.shape[:-1] != p.shape or watts.shape[-1] < 1:
        message = f"power {watts.shape} and probability {p.shape} do not fit each other"
        raise InputError.single(message, "give power (…, n_seeds) and probability (…,)")
    wrong = []
    if not (np.isfinite(p).all() and (p >= 0.0).all()):
        wrong.append(Problem("probabilities must be finite, 0 or more"))
    elif (total := float(p.sum())) > 1.0 + SUM_ROUNDING:
        remedy = "give probabilities, not hours or percent"
        wrong.append(Problem(f"the probabilities add up to {total:.6g}, more than 1", remedy))
    InputError.raise_for(wrong)
    there = p > 0.0
    watts, p, seeds = watts[there], p[there], watts.shape[-1]
    energy = YEAR * float(p @ watts.mean(axis=-1))
    if seeds == 1:
        error = math.nan
    elif shared_seeds:
        error = YEAR * float(np.std(p @ watts, ddof=1)) / math.sqrt(seeds)
    else:
        error = YEAR * math.sqrt(float(p**2 @ watts.var(axis=-1, ddof=1)) / seeds)
    return AnnualEnergy(energy, error, float(p.sum()))


def wave_power(
    height: ArrayLike,
    energy_period: ArrayLike,
    *,
    depth: float = math.inf,
    density: float = 1025.0,
    gravity: float = 9.81,
) -> Floats:
    """Power (…,) [W/m] per metre of crest of irregular waves: ρ g H² c_g/16.

    `height` (…,) [m] is the significant height, `energy_period` (…,) [s] 2π m₋₁/m₀; `density`
    [kg/m3], `gravity` [m/s2]. c_g is the group velocity at the energy period in water of a `depth`
    [m], in deep water g T/(4π). There the power is exact; elsewhere it is within 6 % of that of the
    spectrum, which the formula of deep water misses by up to 16 %.
    """
    h, t = np.asarray(height, dtype=float), np.asarray(energy_period, dtype=float)
    speed = gravity * t / (4.0 * np.pi)
    if math.isfinite(depth):
        speed = speed * _shallower((2.0 * np.pi / t) ** 2 * depth / gravity)
    return np.asarray(density * gravity * h**2 * speed / 16.0, dtype=float)


def _shallower(deep: Floats) -> Floats:
    """Group velocity (…,) [1] over that in deep water, from ω²h/g (…,) [1].

    k h tanh k h = ω²h/g by Newton's method, which converges from above for any depth.
    """
    kh = np.maximum(deep, np.sqrt(deep))
    for _ in range(50):
        tanh = np.tanh(kh)
        step = (kh * tanh - deep) / (tanh + kh * (1.0 - tanh**2))
        kh = kh - step
        if np.all(np.abs(step) <= 1e-14 * kh):
            break
    # 2 kh/sinh 2kh, without the overflow of sinh
    half = 4.0 * kh * np.exp(-2.0 * kh) / -np.expm1(-4.0 * kh)
    return np.tanh(kh) * (1.0 + half)
