"""Functions of the time in Chrono's files, as expressions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from m4e_fmi.model.chrono.sections import FunctionSection
from m4e_fmi.model.elements import Quantity

NEEDED = {
    "CONSTANT": "value",
    "POLYNOMIAL": "coefficients",
    "POLY": "coefficients",
    "SINE": "amplitude",
    "RAMP": "slope",
    "DATA": "data",
}
"""The key that a function of a type must have."""


def function_text(function: FunctionSection, *, degrees: bool) -> Quantity | None:
    """An expression in t; None for a function of type CONTROLLER."""
    match function.type:
        case "CONSTANT":
            return function.value
        case "POLYNOMIAL" | "POLY":
            powers = ["", "*t", *(f"*t**{k}" for k in range(2, len(function.coefficients or [])))]
            pairs = zip(function.coefficients or [], powers, strict=False)
            terms = [f"{c!r}{power}" for c, power in pairs if c and power]
            constant = (function.coefficients or [0.0])[0]
            return " + ".join([repr(constant), *terms]) if terms else constant
        case "SINE":
            phase = math.radians(function.phase) if degrees else function.phase
            angle = f"{2 * math.pi * (function.frequency or 0.0)!r}*t"
            angle += f" + {phase!r}" if phase else ""
            return f"{function.amplitude or 0.0!r}*sin({angle})"
        case "RAMP":
            return f"{function.intercept!r} + {function.slope!r}*t"
        case "DATA" | "CONTROLLER":
            return None


def times(factor: float, quantity: Quantity) -> Quantity:
    """factor · quantity, as a number where it is one."""
    if isinstance(quantity, int | float):
        return factor * quantity
    if factor == 1 or factor == 0:
        return quantity if factor else 0.0
    return f"{factor!r}*({quantity})"


def scaled(vector: Sequence[float], quantity: Quantity) -> tuple[Quantity, ...]:
    """quantity · vector."""
    return tuple(times(part, quantity) for part in vector)
