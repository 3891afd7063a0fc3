"""Group `derivatives`: declared derivatives, output and input derivatives, against differences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from fmpy.model_description import ModelVariable

from m4e_fmi.fmu.validation.checks.samples import (
    CENTRE,
    SAFETY,
    SAMPLES,
    Slope,
    at_centre,
    follows,
    paced,
    stands,
)
from m4e_fmi.fmu.validation.findings import Finding, about
from m4e_fmi.fmu.validation.probe import TOLERANCE, Context, RefusedError
from m4e_fmi.fmu.validation.subject import WRITTEN, nominal

WINDOWS = 4
"""Stretches of a simulation, each with its own constant inputs, that are looked at."""
SPACING = 0.25
"""Of the samples, in communication steps."""
CLEAR = 0.01
"""Differences tell something where their error is below this part of the largest value."""
ROUGH = 0.05
"""Part of the largest value within which a derivative is the right one, and the solver inside the
FMU is coarse: another variable's derivative would not be that near in most windows."""
BASIS = "FMI 2.0.4, section 2.2.7, attribute `derivative`"


def check(context: Context) -> Iterator[Finding | str]:
    """Derivatives that contradict differences in time."""
    subject = context.subject
    if subject.exchanges and subject.states:
        yield from _order_of_states(context)
        yield from _nominals(context)
    context = paced(context)
    pairs = [v for v in subject.readable if v.derivative is not None and v.causality != "input"]
    orders = subject.steps and "maxOutputDerivativeOrder" in context.works
    if subject.steps and (pairs or orders):
        yield from _along_a_run(context, pairs, subject.outputs if orders else [])
    shorter = subject.variable_steps and not context.holds
    if subject.steps and "canInterpolateInputs" in context.works and shorter:
        yield from _input_derivatives(context)


def _order_of_states(context: Context) -> Iterator[Finding]:
    """In model exchange: the vectors of states and rates, against the variables they stand for."""
    subject, wrong = context.subject, list[str]()
    both = [*subject.states, *subject.rates]
    with context.probe(exchange=True) as probe:
        probe.begin()
        for x in context.random(subject.states, 2):
            probe.set_states(x)
            vectors = np.concatenate([probe.vector(), probe.rates()])
            values = probe.read(both)
            # the same quantities, computed twice
            differs = abs(vectors - values) > 1e-12 * np.maximum(abs(vectors), abs(values))
            wrong += [
                f"{both[k].name} is {values[k]:g}, the vector has {vectors[k]:g}"
                for k in np.flatnonzero(differs)
            ]
    message = "states or rates are not where ModelStructure has them"
    basis = "FMI 2.0.4, section 2.2.8: the order of the derivatives is that of the states"
    yield from about(wrong, "derivatives.order", "error", message, basis)


def _nominals(context: Context) -> Iterator[Finding]:
    """Nominal values of the states that the FMU tells, against those that are declared."""
    states = context.subject.states
    try:
        with context.probe(exchange=True) as probe:
            told = probe.begin().vector("GetNominalsOfContinuousStates")
    except RefusedError:
        return  # nothing to compare
    wrong = [
        f"{v.name} is told {value:g}" + ("" if declared is None else f", declared {declared:g}")
        for v, value, declared in zip(states, told, map(nominal, states), strict=True)
        if not 0 < value < np.inf
        or (declared is not None and abs(value - declared) > WRITTEN * abs(declared))
    ]
    message = "nominal values of states are not above 0, or not as declared"
    basis = "FMI 2.0.4, section 3.2.2, fmi2GetNominalsOfContinuousStates"
    yield from about(wrong, "derivatives.nominal", "warning", message, basis)


def _along_a_run(
    context: Context, pairs: list[ModelVariable], outputs: list[ModelVariable]
) -> Iterator[Finding]:
    """Samples of a run with inputs that are constant in each window.

    A solver inside that advances in fixed steps of its own is sampled at communication points.
    """
    bases = [v.derivative for v in pairs if v.derivative is not None]
    shorter = context.subject.variable_steps and not context.holds
    spacing = context.step_size * (SPACING if shorter else 1.0)
    values, told = _sampled(context, [*bases, *pairs, *outputs], outputs, spacing)
    of_bases, rates, of_outputs = np.split(values, [len(pairs), 2 * len(pairs)], axis=2)
    found = [follows(*rows, spacing) for rows in zip(of_bases, rates, strict=True)]
    coarse = (np.mean(found, axis=0) > 0.5) | stands(np.concatenate(of_bases))
    what = "along a run, declared derivatives are not those of their variables"
    expected = [_estimate(rows, spacing) for rows in of_bases]
    yield from _contradictions("mismatch", what, BASIS, pairs, rates[:, CENTRE], expected, coarse)
    what = "fmi2GetRealOutputDerivatives is not the derivative along a run"
    basis, none = "FMI 2.0.4, section 4.2.1", np.zeros(len(outputs), bool)
    expected = [_estimate(rows, spacing) for rows in of_outputs]
    yield from _contradictions("output", what, basis, outputs, told, expected, none)


def _sampled(
    context: Context,
    variables: list[ModelVariable],
    outputs: list[ModelVariable],
    spacing: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Samples of variables along a run, and what the FMU derives of outputs in their middle.

    Windows × SAMPLES × variables, `spacing` [s] apart, and windows × outputs.
    """
    samples, told = list[np.ndarray](), list[np.ndarray]()
    with context.probe() as probe:
        probe.begin()
        for row in context.random_inputs(WINDOWS):
            probe.put(context.subject.inputs, row)
            probe.advance(context.step_size)
            for k in range(SAMPLES):
                samples.append(probe.read(variables))
                if k == CENTRE and outputs:
                    told.append(probe.output_derivatives(outputs))
                probe.advance(spacing)
    values = np.reshape(samples, (WINDOWS, SAMPLES, -1))
    return values, np.reshape(told, (WINDOWS, len(outputs)))


def _estimate(rows: np.ndarray, spacing: float) -> Slope:
    """Differences; the FMU's own error per step, relative, counts as an error of the samples.

    Exactly 0 for what changes by rounding only.
    """
    found = at_centre(rows, spacing)
    spread = np.ptp(rows, axis=0)
    still = spread <= SAFETY * np.finfo(float).eps * np.max(np.abs(rows), axis=0)
    noise = TOLERANCE * spread / spacing
    return Slope(np.where(still, 0.0, found.value), found.error + noise)


def _contradictions(
    name: str,
    what: str,
    basis: str,
    variables: list[ModelVariable],
    values: np.ndarray,
    estimates: list[Slope],
    coarse: np.ndarray,
) -> Iterator[Finding]:
    """Variables that contradict the differences in most of the windows that tell something.

    The FMU tells the derivatives `values` (n_windows, n_variables), in their units per second. Of
    variables that are `coarse`, and of those that contradict them by little, roughly only.
    """
    if not variables:
        return
    expected = np.array([e.value for e in estimates])
    error = SAFETY * np.array([e.error for e in estimates])
    largest = np.max(np.abs([values, expected]), axis=(0, 1))
    # where samples miss a fast motion, differences are small beside what the FMU tells, but no
    # larger than their error
    shown = (error < CLEAR * np.max(np.abs(expected), axis=0)) | (expected == 0.0)
    clear = shown & (error < CLEAR * largest)
    off = np.where(clear, np.abs(values - expected), 0.0)
    wrong = off > np.maximum(error, CLEAR**2 * largest)
    most = wrong.sum(axis=0) > clear.sum(axis=0) / 2
    rough = most & ((off <= ROUGH * largest).all(axis=0) | coarse)
    row = np.argmax(off, axis=0)
    texts = [
        f"{v.name}{f' (of {v.derivative.name})' if v.derivative is not None else ''} "
        f"tells {values[row[k], k]:.6g}, got {expected[row[k], k]:.6g}"
        for k, v in enumerate(variables)
    ]
    false = [texts[k] for k in np.flatnonzero(most & ~rough)]
    yield from about(false, f"derivatives.{name}", "error", what, basis)
    message = "along a run, variables follow their derivatives roughly only"
    remedy = "is the solver inside coarse? co-simulation then differs from the equations"
    near = [texts[k] for k in np.flatnonzero(rough)]
    yield from about(near, "derivatives.rough", "warning", message, remedy)


def _input_derivatives(context: Context) -> Iterator[Finding]:
    """A step with inputs that grow linearly, against short steps with inputs in the middle."""
    subject = context.subject
    held = np.array([v.derivative is not None for v in subject.inputs])
    first, last = context.random_inputs(2)
    last = np.where(held, first, last)
    try:
        curved = _grown(context, first, last, parts=0)
        still, coarse, fine = (_grown(context, first, last, parts=parts) for parts in (-1, 8, 16))
        whole, split = (_grown(context, first, first, parts=parts) for parts in (-1, 16))
    except RefusedError:
        return  # steps that short are not possible: nothing to compare with
    best = (4 * fine - coarse) / 3
    # short steps also change the errors of a solver that is coarse, whatever the inputs
    error = SAFETY * (np.abs(fine - coarse) + np.abs(whole - split))
    effect = np.abs(best - still)
    seen = effect > np.maximum(error, SAFETY * TOLERANCE * np.abs(best))
    # a tenth: half of a linear growth is what a first-order mistake would leave out
    wrong = seen & (np.abs(curved - best) > np.maximum(error, 0.1 * effect))
    names = [subject.readable[k].name for k in np.flatnonzero(wrong)]
    message = f"inputs that grow over a step of {context.step_size:g} s do not have their effect on"
    basis = "FMI 2.0.4, section 4.2.1, fmi2SetRealInputDerivatives"
    yield from about(names, "derivatives.input", "error", message, basis)


def _grown(context: Context, first: np.ndarray, last: np.ndarray, *, parts: int) -> np.ndarray:
    """All Reals after a step in which inputs grow from `first` to `last`: in that many parts, told
    as input derivatives (0), or with no growth before the end (-1)."""
    subject, size = context.subject, context.step_size
    with context.probe() as probe:
        probe.begin()
        probe.put(subject.inputs, first)
        if parts == 0:
            probe.set_input_derivatives(subject.inputs, (last - first) / size)
        if parts <= 0:
            probe.advance(size)
        for k in range(parts):
            probe.put(subject.inputs, first + (last - first) * (k + 0.5) / parts)
            probe.advance(size / parts)
        probe.put(subject.inputs, last)
        return probe.read(subject.readable)
