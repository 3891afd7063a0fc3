"""The error of a run whose FMU discards steps of all lengths."""

from __future__ import annotations

from m4e_fmi.cosim.exchange.instance import DiscardedError, EventWithinError
from m4e_fmi.cosim.stepping.step_control import SMALLEST
from m4e_fmi.cosim.time_loop.time_loop import MOST_DISCARDED, TimeLoop
from m4e_fmi.errors import RunError


def at_every_length(error: RunError, time_loop: TimeLoop, step_size: float) -> RunError:
    """`error`, or the error of an FMU that discards steps of all lengths up to `step_size` [s]."""
    if not isinstance(error, DiscardedError) or isinstance(error, EventWithinError):
        return error
    sizes = f"{step_size:g} s down to {error.size:.3g} s"
    if error.size <= 2 * SMALLEST * step_size:
        tried = f"every step from there, of {sizes}"
    elif time_loop.discarded >= MOST_DISCARDED:
        tried = f"{time_loop.discarded} steps since t = {time_loop.since:.9g} s, of {sizes}"
    else:
        return error
    first = "fix the problem stated by the FMU first"
    return RunError(
        f"{error.message}; {error.component} has discarded {tried}",
        f"{first}; "
        * error.remedy.startswith(first)
        + f"no step_size helps: check what {error.component} cannot compute there, and at "
        "its inputs in the results",
    )
