"""Group `solution`: shorter steps lead to the same solution, which is that of model exchange."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence

import fmpy
import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.importer.elements import array_name
from m4e_fmi.fmu.validation.checks.samples import SAFETY, follows, paced
from m4e_fmi.fmu.validation.findings import Finding, about, some
from m4e_fmi.fmu.validation.probe import TOLERANCE, Context, RefusedError

STEPS = 8
RATE_STEPS = 4 * STEPS
"""Over which states are compared with their rates."""
LARGE = 0.1
"""Part of the range of an output above which not converging is an error."""
NEGLIGIBLE = 1e-3
"""Part of the range of an output below which nobody minds."""
SMALL = 100 * TOLERANCE
"""Part of the size of an output that errors of the FMU's own solver may add up to, in STEPS."""
ROUNDING = 1e-9
"""Least size of an output over the largest of its unit: what is always 0 has rounding errors."""
REFERENCE = 1e-10
"""Relative tolerance of the solver of model exchange."""

VARIABLE = "canHandleVariableCommunicationStepSize is declared: FMI 2.0.4, section 4.3.1"


def check(context: Context) -> Iterator[Finding | str]:
    """Solutions that contradict one another."""
    subject = context.subject
    if not subject.steps or not subject.outputs:
        yield "there is no output of co-simulation"
        return
    context = paced(context)
    inputs = context.random_inputs()[0]

    def stepped(sizes: np.ndarray) -> np.ndarray:
        """Outputs at the start and after each step; sizes in steps of the context."""
        return context.course(subject.outputs, sizes * context.step_size, inputs=inputs)

    whole = stepped(np.ones(STEPS))
    error = SMALL * _sizes(context, whole)
    if subject.variable_steps:
        half = stepped(np.full(2 * STEPS, 0.5))[::2]
        quarter = stepped(np.full(4 * STEPS, 0.25))[::4]
        yield from _convergence(context, whole, half, quarter)
        equal = np.array([whole, half, quarter])
        yield from _odd_steps(context, stepped, equal)
        error = error + SAFETY * np.max(np.abs(half - whole), axis=0)
    if subject.exchanges:
        yield from _exchange(context, inputs, whole, error)


def _named(context: Context, chosen: np.ndarray) -> list[str]:
    """The outputs that are `chosen` (n_outputs,), booleans."""
    return [context.subject.outputs[k].name for k in np.flatnonzero(chosen)]


def _sizes(context: Context, values: np.ndarray) -> np.ndarray:
    """The largest of `values` (rows, outputs) of each output, at least `ROUNDING` of its unit's."""
    found = np.max(np.abs(values), axis=0)
    units = np.array([v.unit or "" for v in context.subject.outputs], dtype=str)
    for unit in set(units):
        same = units == unit
        found[same] = np.maximum(found[same], ROUNDING * found[same].max())
    return found


def _convergence(
    context: Context, whole: np.ndarray, half: np.ndarray, quarter: np.ndarray
) -> Iterator[Finding]:
    """The first difference of a sequence that converges, even slowly, is above the second."""
    first, second = (np.max(np.abs(d), axis=0) for d in (half - whole, quarter - half))
    size = _sizes(context, quarter)
    spread = np.ptp(np.vstack([whole, half, quarter]), axis=0)
    noise = SMALL * size
    diverges = (second > 0.75 * first) & (second > np.maximum(noise, NEGLIGIBLE * spread))
    if diverges.any():
        part = float(np.max((second / np.where(spread, spread, 1))[diverges]))
        message = f"with steps halved twice, results differ by {part:.2g} of their range, and do"
        message += " not converge"
        basis = "does doStep advance by communicationStepSize? FMI 2.0.4, section 4.2.2"
        severity = "error" if part > LARGE else "warning"
        names = _named(context, diverges)
        yield from about(names, "solution.step_size", severity, message, basis)


def _odd_steps(
    context: Context, stepped: Callable[[np.ndarray], np.ndarray], equal: np.ndarray
) -> Iterator[Finding]:
    """The same time in steps of unequal size: within what `equal` ones of three sizes differ by.

    At any time: at the end their errors may happen to cancel.
    """
    sizes = context.rng.uniform(0.1, 1.9, STEPS)
    sizes *= STEPS / sizes.sum()
    try:
        odd = stepped(sizes)[-1]
    except RefusedError as error:
        message = f"with steps of unequal size: {error}"
        yield Finding("solution.odd_steps", "error", message, VARIABLE, error.words)
        return
    error = np.max(np.ptp(equal, axis=0), axis=0)
    allowed = SMALL * _sizes(context, equal.reshape(-1, equal.shape[-1])) + SAFETY * error
    allowed += NEGLIGIBLE * np.ptp(equal, axis=(0, 1))
    wrong = np.abs(odd - equal[0, -1]) > allowed
    names = _named(context, wrong)
    message = "steps of unequal size lead to other results than equal ones"
    yield from about(names, "solution.odd_steps", "warning", message, VARIABLE)


def _exchange(
    context: Context, inputs: np.ndarray, stepped: np.ndarray, error: np.ndarray
) -> Iterator[Finding]:
    """Model exchange with CVODE, at two tolerances for the reference's own error."""
    reference, rough = (_integrated(context, inputs, t) for t in (REFERENCE, 100 * REFERENCE))
    if reference is None or rough is None:
        message = "FMPy and CVODE could not integrate its model exchange"
        yield Finding("solution.exchange_failed", "warning", message, "`fmpy simulate` tells why")
        return
    error = error + SAFETY * np.max(np.abs(reference - rough), axis=0)
    difference = np.max(np.abs(reference - stepped), axis=0)
    wrong = difference > error
    if wrong.any():
        worst = int(np.argmax(difference / np.where(error, error, 1)))
        name = context.subject.outputs[worst].name
        names = some(_named(context, wrong))
        message = f"co-simulation and model exchange differ: {names}; {name} by"
        message += f" {difference[worst]:.3g}, its error is about {error[worst] / SAFETY:.3g}"
        severity, basis = "error", "both are of one model"
        if _follows(context, inputs):
            severity, basis = "warning", "the solver inside is coarse: use shorter steps there"
        yield Finding("solution.exchange", severity, message, basis)


def _follows(context: Context, inputs: np.ndarray) -> bool:
    """True if states of co-simulation change as the rates of model exchange at them allow."""
    subject = context.subject
    sizes = np.full(RATE_STEPS - 1, context.step_size)
    states = context.course(subject.states, sizes, inputs=inputs)
    times = np.cumsum([subject.start_time, *sizes])
    rates = []
    try:
        with context.probe(exchange=True) as probe:
            probe.begin(initial_inputs=inputs)
            for time, x in zip(times, states, strict=True):
                probe.fmu.do("SetTime", ctypes.c_double(time), note=f"t={time:.9g}")
                probe.set_states(x)
                rates.append(probe.rates())
    except RefusedError:
        return False
    return bool(follows(states, np.array(rates), context.step_size).all())


def _integrated(context: Context, inputs: np.ndarray, tolerance: float) -> np.ndarray | None:
    subject = context.subject
    values: dict[str, object] = {v.name: u for v, u in zip(subject.inputs, inputs, strict=True)}
    outputs = [v.name for v in subject.outputs]
    if subject.fmi_3:
        values = _whole_arrays(subject.inputs, inputs)
        outputs = list(_whole_arrays(subject.outputs, np.zeros(len(outputs))))
    context.journal("fmpy.simulate_fmu(fmi_type='ModelExchange')")
    try:
        result = fmpy.simulate_fmu(
            str(subject.folder),
            validate=False,
            fmi_type="ModelExchange",
            solver="CVode",
            start_time=subject.start_time,
            stop_time=subject.start_time + STEPS * context.step_size,
            output_interval=context.step_size,
            relative_tolerance=tolerance,
            start_values=values,
            output=outputs,
            record_events=False,
        )
    except Exception:  # noqa: BLE001  FMPy raises plain exceptions
        return None
    found = np.hstack([np.reshape(result[name], (len(result), -1)) for name in outputs])
    return found if found.shape == (STEPS + 1, len(subject.outputs)) else None


def _whole_arrays(elements: Sequence[ModelVariable], values: np.ndarray) -> dict[str, object]:
    """Name → value, of arrays a list: FMPy knows arrays only as a whole."""
    found: dict[str, list[float]] = {}
    for v, value in zip(elements, values.tolist(), strict=True):
        found.setdefault(array_name(v), []).append(value)
    shapes = {array_name(v): v.shape for v in elements}
    return {name: several if shapes[name] else several[0] for name, several in found.items()}
