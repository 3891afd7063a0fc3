"""YAML documents whose every value knows its line and column.

`Document.load` reads a file; `Document.validate` turns (a part of) it into a pydantic model and
reports all problems of it at once. Models of this boundary derive from `Section`.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.composer import Composer, MaxDepthExceededError
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import ScalarEvent

from m4e_fmi.errors import YAML_SUFFIXES, InputError, Problem, missing_file
from m4e_fmi.files.file_kinds import YAML_FILE, as_path, check_named, check_suffix
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.files.limits import (
    DEEPEST_YAML,
    LARGEST_BITS,
    LARGEST_YAML,
    LONGEST_SCALAR,
    MOST_VALUES,
    MOST_WRITTEN,
)
from m4e_fmi.files.sections import (
    Location,
    Section,
    SectionType,
    complaints,
    rejected,
    rejected_at,
)
from m4e_fmi.shown import cleaned, one_line

_HALF = re.compile(r"[\ud800-\udfff]")
_LONGEST_SOURCE = 200
"""Characters of a line that are shown with a problem."""
__all__ = ["Document", "Location", "Section", "SectionType", "rejected", "rejected_at"]


class Place(NamedTuple):
    """Line and column, from 1 (0: unknown), and the width of what stands there [characters]."""

    line: int = 0
    column: int = 0
    width: int = 0


Places = dict[Location, Place]
"""Places of the keys of a file by their location; of scalar values at (\\*location, "@value")."""


@lru_cache(maxsize=2)  # commands ask what kind of file it is before they read it
def read_yaml(text: str, path: Path) -> tuple[dict[str | int, object], Places]:
    """Data and places of a YAML 1.2 text; InputError if it is not a YAML mapping.

    `path` is named in messages. Callers must not change the returned objects: they are shared.
    """
    places: Places = {}
    try:
        return _mapping(_tree(text, path), (), places), places
    except RecursionError:
        raise InputError.single("nested too deeply", "", str(path)) from None
    except _BeyondError as error:
        place = Place(error.line, 1, 1)
        problem = problem_at(path, text.splitlines(), place, error.message, error.remedy)
        raise InputError([problem]) from None


def problem_at(path: Path, lines: list[str], place: Place, message: str, remedy: str) -> Problem:
    """A problem at a place of a file with these lines, of which it shows one."""
    line, column, width = place
    source = lines[line - 1] if 0 < line <= len(lines) else ""
    source = source[: max(_LONGEST_SOURCE, column)]
    width = min(width, len(source) - column + 1)
    return Problem(message, remedy, str(path), line, column, source, width)


def _tree(text: str, path: Path) -> CommentedMap:
    """The parser's tree; its errors become InputError, RecursionError stays."""
    try:
        yaml = YAML(typ="rt", pure=True)
        yaml.max_depth, yaml.Composer = DEEPEST_YAML, _CountingComposer
        tree = yaml.load(text)
    except DuplicateKeyError as error:
        detail = (error.problem or "").partition(" with value")[0]
        message, remedy = f"a key is given twice: {detail}", "rename or remove one of the two"
        raise _marked_error(path, text, error, message, remedy) from None
    except MaxDepthExceededError as error:
        message = f"nested too deeply: more than {DEEPEST_YAML} levels"
        raise _marked_error(path, text, error, message, "") from None
    except MarkedYAMLError as error:
        remedy = "check the indentation and the colons on this line and the one above"
        raise _marked_error(path, text, error, f"not valid YAML: {error.problem}", remedy) from None
    except YAMLError as error:
        raise InputError.single(f"not valid YAML: {error}", "", str(path)) from None
    except TypeError:  # from the parser, for a key that is a mapping
        message, remedy = "a key is not a plain word", "check braces, brackets and colons"
        raise InputError.single(message, remedy, str(path)) from None
    except (KeyError, IndexError, AttributeError, AssertionError):  # from within the parser
        message = "not valid YAML: an alias, a merge, a number, a date or a tag cannot be read"
        remedy = "check '*', '<<', numbers, dates and tags (!)"
        raise InputError.single(message, remedy, str(path)) from None
    except ValueError as error:  # from the parser, for numbers and dates
        what = "a number is too long" if "digits" in str(error) else str(error).splitlines()[0]
        message = f"not valid YAML: {what}"
        raise InputError.single(message, "check numbers, dates and tags (!)", str(path)) from None
    if not isinstance(tree, CommentedMap):
        message = "expected 'key: value' lines at the top level"
        raise InputError.single(message, "", str(path))
    return tree


def _marked_error(
    path: Path, text: str, error: MarkedYAMLError, message: str, remedy: str
) -> InputError:
    mark = error.problem_mark or error.context_mark
    place = Place(mark.line + 1, mark.column + 1, 1) if mark else Place(width=1)
    message = message.splitlines()[0]
    return InputError([problem_at(path, text.splitlines(), place, message, remedy)])


class _BeyondError(Exception):
    """The document is beyond a limit at a line, from 1."""

    def __init__(self, line: int, message: str, remedy: str = "") -> None:
        self.line, self.message, self.remedy = line, message, remedy


class _CountingComposer(Composer):
    """Stops at the first value beyond the limits, before what follows takes time or memory."""

    _count = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """The node that the parser is at."""
        event = self.parser.peek_event()
        line = event.start_mark.line + 1
        self._count += 1
        if self._count > MOST_WRITTEN:
            remedy = "put long tables into files of their own"
            raise _BeyondError(line, f"has more than {MOST_WRITTEN} keys and values", remedy)
        if isinstance(event, ScalarEvent) and len(event.value) > LONGEST_SCALAR:
            message = f"a key or value of {len(event.value)} characters"
            raise _BeyondError(line, message, f"{LONGEST_SCALAR} are taken at most")
        return super().compose_node(parent, index)


def _plain(node: object, location: Location, places: Places) -> object:
    """Plain Python data of a YAML tree; notes the place of every key and value."""
    if isinstance(node, CommentedMap | CommentedSeq):
        if len(places) > MOST_VALUES:
            remedy = "aliases (*) stand for all that is behind them: write fewer"
            message = f"stands for more than {MOST_VALUES} values"
            raise _BeyondError(node.lc.line + 1, message, remedy)
        here = _mapping if isinstance(node, CommentedMap) else _sequence
        return here(node, location, places)
    if isinstance(node, str):
        return cleaned(node)  # so that it does no harm wherever it is shown
    for kind in (bool, int, float):
        if isinstance(node, kind):
            return kind(node)
    return None if node is None else str(node)


def _check_size(values: tuple[object, ...], node: CommentedMap | CommentedSeq) -> None:
    """_BeyondError for a whole number among `values` that no float holds."""
    for value in values:
        if isinstance(value, int) and value.bit_length() > LARGEST_BITS:
            raise _BeyondError(node.lc.line + 1, "has a number that is too large", "")


def _mapping(node: CommentedMap, location: Location, places: Places) -> dict[str | int, object]:
    result: dict[str | int, object] = {}
    for key, value in node.items():
        _check_size((key, value), node)
        name = key if isinstance(key, int) else str(key)
        if half := _HALF.search(str(name)):
            message = f"a key has \\u{ord(half[0]):04x}, half a character"
            raise _BeyondError(node.lc.line + 1, message, "write the character itself, in UTF-8")
        here = (*location, name)
        marks = (node.lc.data or {}).get(key)
        if marks is None:  # merged by <<: stands elsewhere
            places[here] = places.get(location, Place())
        else:
            line, column, value_line, value_column = marks
            places[here] = Place(line + 1, column + 1, len(str(key)))
            if not (value is None or isinstance(value, CommentedMap | CommentedSeq)):
                width = len(str(value))
                places[(*here, "@value")] = Place(value_line + 1, value_column + 1, width)
        result[name] = _plain(value, here, places)
    return result


def _sequence(node: CommentedSeq, location: Location, places: Places) -> list[object]:
    items: list[object] = []
    for index, value in enumerate(node):
        _check_size((value,), node)
        line, column = node.lc.item(index) or (node.lc.line, node.lc.col)  # none after a tag
        width = 1 if isinstance(value, CommentedMap | CommentedSeq) else len(str(value))
        places[(*location, index)] = Place(line + 1, column + 1, width)
        items.append(_plain(value, (*location, index), places))
    return items


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
            reason, remedy = "no such file", missing_file(path)[1]
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
