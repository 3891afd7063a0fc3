"""Checks of potential-flow data before a memory is fitted to them.

A(ω) and B(ω) are symmetric (reciprocity) and B is positive semidefinite (waves carry energy away):
as matrices, at each frequency. Panels spoil both a little. Where a frequency spoils them much, as
the irregular ones, narrow gaps and moonpools do, it is left out; where many do, the data are
refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory.vector_fitting import Complex
from m4e_fmi.errors import InputError
from m4e_fmi.shown import first_of

NEGATIVE = 0.02  # of B, each motion scaled by its largest: what panels may make
ASYMMETRIC = 0.05  # |X_ij − X_ji|, likewise, that is told
MOST_LEFT_OUT = 0.1  # of all frequencies
OUTLIER = 10.0  # distance from the line, in medians, from which a frequency is left out
SMOOTH = 2e-3  # least median, relative to the largest value of each motion
STANDS_OUT = 4.0  # likewise, in the largest distance of the neighbours from the line without it
RUN = 2  # neighbouring frequencies that are off the line together
FEWEST = 8  # frequencies of which a line is known, and a memory
MEANT = 2.0
SHOWN = 4  # frequencies in a message
REMEDY = (
    "look at the panels there: a finer mesh, a lid against irregular frequencies, a wider gap, or "
    "a lower frequencies.maximum"
)


def scales(values: np.ndarray) -> np.ndarray:
    """Square roots (n,) of the largest |diagonal| of `values` over frequencies; 1 where all are 0.

    `values` (nω, n, n) or (n, n), in any unit; its root is that of the result.
    """
    largest = np.sqrt(np.abs(values.diagonal(axis1=-2, axis2=-1)).reshape(-1, values.shape[-1]))
    found = largest.max(axis=0)
    return np.where(found > 0, found, 1.0)


def symmetric(
    coefficients: Coefficients, used: np.ndarray, progress: Callable[[str], object]
) -> Coefficients:
    """The data made symmetric; a warning tells how far those `used` (nω, n), booleans, were not."""
    made, told = {}, []
    both = used[:, :, None] & used[:, None, :]
    for name in ("added_mass", "radiation_damping", "added_mass_inf"):
        values = getattr(coefficients, name)
        other = values.swapaxes(-1, -2)
        made[name] = 0.5 * (values + other)
        counts = both if values.ndim == 3 else True
        size = scales(values * counts)
        error = np.abs(values - other) * counts / np.outer(size, size)
        error = error.reshape(-1, *error.shape[-2:]).max(axis=0)
        if error.max() > ASYMMETRIC:
            i, j = np.unravel_index(int(error.argmax()), error.shape)
            first, second = coefficients.motions[i], coefficients.motions[j]
            told.append(f"{name} of {first} and {second} by {100 * error.max():.2g} %")
    if told:
        progress(
            "warning: the coefficients are not symmetric, as reciprocity requires: "
            f"{', '.join(told)} of the motions' own; the mean of both halves is used: finer panels "
            "bring them together"
        )
    return replace(coefficients, **made)


def displaced_inertia(coefficients: Coefficients) -> np.ndarray:
    """Mass m, for rotations m V^(2/3), of the water each body displaces, (n,) [kg, kg.m2]."""
    lifted = coefficients.buoyancy[coefficients.heave :: coefficients.per_body]
    mass = np.abs(lifted) / coefficients.gravity
    turned = mass * np.cbrt(mass / coefficients.density) ** 2
    kinds = [turned if m.is_rotation else mass for m in coefficients.body_motions]
    return np.stack(kinds, axis=1).ravel()


def check_added_mass_inf(coefficients: Coefficients, added_mass_inf: np.ndarray) -> None:
    """InputError if A∞ gives some motion a negative mass by more than rounding.

    `added_mass_inf` (n, n) [kg, kg.m, kg.m2], symmetric.

    Each motion is scaled by its own A∞, and not by less than NEGATIVE of the displaced water's.
    """
    least = NEGATIVE * displaced_inertia(coefficients)
    size = np.sqrt(np.maximum(np.abs(added_mass_inf.diagonal()), least))
    size = np.where(size > 0, size, 1.0)
    values, vectors = np.linalg.eigh(added_mass_inf / np.outer(size, size))
    if values[0] >= -NEGATIVE:
        return
    share = np.abs(vectors[:, 0])
    motions = [coefficients.motions[i] for i in np.flatnonzero(share > 0.3 * share.max())]
    raise InputError.single(
        f"the added mass at infinite frequency of {', '.join(motions)} is negative, by "
        f"{-100 * values[0]:.2g} % of the motions' own",
        "look at the panels: bodies that touch, thin walls, a finer mesh; of coefficients from "
        "elsewhere, look at signs and units",
    )


def meaningful(coefficients: Coefficients) -> np.ndarray:
    """True for the pairs of motions (n, n), booleans, of which the raw data are more than noise.

    A pair is noise where what its two halves have in common, squared and summed over frequencies,
    is not MEANT times what they differ by, neither in A nor in B: of pure noise both are the same.
    """
    found = np.zeros(coefficients.added_mass_inf.shape, dtype=bool)
    for values in (coefficients.added_mass, coefficients.radiation_damping):
        other = values.swapaxes(-1, -2)
        common, apart = (np.square(x).sum(axis=0) for x in (values + other, values - other))
        found |= common > MEANT * apart
    return found


def dissipative(
    coefficients: Coefficients, used: np.ndarray, progress: Callable[[str], object]
) -> np.ndarray:
    """True for the frequencies (nω,), booleans, at which the raw data have no negative damping.

    `used` (nω, n), booleans, are the data that count. Negative is an eigenvalue of their damping
    matrix below −NEGATIVE, and by more than its two halves differ. InputError if many frequencies
    have one; else `progress` is told of those that are left out.
    """
    damping = coefficients.radiation_damping * (used[:, :, None] & used[:, None, :])
    size = scales(damping)
    scaled = damping / np.outer(size, size)
    other = scaled.swapaxes(1, 2)
    values, vectors = np.linalg.eigh(0.5 * (scaled + other))
    doubt = np.linalg.norm(0.5 * (scaled - other), ord=2, axis=(1, 2))
    bad = values[:, 0] < -np.maximum(NEGATIVE, doubt)
    if not bad.any():
        return ~bad
    k = int(np.argmin(np.where(bad, values[:, 0], 0.0)))
    share = np.abs(vectors[k, :, 0])
    motions = [coefficients.motions[i] for i in np.flatnonzero(share > 0.3 * share.max())]
    text = (
        f"the radiation damping of {', '.join(motions)} is negative at "
        f"{_frequencies(coefficients.omega[bad])} (by {-100 * values[k, 0]:.2g} % of its largest "
        f"value at {coefficients.omega[k]:.4g} rad/s): waves would bring energy"
    )
    if bad.sum() > MOST_LEFT_OUT * used.any(axis=1).sum():
        raise InputError.single(text, REMEDY)
    progress(f"warning: {text}; left out: {REMEDY}")
    return ~bad


def on_the_line(omega: np.ndarray, responses: Complex, known: np.ndarray) -> np.ndarray:
    """True for the frequencies (n,), booleans, that agree with the cubic through their neighbours.

    These are two on either side. Only `known` (m, n), booleans, values of the `responses` (m, n)
    [1] at `omega` (n,) [rad/s] count. A frequency is off the line if it,
    or a RUN of neighbours with it, is far from the cubic across the gap, and the neighbours are on
    the line of the others: at a steep peak they are not. MOST_LEFT_OUT of all at most.
    """
    trusted = np.ones(len(omega), dtype=bool)
    if len(omega) < FEWEST:
        return trusted
    most = MOST_LEFT_OUT * len(omega)
    while (~trusted).sum() < most:
        run = _off_the_line(omega, responses, known, np.flatnonzero(trusted))
        if not len(run) or (~trusted).sum() + len(run) > np.ceil(most):
            break
        trusted[run] = False
    return trusted


def scatter(omega: np.ndarray, response: np.ndarray) -> float:
    """Root mean square distance of a `response` from the cubics through its neighbours.

    `omega` (n,) [rad/s], `response` (n,) in any unit, which is that of the distance. Neighbours are
    two on either side; of fewer than 5 values there is none.
    """
    places = np.arange(len(omega))
    known = np.ones((1, len(omega)), dtype=bool)
    far = _distances(omega, response[None, :], known, places=places, others=places)
    return float(np.sqrt(np.mean(far[2:-2] ** 2))) if len(omega) > 4 else 0.0


def _off_the_line(
    omega: np.ndarray, responses: Complex, known: np.ndarray, among: np.ndarray
) -> np.ndarray:
    """The worst run of frequencies (indices) that stands out `among` (indices), if any."""

    def distances(places: np.ndarray, others: np.ndarray) -> np.ndarray:
        return _distances(omega, responses, known, places=places, others=others)

    all_distances = distances(among, among)
    enough = OUTLIER * max(float(np.median(all_distances[2:-2])), SMOOTH)
    for k in np.argsort(-all_distances):
        if all_distances[k] <= enough:
            break
        for length in range(1, RUN + 1):
            for first in range(max(2, k - length + 1), min(k, len(among) - 2 - length) + 1):
                run = among[first : first + length]
                around = among[[first - 2, first - 1, first + length, first + length + 1]]
                rest = np.setdiff1d(among, run)
                least = distances(run, rest).min()
                if least > max(enough, STANDS_OUT * distances(around, rest).max()):
                    return run
    return among[:0]


def _distances(
    omega: np.ndarray,
    responses: Complex,
    known: np.ndarray,
    *,
    places: np.ndarray,
    others: np.ndarray,
) -> np.ndarray:
    """Largest distance of the responses at `places` from the cubic through two of `others` on
    either side; 0 where there are none.
    """
    found = np.zeros(len(places))
    for n, place in enumerate(places):
        at = np.searchsorted(others, place)
        right = at + (at < len(others) and others[at] == place)
        if at < 2 or right + 2 > len(others):
            continue
        points = others[[at - 2, at - 1, right, right + 1]]
        x, y = omega[points], responses[:, points]
        terms = [
            np.prod([(omega[place] - b) / (a - b) for b in x if b != a]) * y[:, j]
            for j, a in enumerate(x)
        ]
        found[n] = (np.abs(sum(terms) - responses[:, place]) * known[:, place]).max(initial=0.0)
    return found


def _frequencies(omega: np.ndarray) -> str:
    return f"{first_of((f'{w:.4g}' for w in omega), SHOWN)} rad/s"
