"""FMUs of FMI 3.0, simulated by FMPy in each way they are for; as importers do."""

from __future__ import annotations

from collections.abc import Iterator

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException

from m4e_fmi.fmu.validation.context import Context
from m4e_fmi.fmu.validation.findings import Failure, Finding, some
from m4e_fmi.fmu.validation.probe import TOLERANCE

STEPS = 20
WAYS = {"coSimulation": "CoSimulation", "modelExchange": "ModelExchange"}


def check_simulated(context: Context) -> Iterator[Finding | Failure]:
    """Every way twice: no failure, finite values, the same bits."""
    raw = context.subject.raw
    for way in (text for key, text in WAYS.items() if getattr(raw, key) is not None):
        context.library.journal.write(f"fmpy.simulate_fmu(fmi_type={way!r})")
        try:
            first, second = (_simulated(context, way) for _ in range(2))
        except Exception as error:  # noqa: BLE001  FMPy raises plain exceptions
            if not (isinstance(error, FMICallException | OSError) or type(error) is Exception):
                yield Failure.of(error)  # FMPy's own
                continue
            message = f"{way} cannot be simulated with its own start values: {error}"
            yield Finding("start.refused", "error", message, "`fmpy simulate` tells more")
            continue
        if first.tobytes() != second.tobytes():
            message = f"{way}: a second run gives other bits"
            yield Finding("start.not_repeatable", "warning", message, "is there a global state?")
        reals = [n for n in first.dtype.names or () if first.dtype[n].base.kind == "f"]
        names = [name for name in reals if not np.isfinite(first[name]).all()]
        if names:
            message = f"{way}, with its own start values, not finite: {some(names)}"
            yield Finding("start.not_finite", "error", message, "check its start values")


def _simulated(context: Context, way: str) -> np.ndarray:
    subject = context.subject
    return fmpy.simulate_fmu(
        str(subject.folder),
        validate=False,
        fmi_type=way,
        start_time=subject.start_time,
        stop_time=subject.start_time + STEPS * subject.step_size,
        output_interval=subject.step_size,
        relative_tolerance=TOLERANCE,
        record_events=False,
    )
