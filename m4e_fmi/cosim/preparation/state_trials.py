"""FMUs whose saved states do not bring them back, though they say so (canGetAndSetFMUstate).

The run would be altered wherever a step is made again. So before the run, each file is tried once
for each set of start values: an instance that is thrown away makes steps with its inputs moved,
returns, and makes them again. Where its outputs are others then, the component is one that cannot
go back. If there are to be checkpoints, another instance goes on from the state as bytes (of FMUs
in processes of their own); where it does not, checkpoints have no states. FMUs of models and of the
kinds that come with this package are not tried, nor are native ones that it has built: all that
they know is kept. Python code of users is tried.

FMUs do not declare up to which order they take time derivatives of inputs, either, and after an
error no instance can go on. So before a run whose algorithm lets inputs follow their sources, those
not built here get some, and make a step: with first and second ones, then with first ones alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from zipfile import ZipFile

import numpy as np

from m4e_fmi.cosim.network.loading import PYTHON
from m4e_fmi.cosim.preparation.trial_instances import (
    Instances,
    Subject,
    Trials,
    driven_inputs,
)
from m4e_fmi.cosim.system.component import FmuFile, Kind, ModelFile
from m4e_fmi.cosim.system.start_values import Value
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.links import Wiring
from m4e_fmi.coupling_algorithms import LinkDelay, algorithm_descriptor
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.opening import opened
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.type_rules import REAL, TYPES
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.shown import first_of
from m4e_fmi.signals import not_lost

BEFORE, REPEATED = 2, 4
"""Steps up to the state that is kept, and steps that are made from it twice, with held inputs."""
SAME, ROUNDING = 1e-3, 1e-9
"""Shares of what an output does there, and of its size, by which repetitions may differ."""
GROSS, TOLERANCE = 0.2, 1e-3
"""The same where one of the trajectories has gone on, and the other begins anew."""
OWN_KINDS = "m4e_fmus.", "m4e_adapters."
"""Packages of the kinds that come with this one."""
USERS_CODE = "m4e_fmus.python_file"
"""That of the kind whose FMUs have code of users, unless they are native."""

_ROLLBACK = "rollback (canGetAndSetFMUstate), but {}: run without rollback"
_ADVICE = (
    "`m4e-fmi validate {}` tells more (groups state and state_elsewhere), to be mended in the FMU"
)
_ADVICE_ON_CODE = (
    "keep all that changes, random generators with a seed too, in attributes of self, as numbers, "
    "lists, dicts or arrays; or give the class save and restore"
)
_BYTES = "states as bytes (canSerializeFMUstate), but {}: run without states in checkpoints"


_REFUSED = (
    "{} refuses time derivatives of inputs, though it declares canInterpolateInputs: inputs are "
    "held",
    "{} refuses second time derivatives of inputs: these follow straight lines",
)
_UNTRIED = (
    "{} allows one instance per process, so that it is not known which time derivatives of inputs "
    "it takes: inputs are held; it is tried with `process: own`"
)


def without_refused(
    system: System,
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    hosts: Mapping[str, Host],
) -> tuple[dict[str, Description], list[str]]:
    """The descriptions with the orders of derivatives that FMUs take, and lines on refusals."""
    result, trials = dict(descriptions), Trials(system, descriptions, hosts)
    delay = algorithm_descriptor(system.simulation.algorithm).link_delay
    inputs = driven_inputs(wiring) if delay in (LinkDelay.CORRECTED, LinkDelay.SOLVED) else {}
    for component in (c for c in system.components if c.name in inputs):
        description = descriptions[component.name]
        if description.is_own or not description.input_order:
            continue
        alone = description.once_per_process and component.name not in hosts
        order = 0 if alone else trials.ask(component, _order, inputs[component.name])
        if order < description.input_order:
            result[component.name] = replace(description, input_order=order)
            text = _UNTRIED if alone else _REFUSED[order]
            trials.note(text.format(description.path.name), component)
    return result, trials.lines()


def _order(new: Instances, description: Description, inputs: Sequence[str]) -> int:
    """The highest order of which an FMU takes derivatives; that declared, if it makes no step."""
    reals = [name for name in inputs if description.variables[name].type == REAL]
    for most in range(description.input_order, -1, -1):
        try:
            with new.instance() as instance, not_lost():
                for order, name in product(range(1, most + 1), reals):
                    status = instance.set_derivative(name, order, 0.0)
                    if status := status or instance.flush():  # those that warn ignore it
                        instance.fail(status, "fmi2SetRealInputDerivatives")
                Subject(instance, (), ()).step(new.step)
        except RunError:
            continue
        return most
    return description.input_order


class _FaultError(Exception):
    """An FMU does not save its state or does not return to it; the text says how that shows."""


def without_forgetful(
    system: System,
    descriptions: Mapping[str, Description],
    wiring: Wiring,
    hosts: Mapping[str, Host],
) -> tuple[dict[str, Description], list[str]]:
    """The descriptions as they hold in a run, and a line for each FMU that cannot go back."""
    result, trials = dict(descriptions), Trials(system, descriptions, hosts)
    driven, saved = driven_inputs(wiring), system.simulation.has_checkpoints
    for component in system.components:
        description = descriptions[component.name]
        if not description.saves_state or description.once_per_process:
            continue
        if _is_own(component.source, description):
            continue
        coded, file = _is_code_of_kind(component.source), description.path.name
        advice = _ADVICE_ON_CODE if coded else _ADVICE.format(file)
        if fault := trials.ask(component, _fault, driven.get(component.name, ()), coded):
            result[component.name] = replace(description, saves_state=False)
            trials.note(f"{file} declares {_ROLLBACK.format(fault)}; {advice}", component)
            continue
        saves = saved and description.serializes_state and component.name in hosts
        if saves and (lost := trials.ask(component, _fault_of_bytes)):
            result[component.name] = replace(description, serializes_state=False)
            trials.note(f"{file} declares {_BYTES.format(lost)}; {advice}", component)
    return result, trials.lines()


def _is_code_of_kind(source: FmuFile | ModelFile | Kind) -> bool:
    """True if the component is a Python file of the user."""
    return isinstance(source, Kind) and type(source.config).__module__.startswith(USERS_CODE)


def _is_own(source: FmuFile | ModelFile | Kind, description: Description) -> bool:
    """True if the FMU is made of nothing but this package's code."""
    if isinstance(source, ModelFile):
        return True
    if isinstance(source, Kind) and not _is_code_of_kind(source):
        return type(source.config).__module__.startswith(OWN_KINDS)
    if not description.is_own:
        return False
    with opened(description.path, description.content) as file, ZipFile(file) as archive:
        return PYTHON not in archive.namelist()


def _fault(new: Instances, description: Description, inputs: Sequence[str], repeats: bool) -> str:
    """Why an FMU cannot go back; empty if it can, or if steps cannot be made.

    What no other instance repeats either, as of clocks, is no fault unless it `repeats` by all
    means.
    """
    outputs = [v.name for v in description.of_causality("output") if v.type in TYPES]
    for moves in (True, False):
        try:
            trajectories = _trajectories(new, outputs, inputs, moves=moves)
            different = _different(outputs, *trajectories)
            if different and not repeats:
                first, *_ = _trajectories(new, outputs, inputs, moves=moves)
                different -= _differing(outputs, trajectories[0], first, SAME, ROUNDING)
        except _FaultError as fault:
            return str(fault)
        except RunError:
            continue
        return _named([name for name in outputs if name in different])
    return ""


def _fault_of_bytes(new: Instances, description: Description) -> str:
    """Why another instance cannot go on from an FMU's state; empty if it can.

    Empty also if steps cannot be made.
    """
    outputs = [v.name for v in description.of_causality("output") if v.type in TYPES]
    try:
        with new.instance() as instance:
            subject = Subject(instance, outputs, ())
            for _ in range(BEFORE):
                subject.step(new.step)
            time = instance.time
            try:
                instance.save_state()
                state = instance.rollback.serialized(instance.slot())
            except RunError as error:
                return f"its state cannot be saved ({error.message})"
            going_on = subject.trajectory(new.step, REPEATED)
    except RunError:
        return ""
    try:
        with new.instance() as instance:
            instance.rollback.deserialize(instance.slot(), state)
            instance.restore_state(time)
            beginning = Subject(instance, outputs, ()).trajectory(new.step, REPEATED)
    except RunError as error:
        return f"another instance cannot go on from them ({error.message})"
    different = _differing(outputs, going_on, beginning, GROSS, TOLERANCE)
    names = _named([name for name in outputs if name in different])
    return names and f"in another instance {names}"


def _trajectories(
    new: Instances, outputs: Sequence[str], inputs: Sequence[str], *, moves: bool
) -> list[list[list[Value]]]:
    """The outputs along the same steps three times: going on, and after two returns.

    _FaultError if there is no return, RunError if steps cannot be made.
    """
    with new.instance() as instance:
        subject = Subject(instance, outputs, inputs)
        if moves:
            subject.set(subject.moved_together())
        for _ in range(BEFORE):
            subject.step(new.step)
        time = instance.time
        try:
            instance.save_state()
        except RunError as error:
            raise _FaultError(f"its state cannot be saved ({error.message})") from error
        found = [subject.trajectory(new.step, REPEATED)]
        try:
            for _ in range(2):
                instance.restore_state(time)
                found.append(subject.trajectory(new.step, REPEATED))
        except RunError as error:
            raise _FaultError(f"it fails after rollback ({error.message})") from error
    return found


def _different(
    outputs: Sequence[str],
    first: Sequence[list[Value]],
    second: Sequence[list[Value]],
    third: Sequence[list[Value]],
) -> set[str]:
    """The outputs that a return does not bring back.

    After both returns solvers begin anew, and do the same; beside the trajectory that went on,
    where they did not, they may be off by their tolerance.
    """
    return _differing(outputs, second, third, SAME, ROUNDING) | _differing(
        outputs, first, second, GROSS, TOLERANCE
    )


def _differing(
    outputs: Sequence[str],
    one: Sequence[list[Value]],
    other: Sequence[list[Value]],
    share: float,
    of_size: float,
) -> set[str]:
    """The outputs that differ by more than a share of what they do and one of their size."""
    columns = (zip(*rows, strict=True) for rows in (one, other))
    found = set()
    for name, a, b in zip(outputs, *columns, strict=True):
        if not isinstance(a[0], float):
            if a != b:
                found.add(name)
            continue
        both = np.array([a, b], dtype=float)
        limit = share * np.ptp(both) + of_size * np.abs(both).max()
        if np.isfinite(both).all() and np.abs(both[0] - both[1]).max() > limit:
            found.add(name)
    return found


def _named(different: Sequence[str]) -> str:
    """The fault of these outputs in words; empty without any."""
    if not different:
        return ""
    return f"steps repeated after rollback give another {first_of(different, 3)}"
