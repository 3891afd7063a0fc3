"""The system of a study, by which names and values are judged."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component
from m4e_fmi.cosim.system.simulation import CHECKPOINTS, SETTINGS
from m4e_fmi.cosim.system.start_values import single_problems
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import load_system
from m4e_fmi.cosim.wiring.prepared import chosen
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.names import Named, Runnable, named, system_problems
from m4e_fmi.study.targets import Target, system_target


def changed(system: System, settings: Mapping[str, object]) -> System:
    """The system with other settings of its simulation; InputError if they do not fit."""
    if odd := settings.keys() & {"start", "origin"}:
        raise InputError.single(f"the simulation has no setting {min(odd)!r}")
    return system.changed(origin="study", **settings)  # pyrefly: ignore[bad-argument-type]


class SystemOfStudy(Runnable):
    """The `system` of a study with what holds for all runs, as far as that fits.

    `descriptions` are those that its FMUs have or will have.
    """

    settings = tuple(key for key in SETTINGS if key not in CHECKPOINTS)

    def __init__(self, study: Study) -> None:
        self._given = self.system = load_system(study.source)
        if not study.composed:
            with suppress(InputError):
                self.system = changed(self.system, study.simulation)
        with suppress(InputError):
            self.system = self.system.changed(start=study.start, origin="study")
        self.descriptions = expected_descriptions(self.system)
        self._components = {one.name: one for one in self.system.components}

    def target(self, name: str) -> Target:
        """The meaning of a varied name that is no setting."""
        return system_target(self.system, self.descriptions, name)

    def check_settings(self, given: Mapping[str, Scalar]) -> None:
        """Settings of all runs, together."""
        changed(self._given, given)

    def check_start(self, name: str, value: Scalar) -> None:
        """A start value by the whole name of its variable."""
        component, _, variable = name.partition(".")
        self.system.changed(start={name: value}, origin="study")
        if component in self.descriptions:
            part = Component(component, self._components[component].source, {variable: value})
            found = single_problems(self.system, part, self.descriptions[component])
            InputError.raise_for(found)

    def check_variable(self, name: str) -> None:
        """A variable whose series or statistic is wanted."""
        members = chosen(self.descriptions, [name])
        found = [v for one in members.values() for v in one]
        if len(found) != 1:
            message = f"{name} stands for {len(found)} variables"
            raise InputError.single(message, "name one of them")
        if found[0].type not in ("Real", "Integer", "Enumeration", "Boolean"):
            message = f"{name} is of type {found[0].type}, of which there are no statistics"
            raise InputError.single(message)

    def variable(self, name: str) -> Variable:
        """The variable ``component.variable``."""
        component, _, variable = name.partition(".")
        return self.descriptions[component].variables[variable]


def named_system(study: Study) -> tuple[Named, SystemOfStudy]:
    """A study of a system with its names resolved, and the system; InputError with all problems."""
    of = SystemOfStudy(study)
    found = named(study, of)
    InputError.raise_for(dict.fromkeys(system_problems(found, of.system)))
    return found, of
