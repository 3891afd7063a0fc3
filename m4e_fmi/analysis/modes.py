"""Eigenvalues of linear equations: natural frequencies, damping ratios, mode shapes."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.analysis.linearization import Linearization
from m4e_fmi.analysis.points import place
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.program import Variable
from m4e_fmi.shown import listing, table

Complex = NDArray[np.complex128]

NEGLIGIBLE = 1e-7
"""Eigenvalues below this part of the largest are zero: double ones, of a body that nothing holds,
are found to the square root of the rounding error only."""
SAME = 1e-9
"""Relative difference below which eigenvalues, or parts of a shape, count as equal when sorted."""


@dataclass(frozen=True)
class Modes:
    """Solutions v e^{λt} of δẋ = A δx, one of each conjugate pair (that with Im λ > 0).

    In the order of |λ|; equal ones by their damping, then by where they move most. Column k of
    `right` is v, with rows as `states`; of `left` the left eigenvector w, wᴴ v = 1.
    """

    states: tuple[Variable, ...]
    coordinates: tuple[Variable, ...]
    eigenvalues: Complex
    right: Complex = field(repr=False)
    left: Complex = field(repr=False)

    @cached_property
    def frequencies(self) -> NDArray[np.float64]:
        """Natural frequencies |λ| [rad/s], shape (modes,)."""
        return np.abs(self.eigenvalues)

    @cached_property
    def damping_ratios(self) -> NDArray[np.float64]:
        """−Re λ/|λ|, shape (modes,): 0 undamped, 1 or −1 without oscillation; nan for λ = 0."""
        with np.errstate(invalid="ignore"):
            return -self.eigenvalues.real / self.frequencies

    @cached_property
    def shapes(self) -> Complex:
        """Mode shapes (n_coordinates, n_modes), in the coordinates' units.

        They are rows of v, scaled so that the largest entry (the first of equal ones) is 1.
        """
        rows = self.right[: len(self.coordinates)]
        return rows / rows[_largest(rows), np.arange(rows.shape[1])]

    @cached_property
    def participation(self) -> NDArray[np.float64]:
        """Part that each state has in each mode [1], shape (states, modes); columns add up to 1.

        |w̄ᵢ vᵢ| over its sum, which does not depend on units: I. J. Pérez-Arriaga, G. C. Verghese,
        F. C. Schweppe, "Selective modal analysis with applications to electric power systems",
        IEEE Trans. Power Apparatus and Systems 101 (1982), pp. 3117–3125.
        """
        parts = np.abs(self.left.conj() * self.right)
        return parts / np.maximum(parts.sum(axis=0), np.finfo(float).tiny)

    @property
    def stable(self) -> bool:
        """True if no motion grows; eigenvalues within rounding of the imaginary axis do not."""
        largest = np.max(self.frequencies, initial=0.0)
        return bool((self.eigenvalues.real <= NEGLIGIBLE * largest).all())

    def __repr__(self) -> str:
        title = f"Modes: {'no motion grows' if self.stable else 'a motion grows'}"
        moved = [self.states[k].name for k in self.participation.argmax(axis=0)]
        found = zip(self.frequencies, self.damping_ratios, moved, strict=True)
        rows = [
            (str(k), f"{omega:.6g}", f"{omega / (2 * np.pi):.6g}", f"{ratio:.5g}", name)
            for k, (omega, ratio, name) in enumerate(found, 1)
        ]
        head = ("mode", "[rad/s]", "[Hz]", "damping ratio [1]", "mostly")
        return table(title, ">>>><", head, *rows)


def modes(linear: Linearization) -> Modes:
    """The modes of the linear equations; InputError for anything else."""
    if not isinstance(linear, Linearization):
        message = f"expected a Linearization, got {type(linear).__name__}"
        raise InputError.single(message, "give modes(linearize(model))")
    from scipy.linalg import eig

    found = eig(linear.A, left=True, right=True)
    values, left, right = (np.array(part, dtype=np.complex128) for part in found)
    largest = np.max(np.abs(values), initial=0.0)
    values[np.abs(values) <= NEGLIGIBLE * largest] = 0.0
    kept = np.flatnonzero(values.imag >= 0)
    scale = max(largest, np.finfo(float).tiny)
    n = len(linear.coordinates)
    where = _largest(right[:n] if n else right)
    keys = [
        (round(abs(values[k]) / scale / SAME), round(values[k].real / scale / SAME), where[k])
        for k in kept
    ]
    order = kept[sorted(range(len(kept)), key=keys.__getitem__)]
    right, left = right[:, order], left[:, order]
    products = np.sum(left.conj() * right, axis=0)
    # 0 of a defective eigenvalue: its left eigenvector has no use, and stays as long as it was
    lengths = np.where(np.abs(products) > SAME, products, 1.0)
    return Modes(
        states=linear.states,
        coordinates=linear.coordinates,
        eigenvalues=values[order],
        right=right,
        left=left / lengths.conj(),
    )


def _largest(columns: Complex) -> NDArray[np.intp]:
    """Row of the largest entry of each column; the first of those equal to rounding."""
    sizes = np.abs(columns)
    if not columns.size:
        return np.zeros(columns.shape[1], dtype=np.intp)
    return np.argmax(sizes >= (1 - SAME) * sizes.max(axis=0), axis=0)


@dataclass(frozen=True)
class FrequencyResponse:
    """H(iω): δy = Re[H a e^{+iωt}] for δinput = Re[a e^{+iωt}].

    `omega` [rad/s], shape (n,); `values`, shape (n, outputs, inputs). The sign is control's; waves
    are written with e^{−iωt} here, for which the response is the conjugate.
    """

    omega: NDArray[np.float64]
    values: NDArray[np.complex128] = field(repr=False)
    outputs: tuple[Variable, ...]
    inputs: tuple[Variable, ...]

    def of(self, output: str, input: str) -> NDArray[np.complex128]:
        """The response of one output to one input, shape (n,), in the unit of `unit`."""
        i, j = place(output, self.outputs), place(input, self.inputs)
        return self.values[:, i, j]

    def unit(self, output: str, input: str) -> str:
        """Unit of `of`: that of the output by that of the input."""
        y = self.outputs[place(output, self.outputs)]
        u = self.inputs[place(input, self.inputs)]
        return f"({y.unit})/({u.unit})"

    def __repr__(self) -> str:
        title = f"FrequencyResponse at {len(self.omega)} frequencies"
        if len(self.omega):
            title += f" from {self.omega[0]:g} to {self.omega[-1]:g} rad/s"
        return listing(title, outputs=self.outputs, inputs=self.inputs)


def frequency_response(linear: Linearization, omega: ArrayLike) -> FrequencyResponse:
    """C (iω − A)⁻¹ B + D at angular frequencies `omega` (n,) [rad/s], or at one.

    Raises RunError where `omega` is an undamped natural frequency to the last bit.
    """
    omega = np.atleast_1d(np.asarray(omega, dtype=float))
    shifted = 1j * omega[:, None, None] * np.eye(len(linear.states)) - linear.A
    forced = np.broadcast_to(linear.B, (len(omega), *linear.B.shape))
    try:
        states = np.linalg.solve(shifted, forced)
    except np.linalg.LinAlgError as error:
        name = linear.point.program.name
        message = f"{name}: one of the frequencies is an undamped natural frequency"
        raise RunError(message, "leave it out, or give the system some damping") from error
    return FrequencyResponse(omega, linear.C @ states + linear.D, linear.outputs, linear.inputs)
