"""Frequency response of linear equations."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.analysis.linearization import Linearization
from m4e_fmi.analysis.points import place
from m4e_fmi.errors import RunError
from m4e_fmi.program import Variable
from m4e_fmi.shown import listing


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
