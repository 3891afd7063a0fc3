"""`Study`: what is varied, what is wanted, of which system or model."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, is_file, missing_file, suggestion
from m4e_fmi.files.document import Document
from m4e_fmi.shown import short
from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study.given.axes import RESERVED, grid_of
from m4e_fmi.study.given.grid import Grid
from m4e_fmi.study.given.sections import Scalar, StudySection

STOP_TIME = "simulation.stop_time"


@dataclass(frozen=True)
class Wanted:
    """A statistic of a variable, by which the result has it as `name`."""

    name: str
    variable: str
    statistic: str
    parameters: tuple[tuple[str, float], ...] = ()

    def unit(self, unit: str) -> str:
        """Unit of the statistic of a variable in `unit`."""
        return STATISTICS[self.statistic].unit(unit)

    def __str__(self) -> str:
        told = "".join(f", {name} {value:g}" for name, value in self.parameters)
        return f"{self.statistic.replace('_', ' ')} of {self.variable}{told}"


@short
@dataclass(frozen=True)
class Study:
    """A study as given in a file: `source` is the system or the model that runs.

    `start_up` [s] is left out of statistics (None: a default by the sea). With `coupling_error`,
    that of each run is estimated. `composed` systems run as one program.
    """

    name: str
    source: Path
    is_model: bool
    grid: Grid
    wanted: tuple[Wanted, ...]
    series: tuple[str, ...] = ()
    simulation: dict[str, Scalar] = field(default_factory=dict)
    start: dict[str, Scalar] = field(default_factory=dict)
    composed: bool = False
    start_up: float | None = None
    coupling_error: bool = True
    description: str = ""
    document: Document = field(default_factory=lambda: Document.parse("name: none"), repr=False)
    text: str = field(default="", repr=False)

    @property
    def is_program(self) -> bool:
        """True if it runs as one program: a model, or a composed system."""
        return self.is_model or self.composed


def load_study(path: str | Path) -> Study:
    """The study in a YAML file; InputError with all problems of the file.

    Names and values are compared with the system or the model when it runs.
    """
    document = Document.load(path)
    part, problems = document.validate(StudySection), list[Problem]()
    source = _source(part, document, problems)
    grid = grid_of(part, document, problems)
    wanted = _wanted(part, document, problems)
    if part.start_up is not None and part.start_up < 0.0:
        at = ("start_up", "@value")
        problems.append(document.problem(at, f"start_up {part.start_up:g} s is below 0"))
    if problems or source is None:
        raise InputError(dict.fromkeys(problems))
    return Study(
        name=part.name,
        source=source,
        is_model=part.model is not None,
        grid=grid,
        wanted=wanted,
        series=part.series,
        simulation=part.simulation,
        start=part.start,
        composed=part.method == "composed",
        start_up=part.start_up,
        coupling_error=part.coupling_error,
        description=part.description,
        document=document,
        text=Path(path).read_text("utf-8-sig"),
    )


def _source(section: StudySection, document: Document, problems: list[Problem]) -> Path | None:
    """The file of the system or model, None if there is none; adds to `problems`."""
    given = [key for key in ("system", "model") if getattr(section, key) is not None]
    if len(given) != 1:
        what = "has 'system' and 'model'" if given else "has neither 'system' nor 'model'"
        remedy = "give one: 'system: system.yaml' or 'model: x.model.yaml'"
        at = (given[0] if given else "name",)
        problems.append(document.problem(at, f"the study {what}", remedy))
        return None
    path = document.path.parent / getattr(section, given[0])
    if not is_file(path):
        problems.append(document.problem((given[0], "@value"), *missing_file(path)))
        return None
    return path


def _wanted(
    section: StudySection, document: Document, problems: list[Problem]
) -> tuple[Wanted, ...]:
    """The statistics that are wanted; adds to `problems`."""
    if not section.wanted and not section.series:
        remedy = "write wanted: {NAME: {variable: …, statistic: mean}}, or series: [VARIABLE]"
        problems.append(document.problem(("name",), "the study wants nothing", remedy))
    found = []
    for name, one in section.wanted.items():
        at = ("wanted", name)
        if name in RESERVED:
            problems.append(document.problem(at, f"the result has a {name} of its own"))
        if one.statistic not in STATISTICS:
            remedy = suggestion(one.statistic, STATISTICS, "statistics")
            message = f"unknown statistic {one.statistic!r}"
            problems.append(document.problem((*at, "statistic", "@value"), message, remedy))
            continue
        given = one.model_extra or {}
        problems += [
            document.problem(at, problem.message, problem.remedy)
            for problem in STATISTICS[one.statistic].problems(given)
        ]
        parameters = tuple(given.items())
        found.append(Wanted(name, one.variable, one.statistic, parameters))
    return tuple(found)
