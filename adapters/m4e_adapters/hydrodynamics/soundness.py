"""What potential-flow data must be like before a memory is fitted to them.

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
from m4e_adapters.hydrodynamics.vector_fitting import Complex
from m4e_fmi.errors import InputError

NEGATIVE = 0.02  # of B, each motion scaled by its largest: what panels may make
ASYMMETRIC = 0.05  # |X_ij − X_ji|, likewise, that is told
MOST_LEFT_OUT = 0.1  # of all frequencies
OUTLIER = 10.0  # distance from the line, in medians, from which a frequency is left out
SMOOTH = 2e-3  # least median, relative to the largest value of each motion
MEANT = 2.0
SHOWN = 4  # frequencies in a message
REMEDY = (
    "look at the panels there: a finer mesh, a lid against irregular frequencies, a wider gap or a "
    "lid with damping in it, or a lower frequencies.maximum"
)


def scales(values: np.ndarray) -> np.ndarray:
    """Square roots of the largest |diagonal| over frequencies of (nω, n, n); 1 where all are 0."""
    largest = np.sqrt(np.abs(values.diagonal(axis1=-2, axis2=-1)).reshape(-1, values.shape[-1]))
    found = largest.max(axis=0)
    return np.where(found > 0, found, 1.0)


def symmetric(coefficients: Coefficients, progress: Callable[[str], object]) -> Coefficients:
    """The data made symmetric; how much they were not is told."""
    made, told = {}, []
    for name in ("added_mass", "radiation_damping", "added_mass_inf"):
        values = getattr(coefficients, name)
        other = values.swapaxes(-1, -2)
        made[name] = 0.5 * (values + other)
        size = scales(values)
        error = np.abs(values - other) / np.outer(size, size)
        error = error.reshape(-1, *error.shape[-2:]).max(axis=0)
        if error.max() > ASYMMETRIC:
            i, j = np.unravel_index(int(error.argmax()), error.shape)
            first, second = coefficients.motions[i], coefficients.motions[j]
            told.append(f"{name} of {first} and {second} by {100 * error.max():.2g} %")
    if told:
        progress(
            "warning: the coefficients are not symmetric, as reciprocity wants them: "
            f"{', '.join(told)} of the motions' own; the mean of both halves is used"
        )
    return replace(coefficients, **made)


def meaningful(coefficients: Coefficients) -> np.ndarray:
    """Which pairs of motions (n, n) of data as computed are more than noise.

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
    """Which of the `used` frequencies (nω,) of data as computed have no negative damping.

    Negative is an eigenvalue of the damping matrix below −NEGATIVE, and by more than its two halves
    differ. InputError if many frequencies have one; those that are left out are told.
    """
    damping = coefficients.radiation_damping
    size = scales(damping[used])
    scaled = damping / np.outer(size, size)
    other = scaled.swapaxes(1, 2)
    values, vectors = np.linalg.eigh(0.5 * (scaled + other))
    doubt = np.linalg.norm(0.5 * (scaled - other), ord=2, axis=(1, 2))
    bad = used & (values[:, 0] < -np.maximum(NEGATIVE, doubt))
    if not bad.any():
        return used
    k = int(np.argmin(np.where(bad, values[:, 0], 0.0)))
    share = np.abs(vectors[k, :, 0])
    motions = [coefficients.motions[i] for i in np.flatnonzero(share > 0.3 * share.max())]
    text = (
        f"the radiation damping of {', '.join(motions)} is negative at "
        f"{_frequencies(coefficients.omega[bad])} (by {-100 * values[k, 0]:.2g} % of its largest "
        f"value at {coefficients.omega[k]:.4g} rad/s): waves would bring energy"
    )
    if bad.sum() > MOST_LEFT_OUT * used.sum():
        raise InputError.single(text, REMEDY)
    progress(f"warning: {text}; left out: {REMEDY}")
    return used & ~bad


def on_the_line(omega: np.ndarray, responses: Complex) -> np.ndarray:
    """Which frequencies (n,) agree with the cubic through two neighbours on either side.

    The worst one is taken out and the rest compared again, MOST_LEFT_OUT of all at most.
    """
    trusted = np.ones(len(omega), dtype=bool)
    while trusted.sum() > (1 - MOST_LEFT_OUT) * len(omega):
        x, y = omega[trusted], responses[:, trusted]
        at = x[2:-2]
        points = [x[:-4], x[1:-3], x[3:-1], x[4:]]
        expected = np.zeros_like(y[:, 2:-2])
        for k, (point, shift) in enumerate(zip(points, (0, 1, 3, 4), strict=True)):
            others = [p for j, p in enumerate(points) if j != k]
            factor = np.prod([(at - p) / (point - p) for p in others], axis=0)
            expected += factor * y[:, shift : shift + len(at)]
        distance = np.abs(expected - y[:, 2:-2]).max(axis=0)
        worst = int(np.argmax(distance))
        if distance[worst] <= OUTLIER * max(float(np.median(distance)), SMOOTH):
            break
        trusted[np.flatnonzero(trusted)[worst + 2]] = False
    return trusted


def _frequencies(omega: np.ndarray) -> str:
    shown = ", ".join(f"{w:.4g}" for w in omega[:SHOWN])
    more = f" and {len(omega) - SHOWN} more" if len(omega) > SHOWN else ""
    return f"{shown}{more} rad/s"
