"""Radiation memory: the retardation functions K(jω) = B + jω(A − A∞) as a stable state space.

Motions that are coupled (directly or through others) form a group; a group's whole symmetric matrix
is fitted with *one* set of poles. The states are then driven by the velocities, poles × motions of
them, instead of poles × pairs of motions, and the fitted matrix is exactly symmetric. A single
body symmetric fore and aft has the groups {surge, pitch} and {heave}.

The fits are strictly proper (relative degree one), as K is: K → K(t=0)/(jω). That carries them
beyond the table. K(0) = 0 (a steady velocity feels no memory) is fitted as a further value, and the
residues are chosen among those that make the matrix passive at all frequencies. Values above
`Coefficients.memory_limit` are left out: they are small, and what panels spoil first (a B that does
not vanish, an A that does not tend to A∞) breaks the causality that ties B to A. Frequencies at
which the data are off the common line, irregular ones above all, are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.passivity import passive_fit
from m4e_adapters.hydrodynamics.vector_fitting import Complex, evaluate
from m4e_fmi.errors import InputError

ORDERS = (4, 5, 6, 7, 8)
MORE_ORDERS = (10, 12, 16)  # where those leave a POOR fit: bodies that act on others from afar
POOR, USELESS = 0.02, 0.2  # errors of a fit, relative to the largest |K|: warned of, refused
REMEDY = (
    "raise radiation.order; for bodies far apart, whose waves arrive late, also raise "
    "frequencies.count or lower frequencies.maximum"
)
TARGET = 1e-3  # error of the fit, relative to the largest |K|
NEGLIGIBLE = 1e-3  # coupling, relative to the geometric mean of the motions' own |K|
NEAR_BEST = 1.5  # how much larger an error than the best is accepted for fewer states
PASSIVITY = -1e-3  # least eigenvalue of Re K, relative to the largest B
OUTLIER = 10.0  # distance from the line, in medians, from which a frequency is left out
SMOOTH = 2e-3  # least median, relative to the largest |K|


@dataclass(frozen=True)
class RadiationGroup:
    """Fitted retardation functions of some motions.

    Attributes
    ----------
    motions : (m,) indices of the motions.
    poles : (k,) [1/s], one of each conjugate pair (Im ≥ 0), Re < 0.
    residues : (k, m, m) symmetric [force, motion]; K(s) = Σ r/(s − p) (+ conjugates).
    error : largest error over frequencies and pairs, relative to the pair's scale.
    passivity : least eigenvalue of Re K(jω), each motion scaled by its largest |K|.
    doubtful : angular frequencies [rad/s] that were left out as outliers.
    """

    motions: tuple[int, ...]
    poles: Complex
    residues: Complex
    error: float
    passivity: float
    doubtful: tuple[float, ...] = ()

    @property
    def order(self) -> int:
        """Number of poles, pairs counting two."""
        return int(sum(2 if pole.imag > 0 else 1 for pole in self.poles))

    def transfer(self, omega: np.ndarray) -> np.ndarray:
        """K(jω), (n, m, m)."""
        values = evaluate(omega, self.poles, self.residues.transpose(1, 2, 0))
        return values.transpose(2, 0, 1)

    def impulse_response(self, time: np.ndarray) -> np.ndarray:
        """K(t), (n, m, m), for t ≥ 0 [s]: the force after a unit displacement at t = 0."""
        twice = np.where(self.poles.imag > 0, 2.0, 1.0)
        modes = twice * np.exp(np.asarray(time)[:, None] * self.poles)
        return np.einsum("tk,kij->tij", modes, self.residues).real


def _silent(_: str) -> None:
    pass


def fit_radiation(
    coefficients: Coefficients,
    *,
    order: int | None = None,
    progress: Callable[[str], object] = _silent,
) -> tuple[RadiationGroup, ...]:
    """The groups of all motions that radiate; what was reached is told through `progress`.

    `order` None: for each group the smallest of ORDERS (if all are POOR, of MORE_ORDERS too) that
    is accurate to TARGET, or nearly the best if none is, among the passive ones. InputError if
    the best is USELESS.
    """
    used = coefficients.omega <= coefficients.memory_limit
    omega = coefficients.omega[used]
    retardation = coefficients.retardation[used]
    own = np.abs(np.einsum("wii->wi", retardation)).max(axis=0)
    groups = []
    for motions in _coupled(retardation, own):
        part = retardation[np.ix_(range(len(omega)), motions, motions)]
        orders = ORDERS if order is None else (order,)
        fits = [_fit_group(omega, part, motions, k) for k in orders]
        if order is None and min(fit.error for fit in fits) > POOR:
            fits += [_fit_group(omega, part, motions, k) for k in MORE_ORDERS]
        groups.append(_chosen(fits))
        text = _report(groups[-1], coefficients.motions)
        if groups[-1].error > USELESS:
            raise InputError.single(text, REMEDY)
        progress(f"warning: {text}: {REMEDY}" if _is_poor(groups[-1]) else text)
    return tuple(groups)


def _coupled(retardation: np.ndarray, own: np.ndarray) -> list[tuple[int, ...]]:
    """Groups of motions connected by retardation functions that are not negligible."""
    from scipy.sparse.csgraph import connected_components

    radiates = own > 0
    scale = np.sqrt(np.outer(own, own))
    linked = np.abs(retardation).max(axis=0) > NEGLIGIBLE * np.where(scale > 0, scale, np.inf)
    _, labels = connected_components(linked, directed=False)
    groups: dict[int, list[int]] = {}
    for motion in np.flatnonzero(radiates):
        groups.setdefault(int(labels[motion]), []).append(int(motion))
    return [tuple(members) for members in groups.values()]


def _fit_group(
    omega: np.ndarray, retardation: Complex, motions: tuple[int, ...], order: int
) -> RadiationGroup:
    """Fit (n, m, m) with `order` poles to the frequencies that are not off the common line."""
    size = len(motions)
    rows, columns = np.triu_indices(size)
    own = np.sqrt(np.abs(np.einsum("wii->wi", retardation)).max(axis=0))
    scaled = (retardation / np.outer(own, own))[:, rows, columns].T
    scaled = np.where(np.abs(scaled).max(axis=1, keepdims=True) > NEGLIGIBLE, scaled, 0.0)
    trusted = _on_the_line(omega, scaled)
    known, values = omega[trusted], scaled[:, trusted]
    zero = np.zeros((len(rows), 1), dtype=complex)
    # K(0) = 0 weighs as much as all the other values of a response together
    poles, residues = passive_fit(
        np.concatenate([[0.0], known]),
        np.concatenate([zero, values], axis=1),
        weights=np.concatenate([[np.sqrt(len(known))], np.ones(len(known))]),
        order=order,
        grid=omega[-1] * np.concatenate([np.linspace(0, 2, 160), np.geomspace(2, 20, 30)]),
    )
    full = np.zeros((len(poles), size, size), dtype=complex)
    full[:, rows, columns] = residues.T
    full[:, columns, rows] = residues.T
    fine = omega[-1] * np.linspace(0, 5, 2000)
    on_grid = np.real(evaluate(fine, poles, full.transpose(1, 2, 0)).transpose(2, 0, 1))
    return RadiationGroup(
        motions=motions,
        poles=poles,
        residues=full * np.outer(own, own),
        error=float(np.abs(evaluate(known, poles, residues) - values).max()),
        passivity=float(np.linalg.eigvalsh(on_grid).min()),
        doubtful=tuple(float(w) for w in omega[~trusted]),
    )


def _on_the_line(omega: np.ndarray, responses: Complex) -> np.ndarray:
    """Which frequencies (n,) agree with the cubic through two neighbours on either side.

    The worst one is taken out and the rest compared again, a tenth of all at most.
    """
    trusted = np.ones(len(omega), dtype=bool)
    while trusted.sum() > 0.9 * len(omega):
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


def _chosen(fits: list[RadiationGroup]) -> RadiationGroup:
    passive = [fit for fit in fits if fit.passivity >= PASSIVITY] or fits
    enough = max(TARGET, NEAR_BEST * min(fit.error for fit in passive))
    return next(fit for fit in passive if fit.error <= enough)


def _report(group: RadiationGroup, motions: tuple[str, ...]) -> str:
    names = ", ".join(motions[k] for k in group.motions)
    text = f"radiation of {names}: order {group.order}, error {100 * group.error:.2g} %"
    if group.doubtful:
        left_out = ", ".join(f"{w:.3g}" for w in group.doubtful)
        text += f", data off the line at {left_out} rad/s"
    if group.passivity < 2 * PASSIVITY:
        text += f", not passive (least Re K {100 * group.passivity:.2g} %)"
    return text


def _is_poor(group: RadiationGroup) -> bool:
    return group.error > POOR or group.passivity < 2 * PASSIVITY
