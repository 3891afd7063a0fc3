"""Radiation memory: the retardation functions K(jω) = B + jω(A − A∞) as a stable state space.

Motions that are coupled (directly or through others) form a group; a group's whole symmetric matrix
is fitted with *one* set of poles. The states are then driven by the velocities, poles × motions of
them, instead of poles × pairs of motions, and the fitted matrix is exactly symmetric. A single
body symmetric fore and aft has the groups {surge, pitch} and {heave}.

The fits are strictly proper (relative degree one), as K is: K → K(t=0)/(jω). That carries them
beyond the table. K(0) = 0 (a steady velocity feels no memory) is fitted as a further value, and the
residues are chosen among those that make the matrix passive at all frequencies.

Of each motion the frequencies up to its `Coefficients.memory_limits` are used, and further, as far
as the panels resolve the waves, while B is more than `reach.TAIL` of its largest. Beyond, values
are small, and panel errors break the causality that ties B to A first. Where the fit is poor, the
frequencies that the panels do not resolve are left out altogether, and the tail follows from A∞ and
causality; that is kept if it is better where the data are good.

Where A(ω) is not what A∞ and B say it should be, A∞ is the one that fits best.

A `convolution` takes the place of the fit on request: a reference that needs more states.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory import soundness
from m4e_adapters.hydrodynamics.memory.convolution import ConvolutionGroup, convolved_group
from m4e_adapters.hydrodynamics.memory.group_fit import MemoryGroup, RadiationGroup, kept_group
from m4e_adapters.hydrodynamics.memory.reach import Reach, check_counts
from m4e_fmi.errors import InputError

USELESS = 0.2  # error from which a fit is refused
LARGE_CHANGE = 0.05  # of A∞ by the fit, over A∞, that is warned of
COARSE = (
    "use more panels where they are coarse for the highest waves, or a lower frequencies.maximum; "
    "for bodies far apart, whose waves arrive late, raise frequencies.count"
)
REMEDY = f"raise radiation.order or leave it out; {COARSE}"
NEGLIGIBLE = 1e-3  # coupling, relative to the geometric mean of the motions' own
SILENT = 1e-6  # largest B over ω A∞ below which a motion has no memory
FELT = 1e-4  # likewise, B over ω times the displaced water's inertia: a damping ratio below 5e-5
STILL_LARGE = 0.5  # B over its largest, at the end of the data, from which a warning is given
NEARLY = 0.95  # of a motion's memory limit: data up to there are complete


@dataclass(frozen=True)
class RadiationMemory:
    """The `groups` of all motions that radiate, and A∞ (n, n) [kg, kg.m, kg.m2] to go with them."""

    groups: tuple[RadiationGroup | ConvolutionGroup, ...]
    added_mass_inf: np.ndarray


def fit_radiation(
    coefficients: Coefficients,
    *,
    order: int | None = None,
    convolution: bool = False,
    progress: Callable[[str], object] = lambda _: None,
) -> RadiationMemory:
    """The memory of all motions; `progress` is told its accuracy, and warnings.

    `order` is the number of poles of each group. None: the smallest that is accurate enough, or
    nearly the best if none is. A `convolution` has none, and is not fitted. InputError if the best
    is useless, or if the data make energy.
    """
    signal = soundness.meaningful(coefficients)
    reach = Reach.of(coefficients)
    below = coefficients.omega[:, None] <= reach.resolved
    check_counts(coefficients, reach)
    sound = soundness.dissipative(coefficients, below & _radiating(coefficients), progress)
    data = soundness.symmetric(coefficients, below, progress)
    added_mass_inf = data.added_mass_inf.copy()
    groups, coupled = [], _coupled(data, signal)
    radiating = {motion // data.per_body for motions in coupled for motion in motions}
    for k, name in enumerate(data.bodies):
        if k not in radiating:
            progress(f"note: body {name!r} has no radiation memory: it makes almost no waves")
    for motions in coupled:
        if convolution:
            group = convolved_group(data, motions, signal, sound, reach=reach)
        else:
            group = kept_group(
                data, motions, signal, sound, reach=reach, order=order, progress=progress
            )
        text = _report(group, data)
        if group.error > USELESS:
            raise InputError.single(text, COARSE if convolution else REMEDY)
        told = group.misfit.is_poor or group.change > LARGE_CHANGE
        remedy = COARSE if convolution else REMEDY
        progress(f"warning: {text}: {remedy}" if told else text)
        _tell_of_early_ends(group, data, progress)
        added_mass_inf[np.ix_(motions, motions)] += group.surplus
        groups.append(group)
    soundness.check_added_mass_inf(data, added_mass_inf)
    return RadiationMemory(tuple(groups), added_mass_inf)


def _coupled(data: Coefficients, signal: np.ndarray) -> list[tuple[int, ...]]:
    """Groups of motions connected by damping or memory that is not negligible."""
    from scipy.sparse.csgraph import connected_components

    used = data.omega[:, None] <= data.memory_limits
    both = used[:, :, None] & used[:, None, :]
    damping = data.radiation_damping * both
    surplus = (data.added_mass - data.added_mass_inf) * both
    inertia = np.abs(data.added_mass_inf.diagonal())
    own = damping.diagonal(axis1=1, axis2=2).max(axis=0)
    radiates = _radiating(data)
    linked = signal & np.outer(radiates, radiates)
    shares = [
        np.abs(values).max(axis=0) / np.sqrt(np.where(linked, np.outer(size, size), 1.0))
        for values, size in ((damping, own), (surplus, inertia))
    ]
    linked &= np.maximum(*shares) > NEGLIGIBLE
    _, labels = connected_components(linked, directed=False)
    groups: dict[int, list[int]] = {}
    for motion in np.flatnonzero(radiates):
        groups.setdefault(int(labels[motion]), []).append(int(motion))
    return [tuple(members) for members in groups.values()]


def _radiating(data: Coefficients) -> np.ndarray:
    """True for the motions (n,), booleans, that have a memory; the damping of others is noise."""
    used = data.omega[:, None] <= data.memory_limits
    diagonal = data.radiation_damping.diagonal(axis1=1, axis2=2) * used
    inertia = np.abs(data.added_mass_inf.diagonal())
    least = np.maximum(SILENT * inertia, FELT * soundness.displaced_inertia(data))
    return (diagonal / data.omega[:, None]).max(axis=0) > least


def _tell_of_early_ends(
    group: MemoryGroup, data: Coefficients, progress: Callable[[str], object]
) -> None:
    """Warn of data that end where a motion's damping is still large."""
    told = []
    for end, motion in zip(group.ends.tolist(), group.motions, strict=True):
        own = data.radiation_damping[data.omega <= end, motion, motion]
        share = float(own[-1] / own.max())
        if share > STILL_LARGE and end < NEARLY * data.memory_limits[motion]:
            told.append(f"{data.motions[motion]} at {end:.3g} rad/s ({100 * share:.2g} %)")
    if told:
        progress(
            "warning: the data of the radiation memory end where the damping is still more than "
            f"half its largest value: {', '.join(told)}; beyond, it follows from added mass and "
            "causality and may be off by tens of percent: raise frequencies.maximum; use more "
            "panels where they are coarse for the highest waves"
        )


def _beyond(group: RadiationGroup | ConvolutionGroup, data: Coefficients) -> str:
    """The largest difference from any of the computed damping, in words."""
    own = data.radiation_damping.diagonal(axis1=1, axis2=2)[:, list(group.motions)]
    found = np.real(group.transfer(data.omega)).diagonal(axis1=1, axis2=2)
    share = np.abs(found - own) / own.max(axis=0)
    at, motion = np.unravel_index(int(share.argmax()), share.shape)
    return (
        f" (of all {len(data.omega)} frequencies, up to {data.omega[-1]:.3g} rad/s, the damping "
        f"differs by at most {100 * share[at, motion]:.2g} % of the motion's largest, "
        f"{data.motions[group.motions[motion]]} at {data.omega[at]:.3g} rad/s)"
    )


def _report(group: RadiationGroup | ConvolutionGroup, data: Coefficients) -> str:
    names = ", ".join(data.motions[k] for k in group.motions)
    kind = group.text if isinstance(group, ConvolutionGroup) else f"order {group.order}"
    text = (
        f"radiation of {names}: {kind}, error {100 * group.error:.2g} %, of the "
        f"damping at most {100 * group.misfit.damping_error:.2g} % "
        f"({data.motions[int(group.misfit.motion)]} at {group.misfit.omega:.3g} rad/s)"
    )
    ends = np.minimum(data.memory_limits[list(group.motions)], data.omega[-1])
    if (group.resolved < ends).any():
        text += f" where the panels resolve the waves, up to {group.resolved.min():.3g} rad/s"
        text += _beyond(group, data)
    if group.doubtful:
        left_out = ", ".join(f"{w:.3g}" for w in group.doubtful)
        text += f", data off the line at {left_out} rad/s"
    if group.change > 0:
        source = "A(ω) and B" if isinstance(group, ConvolutionGroup) else "the fit"
        masses = ", ".join(
            f"{data.motions[k]} {value:.4g} for {value - more:.4g}"
            for k, value, more in zip(
                group.motions,
                data.added_mass_inf.diagonal()[list(group.motions)] + group.surplus.diagonal(),
                group.surplus.diagonal(),
                strict=True,
            )
        )
        text += f"; A(ω) and A∞ disagree, A∞ is by {source}: {masses}"
    return text
