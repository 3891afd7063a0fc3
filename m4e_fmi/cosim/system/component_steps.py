"""Which components of a system have a step of their own, and whether all of them can keep to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from m4e_fmi.cosim.system.component_step import ComponentStep, common_step, fits, rate, seconds
from m4e_fmi.cosim.system.system import NS_PER_SECOND, TICK, Component, Simulation, System, is_whole
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.fmu.importer.reading import Description

ComponentSteps = Mapping[str, ComponentStep]
"""Component → its rate; those that algorithms may step as they like are not in it."""


def rounded(simulation: Simulation) -> list[str]:
    """A line that tells the steps of a step_size that is none of whole nanoseconds."""
    size = simulation.step_size
    if is_whole(size):
        return []
    return [
        f"steps are whole nanoseconds: those of step_size {size:.12g} s are "
        f"{round(size * NS_PER_SECOND)} ns long"
    ]


def refined(system: System, descriptions: Mapping[str, Description]) -> tuple[System, str]:
    """The system with the longest step, its own or a part of it, that meets all components' points.

    If that is a shorter one, the text tells; the rows of the results stay where they are, and FMUs
    that make steps of one size keep to the step that was given. Steps that fit to none are left to
    `pace` to tell.
    """
    simulation, macro = system.simulation, system.simulation.step
    given = {
        c.name: c.step_size or _internal_step(descriptions[c.name], macro)
        for c in system.components
    }
    own = {name: seconds(step) for name, step in given.items() if step}
    step, problems = common_step(macro, own, TICK)
    if problems or step == macro:
        return system, ""
    usual = simulation.step_size
    odd = " and ".join(name for name, h in own.items() if not fits(h, macro))
    note = (
        f"the system steps by {float(step):g} s, {macro / step} times in each {usual:g} s, to meet "
        f"all points of {odd}"
    )
    interval = simulation.output_interval or usual
    finer = replace(simulation, step_size=float(step), output_interval=interval)
    fixed = {name: usual for name, d in descriptions.items() if d.constant_step}
    components = tuple(
        replace(c, step_size=given[c.name] or fixed.get(c.name)) for c in system.components
    )
    return replace(system, components=components, simulation=finer), note


def pace(system: System, descriptions: Mapping[str, Description]) -> dict[str, ComponentStep]:
    """The rates of the components that have one: given in the system, or wanted by their FMU.

    An FMU that makes no steps of different sizes (canHandleVariableCommunicationStepSize) is
    stepped by the system's step if nothing else is given; one that tells the step it goes by inside
    (fixedInternalStepSize), by that, unless its outputs have to follow its inputs in between: see
    `_internal_step`. InputError with all problems: steps that do not fit to that of the system, or
    to what the FMU says; that the run or adaptive steps do not allow.
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
        except ValueError as error:
            message, remedy = error.args
            at = ("components", component.name, "step_size")
            problems.append(system.problem(at, f"component {component.name!r}: {message}", remedy))
    if problems:
        raise InputError(problems)
    return found


def _internal_step(description: Description, macro: Fraction) -> float | None:
    """The FMU's internal step [s] if it is to be stepped by that; `macro` is the system's step.

    One that is longer than the system's is no step to take if an output follows an input at once,
    as in an FMU without states: between the points of so long a step the output would stand still.
    Such an FMU keeps to its internal step by itself, if it takes steps of different sizes.
    """
    inside = description.internal_step
    follows = any(description.dependencies.values())
    if inside and follows and not description.constant_step and seconds(inside) > macro:
        return None
    return inside


def _rate(component: Component, description: Description, system: System) -> ComponentStep | None:
    macro, constant = system.simulation.step, description.constant_step
    if component.step_size is None:
        inside = _internal_step(description, macro)
        if inside is None:
            return rate(macro, macro, constant=True) if constant else None
        try:
            return rate(seconds(inside), macro, constant=constant)
        except ValueError as error:
            message, remedy = error.args
            text = f"its FMU goes by steps of {inside:g} s (fixedInternalStepSize)"
            raise ValueError(f"{text}: {message}", remedy) from None
    own, inside = seconds(component.step_size), description.internal_step
    if inside is not None:
        try:
            fits = rate(seconds(inside), own).every == 1
        except ValueError:
            fits = False
        if not fits:
            raise ValueError(
                f"step_size {float(own):g} s is no multiple of {inside:g} s, by which its FMU goes "
                "(fixedInternalStepSize)",
                f"take {inside:g} s, or leave it out",
            )
    return rate(own, macro, constant=constant)


def _check(own: ComponentStep, system: System) -> None:
    """ValueError, whose arguments are message and remedy, if the run does not allow this rate."""
    simulation = system.simulation
    only = "its FMU makes steps of one size only (canHandleVariableCommunicationStepSize)"
    if simulation.coupling_tolerance is not None and (own.constant or own.is_sampled):
        why = only if own.constant else f"it {own}"
        raise ValueError(
            f"{why}, and with a coupling_tolerance the steps of the system change",
            "leave coupling_tolerance out",
        )
    begin, end = (
        round(simulation.start_time * NS_PER_SECOND),
        round(simulation.stop_time * NS_PER_SECOND),
    )
    left = Fraction(end - begin, NS_PER_SECOND) % simulation.step
    if left and not own.shortens:
        stop = Fraction(end, NS_PER_SECOND) - left
        raise ValueError(
            f"{only}, and the last step would be one of {float(left):g} s",
            f"take a stop_time of {float(stop):g} s or {float(stop + simulation.step):g} s",
        )
