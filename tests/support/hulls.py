"""Hydrodynamics of sections of a system file, and hulls of shapes and mesh files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, make_hulls
from m4e_adapters.hydrodynamics.build import check_config, program_in_waves
from m4e_adapters.hydrodynamics.config import Body
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program

Section = str | dict[str, Any] | HydrodynamicsConfig


def silent(_: str) -> None:
    """Takes what is told."""


def configured(section: Section) -> HydrodynamicsConfig:
    """The configuration of a section, in YAML or as a mapping."""
    if isinstance(section, HydrodynamicsConfig):
        return section
    if isinstance(section, str):
        return Document.parse(section).validate(HydrodynamicsConfig)
    return HydrodynamicsConfig.model_validate(section)


def hulls(section: Section, folder: Path = Path()) -> tuple[Hull, ...]:
    return make_hulls(configured(section), folder, progress=silent)


def doubts(section: Section, folder: Path = Path()) -> list[str]:
    """Messages of problems of the hulls, and what is told of them."""
    told: list[str] = []
    problems: list[Problem] = []
    try:
        make_hulls(configured(section), folder, progress=told.append)
    except InputError as error:
        problems = error.problems
    assert all(problem.remedy for problem in problems)
    return [problem.message for problem in problems] + told


def hull(
    shape: dict[str, Any],
    folder: Path = Path(),
    *,
    center: tuple[float, ...] = (0, -1),
    finer: int = 1,
    **body: Any,
) -> Hull:
    """The hull of a body `float`; `center` [m] of gravity."""
    given = {"shape": shape, "center_of_gravity": center, **body}
    return make_hull("float", Body.model_validate(given), folder, finer=finer, progress=silent)


def checked_program(section: Section, folder: Path = Path()) -> Program:
    """The program of a section with coefficients that take no time to be computed."""
    return check_config(configured(section), folder=folder)


def in_waves(section: Section, highest: float = 1.0) -> tuple[Program, HullWaves]:
    """The program with waves as inputs."""
    return program_in_waves(
        configured(section), name="hydro", folder=Path(), highest=highest, progress=silent
    )
