"""YAML documents whose every value knows its line and column.

`Document.load` reads a file; `Document.validate` turns (a part of) it into a pydantic model and
reports all problems of it at once. Models of this boundary derive from `Section`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from m4e_fmi.errors import YAML_SUFFIXES, InputError, Problem, suggestion
from m4e_fmi.files.file_kinds import YAML_FILE, as_path, check_named, check_suffix
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.files.limits import LARGEST_YAML
from m4e_fmi.files.section_errors import complaints, found_at
from m4e_fmi.files.sections import Location, Section, SectionType, rejected, rejected_at
from m4e_fmi.files.yaml_tree import Place, Places, problem_at, read_yaml
from m4e_fmi.shown import one_line

__all__ = ["Document", "Location", "Section", "SectionType", "rejected", "rejected_at"]

_MOST_PRUNINGS = 20


class Document:
    """A YAML file: plain data, and where each piece of it stands."""

    def __init__(self, path: Path, text: str, data: dict[Any, Any], places: Places) -> None:
        self.path = path
        self.data = data
        self._lines = text.splitlines()
        self._places = places

    @classmethod
    def load(cls, path: str | Path) -> Document:
        """Read a YAML 1.2 file; InputError if it is missing, unreadable or not a YAML mapping."""
        path = as_path(path)
        check_suffix(path, YAML_FILE)
        check_named(path, (*YAML_SUFFIXES, ".json"), "YAML file")
        try:
            text = read_text(path, encoding="utf-8-sig", largest=LARGEST_YAML)
        except TooLongError as error:
            reason, remedy = str(error), "put long tables into files of their own"
        except FileNotFoundError:
            here = path.parent if path.parent.is_dir() else Path()
            names = [p.name for suffix in YAML_SUFFIXES for p in here.glob(f"*{suffix}")]
            reason, remedy = "no such file", suggestion(path.name, names)
        except UnicodeDecodeError as error:
            reason = f"cannot be read: byte {error.start + 1} is not valid UTF-8"
            remedy = "models, systems and parameter sets are text: save it as UTF-8"
        except OSError as error:
            reason, remedy = f"cannot be read: {error}", ""
        else:
            return cls.parse(text, path)
        raise InputError.single(reason, remedy, str(path))

    @classmethod
    def parse(cls, text: str, path: str | Path = "<text>") -> Document:
        """Like `load`, from text; `path` is named in messages."""
        path = Path(path)
        data, places = read_yaml(text, path)
        if isinstance(name := data.get("name"), str):
            data = {**data, "name": one_line(name)}
        return cls(path, text, data, places)

    def with_data(self, data: dict[Any, Any]) -> Document:
        """The same document with other data, whose problems are placed where the old ones were."""
        result = copy.copy(self)
        result.data = data
        return result

    def validate(
        self,
        section: type[SectionType],
        *,
        at: Location = (),
        drop: tuple[str, ...] = (),
    ) -> SectionType:
        """The part of the document at `at` as a `section`; InputError with all its problems.

        Keys in `drop` are left out before validation.
        """
        data = self._at(at)
        if drop and isinstance(data, dict):
            data = {k: v for k, v in data.items() if k not in drop}
        try:
            return section.model_validate(data)
        except ValidationError as error:
            raise InputError(self._problems(section, at, error)) from None

    def validate_as_far_as_possible(
        self, section: type[SectionType], *, required: Mapping[str, object]
    ) -> tuple[SectionType | None, list[Problem]]:
        """The whole document as a `section` without its wrong parts, and all problems.

        So that later checks can look at the rest. An unknown key is left out; a wrong value takes
        the section that it stands in with it. `required` gives values that stand in for required
        keys of the top level. None if nothing useful is left.
        """
        data = copy.deepcopy(self.data)
        problems: list[Problem] = []
        for _ in range(_MOST_PRUNINGS):
            try:
                return section.model_validate(data), problems
            except ValidationError as error:
                problems = problems or self._problems(section, (), error)
                wrong = {_wrong_part(data, item) for item in error.errors()}
                if () in wrong and required.keys() <= data.keys():
                    break
                for location in sorted(wrong, key=str, reverse=True):
                    _remove(data, location)
                data = {**required, **data}
        return None, problems

    def texts(self, at: Location) -> Iterator[tuple[Location, str]]:
        """All texts below `at`, each with the keys that lead to it from there."""
        try:
            waiting: list[tuple[Location, object]] = [((), self._at(at))]
        except (KeyError, IndexError, TypeError):  # the document does not have that part
            return
        while waiting:
            keys, value = waiting.pop()
            if isinstance(value, str):
                yield keys, value
            elif isinstance(value, (dict, list)):
                items = value.items() if isinstance(value, dict) else enumerate(value)
                waiting += (((*keys, key), member) for key, member in items)

    def problem(self, location: Location, message: str, remedy: str = "") -> Problem:
        """A problem at `location` (or at its nearest part that the file has)."""
        while location and location not in self._places:
            location = location[:-1]
        place = self._places.get(location, Place())
        return problem_at(self.path, self._lines, place, message, remedy)

    def _at(self, location: Location) -> Any:
        data: Any = self.data
        for key in location:
            data = data[key]
        return data

    def _problems(
        self, section: type[Section], at: Location, error: ValidationError
    ) -> list[Problem]:
        """All problems that pydantic found, each once."""
        found = complaints(section, self._at(at), error, at)
        problems = (self.problem((*at, *keys), *texts) for keys, *texts in found)
        return list(dict.fromkeys(problems))


def _wrong_part(data: object, error: ErrorDetails) -> Location:
    """Location of what is to be left out of `data` for an error of pydantic's; () for all of it."""
    location, value = found_at(data, tuple(error["loc"]))
    if error["type"] == "extra_forbidden" or isinstance(value, (dict, list)):
        return location
    return location[:-1] if len(location) > 1 else location


def _remove(data: Any, location: Location) -> None:
    """Take the entry at `location` out of nested data, if it is still there."""
    *parents, last = location or ("",)
    for key in parents:
        try:
            data = data[key]
        except (KeyError, IndexError, TypeError):
            return
    if isinstance(data, dict):
        data.pop(last, None)
    elif isinstance(data, list) and isinstance(last, int) and last < len(data):
        del data[last]
