"""FMUs whose saved states do not bring them back, though they say so (canGetAndSetFMUstate).

The run would be altered wherever a step is made again. So before the run, each file is tried once
for each set of start values: an instance that is thrown away makes steps with its inputs moved,
returns, and makes them again. Where its outputs are others then, the component is one that cannot
go back. FMUs of models and of the kinds that come with this package are not tried, nor are native
ones that it has built: all that they know is kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from zipfile import ZipFile

import numpy as np

from m4e_fmi.cosim.binary import OWN, PYTHON
from m4e_fmi.cosim.connect import Wiring
from m4e_fmi.cosim.interruption import setting_up
from m4e_fmi.cosim.start_values import Value
from m4e_fmi.cosim.system import (
    Component,
    FmuFile,
    Kind,
    ModelFile,
    Simulation,
    System,
)
from m4e_fmi.cosim.trial import Instances, Subject, driven_inputs
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.opening import opened
from m4e_fmi.fmu.reading import Description

BEFORE, AGAIN = 2, 4
"""Steps up to the state that is kept, and steps that are made from it twice."""
SAME = 1e-3
"""Share of what an output does in these steps by which solvers that begin anew may differ."""
ROUNDING = 1e-9
"""Likewise of its size."""
OWN_KINDS = "m4e_fmus.", "m4e_adapters."
"""Packages of the kinds that come with this one."""


def without_forgetful(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> tuple[dict[str, Description], list[str]]:
    """The descriptions as they hold in a run, and a line for each FMU that cannot go back."""
    result = dict(descriptions)
    driven = driven_inputs(wiring)
    known: dict[object, str] = {}
    told: dict[tuple[str, str], list[str]] = {}
    for component in system.components:
        description = descriptions[component.name]
        if not description.saves_state or description.once_per_process:
            continue
        if _is_own(component.source, description):
            continue
        inputs = driven.get(component.name, ())
        start = tuple(sorted((name, str(value)) for name, value in component.start.items()))
        key = description.path, start, component.step_size, inputs
        if key not in known:
            known[key] = _fault(component, description, system.simulation, inputs)
        if known[key]:
            result[component.name] = replace(description, saves_state=False)
            told.setdefault((description.path.name, known[key]), []).append(component.name)
    return result, [
        f"{', '.join(names)}: {fmu} says that it can go back (canGetAndSetFMUstate), but {fault}: "
        f"taken as one that cannot; `m4e-fmi validate {fmu}` tells more (group state), to be "
        "mended in the FMU"
        for (fmu, fault), names in told.items()
    ]


def _is_own(source: FmuFile | ModelFile | Kind, description: Description) -> bool:
    """Whether the FMU is made of nothing but this package's code."""
    if isinstance(source, Kind):
        return type(source.config).__module__.startswith(OWN_KINDS)
    if isinstance(source, ModelFile) or not description.tool.startswith(OWN):
        return isinstance(source, ModelFile)
    with opened(description.path, description.content) as file, ZipFile(file) as archive:
        return PYTHON not in archive.namelist()


def _fault(
    component: Component, description: Description, simulation: Simulation, inputs: Sequence[str]
) -> str:
    """Why an FMU cannot go back; empty if it can, or if steps cannot be made."""
    outputs = [variable.name for variable in description.of_causality("output")]
    new = Instances(component, description, simulation)
    for moves in (True, False):
        try:
            with setting_up(), new.instance() as instance:
                subject = Subject(instance, outputs, inputs)
                if moves:
                    subject.set(subject.moved_together())
                for _ in range(BEFORE):
                    subject.step(new.step)
                time = instance.time
                try:
                    instance.save_state()
                except RunError as error:
                    return f"its state cannot be saved ({error.message})"
                first = list(_course(subject, new.step))
                try:
                    instance.restore_state(time)
                    second = list(_course(subject, new.step))
                except RunError as error:
                    return f"it fails after a return ({error.message})"
        except RunError:
            continue
        return _difference(outputs, first, second)
    return ""


def _course(subject: Subject, size: float) -> Iterator[list[Value]]:
    """The outputs after each of some steps of `size` [s]."""
    for _ in range(AGAIN):
        subject.step(size)
        yield subject.read()


def _difference(
    outputs: Sequence[str], first: Sequence[list[Value]], second: Sequence[list[Value]]
) -> str:
    """Which outputs are others in the second of two courses; empty if none are."""
    different = []
    columns = (zip(*rows, strict=True) for rows in (first, second))
    for name, one, other in zip(outputs, *columns, strict=True):
        if _differ(one, other):
            different.append(name)
    if not different:
        return ""
    more = f" and {len(different) - 3} more" if len(different) > 3 else ""
    names = ", ".join(different[:3]) + more
    return f"steps made again after a return give another {names}"


def _differ(one: Sequence[Value], other: Sequence[Value]) -> bool:
    """Whether courses of an output differ by more than rounding and a solver's new beginning."""
    if not isinstance(one[0], float):
        return one != other
    a, b = np.array(one, dtype=float), np.array(other, dtype=float)
    both = np.concatenate((a, b))
    if not np.isfinite(both).all():
        return False
    return bool(np.abs(a - b).max() > SAME * np.ptp(both) + ROUNDING * np.abs(both).max())
