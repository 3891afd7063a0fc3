"""FMUs of FMI 3.0, simulated by FMPy in each way they are for; as importers do."""

from __future__ import annotations

from collections.abc import Iterator

import fmpy
import numpy as np

from m4e_fmi.fmu.validation.bench import Bench
from m4e_fmi.fmu.validation.differences import SAFETY
from m4e_fmi.fmu.validation.findings import Finding, some
from m4e_fmi.fmu.validation.probe import TOLERANCE

STEPS = 20
WAYS = {"coSimulation": "CoSimulation", "modelExchange": "ModelExchange"}


def check_simulated(bench: Bench) -> Iterator[Finding]:
    """Every way twice: no failure, finite values, the same bits; then one way against the other."""
    raw = bench.subject.raw
    seen: dict[str, np.ndarray] = {}
    for way in (text for key, text in WAYS.items() if getattr(raw, key) is not None):
        bench.library.journal.write(f"fmpy.simulate_fmu(fmi_type={way!r})")
        try:
            first, second = (_simulated(bench, way) for _ in range(2))
        except Exception as error:  # noqa: BLE001  FMPy raises plain exceptions
            message = f"{way} cannot be simulated with its own start values: {error}"
            yield Finding("start.refused", "error", message, "`fmpy simulate` tells more")
            continue
        if first.tobytes() != second.tobytes():
            message = f"{way}: a second run gives other bits"
            yield Finding("start.not_repeatable", "warning", message, "is there a global state?")
        names = [name for name in first.dtype.names or () if not np.isfinite(first[name]).all()]
        if names:
            message = f"{way}, with its own start values, not finite: {some(names)}"
            yield Finding("start.not_finite", "error", message, "check its start values")
        seen[way] = first
    if len(seen) == len(WAYS):
        yield from _compare(bench, *seen.values())


def _compare(bench: Bench, stepped: np.ndarray, integrated: np.ndarray) -> Iterator[Finding]:
    rough = _simulated(bench, WAYS["modelExchange"], tolerance=100 * TOLERANCE)
    wrong = []
    for name in (n for n in stepped.dtype.names or () if n != "time"):
        if len(stepped) != len(integrated) or len(rough) != len(integrated):
            return  # events made further rows
        size = np.max(np.abs(integrated[name]))
        error = np.max(np.abs(rough[name] - integrated[name])) + 100 * TOLERANCE * size
        if np.max(np.abs(stepped[name] - integrated[name])) > SAFETY * error:
            wrong.append(name)
    if wrong:
        message = f"co-simulation and model exchange differ: {some(wrong)}"
        yield Finding("solution.exchange", "error", message, "both are of one model")


def _simulated(bench: Bench, way: str, tolerance: float = TOLERANCE) -> np.ndarray:
    subject = bench.subject
    return fmpy.simulate_fmu(
        str(subject.folder),
        validate=False,
        fmi_type=way,
        start_time=subject.start_time,
        stop_time=subject.start_time + STEPS * subject.step_size,
        output_interval=subject.step_size,
        relative_tolerance=tolerance,
        record_events=False,
    )
