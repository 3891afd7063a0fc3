"""Calls that move values in other units than the FMU's own: it has factor·v + offset for v."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from m4e_fmi.fmu.importer.calls.functions import Status
from m4e_fmi.fmu.importer.calls.standard import Call

Bind = Callable[[np.ndarray], Call]
"""Makes a call that moves an array (n,), in the FMU's own units."""


def scaled_getter(own: Bind, view: np.ndarray, factor: np.ndarray, offset: np.ndarray) -> Call:
    """A call that reads into `view`.

    `own`, `view`, `factor` and `offset` (n,): view = (v - offset)/factor, v in the FMU's units.
    """
    values = np.zeros(len(view))
    call = own(values)

    def get() -> Status:
        status = call()
        view[:] = (values - offset) / factor
        return status

    return get


def scaled_setter(own: Bind, view: np.ndarray, factor: np.ndarray, offset: np.ndarray) -> Call:
    """A call that sets from `view`.

    `own`, `view`, `factor` and `offset` (n,): v = factor·view + offset, in the FMU's units, is set.
    """
    values = np.zeros(len(view))
    call = own(values)

    def set_() -> Status:
        np.multiply(view, factor, out=values)
        np.add(values, offset, out=values)
        return call()

    return set_
