"""The best passive fit of one group of coupled motions: its order, its frequencies, its A∞."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory.group_data import GroupData
from m4e_adapters.hydrodynamics.memory.passivity import UnprovenError, passive_fit
from m4e_adapters.hydrodynamics.memory.radiation_group import RadiationGroup
from m4e_adapters.hydrodynamics.memory.reach import Reach
from m4e_fmi.errors import InputError

ORDERS = (4, 5, 6, 8, 10, 12, 16)
LAST_ORDER = 20  # tried where all of these are poor
EVALUATIONS = 10  # of the poles' least squares, derivatives not counted
NEAR_BEST = 1.5  # how much larger an error than the best is accepted for fewer states
DISAGREE = 0.01  # error of A over A∞ from which A∞ is fitted too


def fit_group(
    data: Coefficients,
    motions: tuple[int, ...],
    signal: np.ndarray,
    sound: np.ndarray,
    *,
    reach: Reach,
    order: int | None,
) -> RadiationGroup:
    """The best fit of one group: to all data, or to the data that the panels resolve.

    `signal` (n, n), booleans: pairs of motions that count. `sound` (nω,), booleans: frequencies
    that count. The shorter data are used if the fit to all is poor or changes A∞, and if they give
    a better one where the panels resolve the waves. If that is poor, too, data that scatter are
    left out, provided that this makes a better fit there that is not poor. InputError if no
    passive fit is found.
    """

    def within(limits: Reach) -> GroupData:
        return GroupData(data, motions, signal, sound, limits)

    found = _fitted(within(reach), order)
    shorter, own = reach.shorter(), list(motions)
    doubtful = found is None or found.misfit.is_poor or found.change > 0
    if doubtful and (shorter.fitted < reach.fitted)[own].any():
        other = _fitted(within(shorter), order)
        if found is None or (other is not None and other.misfit.demerit < found.misfit.demerit):
            found = other
    if found is None or found.misfit.is_poor:
        smooth = reach.smooth(data, motions)
        if (smooth.fitted < shorter.fitted)[own].any():
            values = within(smooth)
            other = _fitted(values, order)
            if other is not None and not other.misfit.is_poor and _is_better(other, found, values):
                found = replace(other, scattered=True)
    if found is None:
        raise InputError.single(
            "no passive radiation memory was found", "use another radiation.order"
        )
    return found


def _is_better(one: RadiationGroup, other: RadiationGroup | None, values: GroupData) -> bool:
    """True if a fit to `values` is better there than another fit, of which there may be none."""
    if other is None:
        return True
    misfit, _ = values.misfits(other.poles, other.residues, other.surplus)
    return one.misfit.demerit < misfit.demerit


def _fitted(values: GroupData, order: int | None) -> RadiationGroup | None:
    """The best fit to the values; with an A∞ of its own where that halves the error."""
    given = _best(values, order, offset=False)
    if given is not None and given.misfit_of_all.error < DISAGREE:
        return given
    other = _best(values, order, offset=True)
    if given is None:
        return other
    worth = other is not None and other.misfit_of_all.error < given.misfit_of_all.error / 2
    return other if worth else given


def _best(values: GroupData, order: int | None, *, offset: bool) -> RadiationGroup | None:
    """The fit with the fewest poles that is good, or nearly as good as any; None: none passive."""
    samples = values.samples(offset=offset)
    fits: list[RadiationGroup] = []
    for k in (*ORDERS, LAST_ORDER) if order is None else (order,):
        if k == LAST_ORDER and any(not fit.misfit_of_all.is_poor for fit in fits):
            break
        try:
            fit = passive_fit(samples, order=k, evaluations=EVALUATIONS)
        except UnprovenError:
            continue
        fits.append(values.judged_fit(fit))
        if fits[-1].misfit_of_all.demerit <= 1:
            break
    if not fits:
        return None
    best = min((fit.misfit_of_all for fit in fits), key=lambda misfit: misfit.demerit)
    enough = max(1.0, best.demerit if best.is_poor else NEAR_BEST * best.demerit)
    return next(fit for fit in fits if fit.misfit_of_all.demerit <= enough)
