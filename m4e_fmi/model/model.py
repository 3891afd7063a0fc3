"""Model: everything that was said about one multibody system, checked as a whole."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.model.checks import doubts, findings, findings_with, lacking
from m4e_fmi.model.findings import ModelFinding
from m4e_fmi.model.groups import Groups
from m4e_fmi.shown import listing


@dataclass(frozen=True)
class Model(Groups):
    """A multibody system: names map to elements, in the order they were given.

    With `dimensions` 2 it lies in the X–Z plane, with 3 it moves in space. `gravity` is the
    acceleration towards −Z [m/s²], or in space a vector (x, y, z) of it. Raises InputError, with
    all problems, on construction.
    """

    _warnings: ClassVar[tuple[Problem, ...]] = ()  # no fields: they follow from the others
    _lacking: ClassVar[Mapping[str, Problem]] = MappingProxyType({})

    def __post_init__(self) -> None:
        problems = [
            Problem(f"{group}: expected elements by name, got {type(given).__name__}", remedy)
            for group in ("bodies", "joints", "points", "loads", "parameters", "tables")
            if not isinstance(given := getattr(self, group), Mapping)
            for remedy in [f"write {group}={{'name': …}}"]
        ]
        InputError.raise_for(problems)
        problems = [self._problem(finding) for finding in findings(self)]
        InputError.raise_for(problems)
        self.place_warnings(self._problem)

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """Findings on values that are allowed and seldom meant, such as negative damping."""
        return self._warnings

    @property
    def lacking(self) -> Mapping[str, Problem]:
        """Parameters without a value, each with the problem that it is where no value is given."""
        return self._lacking

    def place_warnings(
        self, place: Callable[[ModelFinding], Problem], more: Iterable[Problem] = ()
    ) -> Model:
        """This model; its warnings, and what it lacks, are where `place` puts them from now on.

        There may be `more` warnings, of the file that it was read from.
        """
        object.__setattr__(self, "_warnings", (*map(place, doubts(self)), *more))
        problems = {name: place(finding) for name, finding in lacking(self)}
        object.__setattr__(self, "_lacking", problems)
        object.__setattr__(self, "_place", place)
        return self

    def problems_with(self, values: Mapping[str, float]) -> list[Problem]:
        """Problems, by place in the file, where these parameters have other `values` [SI]."""
        return self.check_of(values)(values)

    def check_of(self, names: Collection[str]) -> Callable[[Mapping[str, float]], list[Problem]]:
        """`problems_with` for many sets of values of the same `names`."""
        own = [name for name in names if name in self.parameters]
        place: Callable[[ModelFinding], Problem] = vars(self)["_place"]
        check = findings_with(self, own)

        def problems(values: Mapping[str, float]) -> list[Problem]:
            given = {name: values[name] for name in own}
            found = [*check(given)] if given else []
            told = ", ".join(f"{name} = {value:g}" for name, value in given.items())
            placed = map(place, found)
            return [replace(p, message=f"{p.message} (with {told})") for p in placed]

        return problems

    def _problem(self, finding: ModelFinding) -> Problem:
        place = ".".join(map(str, finding.location))
        return Problem(f"{place}: {finding.message}", finding.remedy, self.name)

    def __repr__(self) -> str:
        return listing(
            f"Model {self.name!r}",
            parameters=self.parameters,
            tables=self.tables,
            bodies=self.bodies,
            joints=self.joints,
            points=self.points,
            loads=self.loads,
        )
