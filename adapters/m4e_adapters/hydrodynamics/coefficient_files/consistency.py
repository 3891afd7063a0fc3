"""Relations that coefficients of potential flow obey, as far as their data allow to check them.

Symmetry and energy are checked where a memory is fitted (`memory.soundness`).

- Causality (Kramers and Kronig): A(ω) − A∞ follows from B: `ogilvie`.
- Haskind, energy of radiated waves: B = k/(8πρg c_g) ∮ Re X X* dβ, c_g the group velocity
  (J. N. Newman, "Marine Hydrodynamics", 1977, chapter 6), where the directions go all around.
- Long waves: the heave excitation is the hydrostatic stiffness, and that in surge the inertia of
  the displaced water and the added mass in the acceleration of the wave, 90 deg before the crest.

Added mass at infinite frequency from A(ω) and B(ω), by Ogilvie's relation.

    A∞ = A(ω) + (2/π) PV ∫₀^∞ B(u)/(ω² − u²) du

(T. F. Ogilvie, "Recent progress toward the understanding and prediction of ship motions", 5th
Symposium on Naval Hydrodynamics, 1964.) B is taken as linear between its frequencies, from 0 at
ω = 0, and as falling by ω⁻³ beyond them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber

USED = (0.1, 0.7)
"""Share of the highest frequency between which A∞ is looked for: below, A varies fast, above, the
unknown tail counts."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def ogilvie(
    omega: np.ndarray, added_mass: np.ndarray, damping: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Median A∞ over the frequencies in USED, (n, n) or (n,) [kg], and its spread, likewise.

    The spread is half of that of the middle 80 %. `omega` (nω,) [rad/s], `added_mass` and `damping`
    (nω, n, n) or (nω, n) [kg] and [kg/s], or any other unit of inertia.
    """
    low, high = (share * omega[-1] for share in USED)
    chosen = np.flatnonzero((omega >= low) & (omega <= high))
    if not len(chosen):
        chosen = np.arange(len(omega))
    found = np.array([added_mass[k] + _integral(omega, damping, k) for k in chosen.tolist()])
    below, middle, above = np.quantile(found, [0.1, 0.5, 0.9], axis=0)
    return middle, 0.5 * (above - below)


def _integral(omega: np.ndarray, damping: np.ndarray, k: int) -> np.ndarray:
    """(2/π) PV ∫ B(u)/(ω² − u²) du at the frequency `k`.

    The logarithm's pole at u = ω is that of both neighbours, with opposite signs: it is left out.
    """
    w = omega[k]
    knots = np.concatenate([[0.0], omega])
    values = np.concatenate([np.zeros((1, *damping.shape[1:])), damping])
    weights = np.zeros(len(knots))
    gap = np.abs(w - knots)
    near = np.log(np.where(gap > 1e-12 * w, gap, 1.0))
    far = np.log(w + knots)
    for j in range(len(knots) - 1):
        step = knots[j + 1] - knots[j]
        logs = near[j + 1] - near[j], far[j + 1] - far[j]
        constant = (logs[1] - logs[0]) / (2 * w)  # ∫ du/(ω² − u²)
        linear = -(logs[0] + logs[1]) / 2  # ∫ u du/(ω² − u²)
        weights[j] += (knots[j + 1] * constant - linear) / step
        weights[j + 1] += (linear - knots[j] * constant) / step
    end = omega[-1]
    s = 0.5 * (_NODES + 1.0)
    if k < len(omega) - 1:
        weights[-1] += end * float(0.5 * _WEIGHTS @ (s**3 / (w**2 * s**2 - end**2)))
    return (2.0 / np.pi) * np.tensordot(weights, values, axes=1)


NOT_CAUSAL = 0.05  # of A∞
OFF_HASKIND = 0.05  # of the motions' largest B
LONG = 0.1  # wavenumber times size below which a wave is long
OFF_LONG = 0.5  # relative error of forces in long waves
TRIFLE = 1e-3  # of the largest of its kind (translations, rotations), below which a value is noise


@dataclass(frozen=True)
class Relation:
    """A relation: `name`, what was found in one line, and True if it deserves a warning."""

    name: str
    text: str
    warns: bool = False


def findings(c: Coefficients, *, added_mass_inf_of_file: bool = True) -> list[Relation]:
    """All relations that can be checked.

    `added_mass_inf_of_file` is False where A∞ itself comes from causality.
    """
    return [_causality(c, added_mass_inf_of_file), *_haskind(c), *_long_waves(c)]


def _causality(c: Coefficients, of_file: bool) -> Relation:
    """A∞ against Ogilvie's relation, of each motion with a noteworthy A∞."""
    own = c.added_mass_inf.diagonal()
    masses, damping = (
        values.diagonal(axis1=1, axis2=2) for values in (c.added_mass, c.radiation_damping)
    )
    middle, spread = ogilvie(c.omega, masses, damping)
    relevant = np.abs(own) > TRIFLE * _largest_of_kind(c, np.abs(own))
    if not relevant.any():
        return Relation("causality", "no motion has added mass")
    size = np.where(relevant, np.abs(own), 1.0)
    error = np.where(relevant, np.abs(middle - own), 0.0) / size
    if not of_file:
        spreads = np.where(relevant, spread, 0.0) / size
        k = int(spreads.argmax())
        text = f"A∞ from A(ω) and B(ω) scatters by up to {100 * spreads[k]:.2g} % ({c.motions[k]})"
        return Relation("causality", text, bool(spreads[k] > NOT_CAUSAL))
    k = int(error.argmax())
    text = (
        f"A∞ differs by up to {100 * error[k]:.2g} % from what A(ω) and B(ω) say ({c.motions[k]}: "
        f"{own[k]:.5g} given, {middle[k]:.5g} ± {spread[k]:.2g} by Ogilvie's relation)"
    )
    return Relation("causality", text, bool(error[k] > NOT_CAUSAL + spread[k] / size[k]))


def _haskind(c: Coefficients) -> Iterator[Relation]:
    if not c.has_harmonics:
        return
    k = wavenumber(c.omega, depth=c.depth, gravity=c.gravity)
    kh = np.minimum(k * c.depth, 300.0) if math.isfinite(c.depth) else np.full_like(k, 300.0)
    group = c.omega / k * (0.5 + kh / np.sinh(2 * kh))
    around = 2 * np.pi * (np.abs(c.harmonics) ** 2).sum(axis=1)  # ∮ |X|² dβ
    theory = (k / (8 * np.pi * c.density * c.gravity * group))[:, None] * around
    own = c.radiation_damping.diagonal(axis1=1, axis2=2)
    largest = np.abs(own).max(axis=0)
    relevant = largest > TRIFLE * _largest_of_kind(c, largest)
    error = np.abs(own - theory) / np.where(relevant, largest, np.inf)
    at, motion = np.unravel_index(int(error.argmax()), error.shape)
    text = (
        f"B and the excitation differ by up to {100 * error.max():.2g} % of the largest B "
        f"({c.motions[motion]} at {c.omega[at]:.3g} rad/s)"
    )
    yield Relation("Haskind", text, bool(error.max() > OFF_HASKIND))


def _largest_of_kind(c: Coefficients, values: np.ndarray) -> np.ndarray:
    """Of each motion (n,) the largest of the `values` (n,) of all translations, or rotations."""
    kinds = np.array([m.is_rotation for m in c.body_motions * len(c.bodies)])
    return np.array([values[kinds == kind].max() for kind in kinds])


def _long_waves(c: Coefficients) -> Iterator[Relation]:
    """Forces of the longest wave in heave, and in the direction of the wave."""
    k = float(wavenumber(c.omega[:1], depth=c.depth, gravity=c.gravity)[0])
    volumes = c.buoyancy[c.heave :: c.per_body] / (c.density * c.gravity)
    if k * float(np.cbrt(max(volumes.max(), 0.0))) > LONG:
        return
    direction = float(c.directions[0]) if len(c.directions) else c.wave_direction
    table = c.by_direction[0, 0] if len(c.directions) else c.excitation[0]
    if not len(c.directions) and c.has_harmonics:
        turns = np.arange(c.harmonics.shape[1]) - c.harmonics.shape[1] // 2
        relative = np.exp(1j * math.radians(direction) * turns) @ c.harmonics[0]
    else:
        relative = table * c.way(c.omega[:1], direction)[0].conj()
    for number, body in enumerate(c.bodies):
        own = relative[c.own(number)]
        place = c.own(number).start + c.heave
        stiffness = float(c.hydrostatic_stiffness[place, place])
        heave = float(own[c.heave].real)
        least = 0.1 * c.density * c.gravity * float(np.cbrt(volumes[number])) ** 2
        if stiffness > least:
            off = abs(heave / stiffness - 1.0)
            text = (
                f"{body}: the heave excitation of the longest wave is {heave:.4g} N/m, the "
                f"hydrostatic stiffness {stiffness:.4g} N/m"
            )
            yield Relation("long waves", text, bool(off > OFF_LONG))
            continue
        inertia = c.density * volumes[number] + abs(float(c.added_mass[0, place, place]))
        submerged = 2.0 * (float(c.omega[0]) ** 2 * inertia + abs(stiffness))
        if abs(heave) > max(0.5 * least, submerged):
            text = (
                f"{body}: the heave excitation of the longest wave is {heave:.4g} N/m, as of a "
                f"body in the surface, the hydrostatic stiffness {stiffness:.4g} N/m"
            )
            yield Relation("long waves", text, True)


def surge_share(c: Coefficients, relative: np.ndarray, direction: float) -> float:
    """Mean sine of the phase of the forces along waves that are long, −1 in these conventions.

    `relative` (nω, n) is the excitation for waves to `direction` [deg] at the bodies' centres. NaN
    if no wave is long, or no force is there.
    """
    k = wavenumber(c.omega, depth=c.depth, gravity=c.gravity)
    volumes = np.abs(c.buoyancy[c.heave :: c.per_body]) / (c.density * c.gravity)
    long = k * np.cbrt(volumes.max()) < 0.5
    if not long.any():
        return math.nan
    cosine, sine = math.cos(math.radians(direction)), math.sin(math.radians(direction))
    along = cosine * relative[long, 0 :: c.per_body]
    if c.dimensions == 3:
        along = along + sine * relative[long, 1 :: c.per_body]
    total = np.abs(along).sum()
    least = 1e-6 * np.abs(relative[long, c.heave :: c.per_body]).sum()
    return float(along.imag.sum() / total) if total > least else math.nan
