"""Varied values as numbers in the units of what they are given to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from m4e_fmi.cosim.system.simulation import TOLERANCES
from m4e_fmi.errors import Problem
from m4e_fmi.study.given.grid import Varied
from m4e_fmi.study.given.sections import Scalar
from m4e_fmi.study.given.study import Study
from m4e_fmi.study.systems.targets import (
    KeyTarget,
    SettingTarget,
    StartTarget,
    Target,
    Targets,
)
from m4e_fmi.units import number_in, parse_unit

RENAME = "convert the column if need be, and leave the unit out of its name"


def in_units(study: Study, targets: Targets) -> tuple[Study, list[Problem]]:
    """The study whose start values are numbers in the units of their variables.

    Texts with a unit, as ``"5 mm"``, and columns of tables whose names have one are converted.
    Problems are values of other dimension, and units of what takes plain numbers only: they stay as
    they are, as do those of names without a target.
    """
    problems: list[Problem] = []
    axes = []
    for axis in study.grid.axes:
        columns = [[point[k] for point in axis.points] for k in range(len(axis.varied))]
        for k, varied in enumerate(axis.varied):
            if not all(name in targets for name in varied.targets):
                continue
            of = [targets[name] for name in varied.targets]
            try:
                columns[k] = _converted(varied, of, columns[k])
            except ValueError as error:
                message = f"{varied.targets[0]}: {error}"
                remedy = RENAME if varied.column else ""
                problems.append(study.document.problem(varied.location, message, remedy))
        axes.append(replace(axis, points=tuple(zip(*columns, strict=True))))
    return replace(study, grid=replace(study.grid, axes=tuple(axes))), problems


def new_places(problems: Sequence[Problem], told: Sequence[Problem]) -> list[Problem]:
    """The `problems` at places where none was `told`: a value is told once."""
    places = {(one.line, one.column) for one in told}
    return [one for one in problems if (one.line, one.column) not in places]


def _converted(varied: Varied, targets: Sequence[Target], values: Sequence[Scalar]) -> list[Scalar]:
    """The values of a varied quantity; ValueError where they do not fit."""
    units = set(map(_unit, targets))
    unit = units.pop() if len(units) == 1 else None
    if varied.unit:
        given = parse_unit(varied.unit)
        of_component = isinstance(targets[0], KeyTarget) and targets[0].component
        unclear = of_component and given.same_dimension(parse_unit("rad"))  # some keys are in deg
        if unit is None and (given.factor != 1.0 or unclear):
            message = f"the column {varied.column!r} names a unit, but {targets[0]} takes numbers"
            raise ValueError(f"{message} as its documentation says")
        if unit:  # a variable without a unit takes any
            try:
                return [number_in(unit, f"{value!r} {varied.unit}") for value in values]
            except ValueError as error:
                raise ValueError(f"the column {varied.column!r}: {error}") from None
    if unit is None or not isinstance(targets[0], StartTarget):
        return [*values]
    return [number_in(unit, value) if isinstance(value, str) else value for value in values]


def _unit(target: Target) -> str | None:
    """Unit of the numbers that a target takes; None if only its documentation says it."""
    if isinstance(target, SettingTarget):
        return "1" if target.key in TOLERANCES else "s"
    return target.unit if isinstance(target, StartTarget) and target.is_real else None
