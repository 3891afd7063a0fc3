"""The components of a system with a step of their own, checked against their FMUs and the run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.simulation import (
    NS_PER_SECOND,
    ComponentStep,
    fits,
    rate,
    seconds,
)
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu.importer.reading import Description

ComponentSteps = Mapping[str, ComponentStep]
"""Component → its step; without those that algorithms may step as they like."""


def pace(system: System, descriptions: Mapping[str, Description]) -> dict[str, ComponentStep]:
    """The steps of the components that have their own: given in the system, or set by their FMU.

    An FMU that makes steps of one size only (canHandleVariableCommunicationStepSize) is stepped by
    the system's step if nothing else is given; one with a fixedInternalStepSize by that, unless its
    outputs depend on its inputs in between (`_internal_step`). InputError with all problems: steps
    that do not fit to that of the system, or to the FMU's; that the run or adaptive steps do not
    allow.
    """
    problems: list[Problem] = []
    found: dict[str, ComponentStep] = {}
    for component in system.components:
        description = descriptions[component.name]
        try:
            own = _rate(component, description, system)
            if own is not None:
                _check(own, system)
                adaptive = system.simulation.coupling_tolerance is not None
                found[component.name] = replace(own, adaptive=adaptive)
        except InputError as error:
            found_here = error.problems[0]
            message = f"component {component.name!r}: {found_here.message}"
            at = ("components", component.name, "step_size")
            problems.append(system.problem(at, message, found_here.remedy))
    InputError.raise_for(problems)
    return found


def _internal_step(description: Description, macro: Fraction) -> float | None:
    """The FMU's internal step [s] if it is to be stepped by that; `macro` [s] is the system's step.

    A longer one than the system's is not taken if an output depends directly on an input, as in an
    FMU without states: between the points of so long a step the output would stand still. Such an
    FMU keeps to its internal step by itself, if it takes steps of different sizes.
    """
    inside = description.internal_step
    has_feed_through = any(description.dependencies.values())
    if inside and has_feed_through and not description.constant_step and seconds(inside) > macro:
        return None
    return inside


def _rate(component: Component, description: Description, system: System) -> ComponentStep | None:
    """The component's own step, None without one; InputError if it does not fit."""
    macro, constant = system.simulation.step, description.constant_step
    if _holds(component, description, system):
        return replace(rate(macro, macro, constant=constant), held=True)
    if component.step_size is None:
        inside = _internal_step(description, macro)
        if inside is None:
            return rate(macro, macro, constant=True) if constant else None
        try:
            return rate(seconds(inside), macro, constant=constant)
        except InputError as error:
            problem = error.problems[0]
            text = f"its FMU has internal steps of {inside:g} s (fixedInternalStepSize)"
            raise InputError.single(f"{text}: {problem.message}", problem.remedy) from None
    own, inside = seconds(component.step_size), description.internal_step
    if inside is not None:
        internal = seconds(inside)
        if not fits(internal, own) or rate(internal, own).is_longer:
            raise InputError.single(
                f"step_size {float(own):g} s is not a multiple of {inside:g} s, its FMU's own step "
                "(fixedInternalStepSize)",
                f"take {inside:g} s, or leave it out",
            )
    return rate(own, macro, constant=constant)


def _holds(component: Component, description: Description, system: System) -> bool:
    """True of a sampled component, with discrete outputs, that steps by the system's step.

    It does so by its `step_size`, or without one if it was built here.
    """
    step, adaptive = component.own_step, system.simulation.coupling_tolerance is not None
    reals = [v for v in description.of_causality("output") if v.type == "Real"]
    by_system = description.is_own if step is None else step == system.simulation.step
    discrete = bool(reals) and all(v.variability == "discrete" for v in reals)
    return discrete and by_system and description.internal_step is None and not adaptive


def _check(own: ComponentStep, system: System) -> None:
    """InputError if the run does not allow this step."""
    simulation = system.simulation
    only = "its FMU makes steps of one size only (canHandleVariableCommunicationStepSize)"
    if simulation.coupling_tolerance is not None and (own.constant or own.is_longer):
        why = only if own.constant else f"it {own}"
        raise InputError.single(
            f"{why}, and with a coupling_tolerance the steps of the system change",
            "leave coupling_tolerance out",
        )
    step, end = simulation.step_ns, simulation.stop_ns
    left = (end - simulation.start_ns) % step
    if left and not own.shortens:
        fitting = (f"{time / NS_PER_SECOND:g} s" for time in (end - left, end - left + step))
        raise InputError.single(
            f"{only}, and the last step would be one of {left / NS_PER_SECOND:g} s",
            f"take a stop_time of {' or '.join(fitting)}",
        )
