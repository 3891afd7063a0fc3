"""Plain data from the text of a YAML file, with the place of every key and value in it."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.composer import Composer, MaxDepthExceededError
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import ScalarEvent

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.limits import (
    DEEPEST_YAML,
    LARGEST_BITS,
    LONGEST_SCALAR,
    MOST_VALUES,
    MOST_WRITTEN,
)
from m4e_fmi.files.sections import Location
from m4e_fmi.shown import cleaned

_HALF = re.compile(r"[\ud800-\udfff]")
_LONGEST_SOURCE = 200
"""Characters of a line that are shown with a problem."""


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

    `path` is named in messages. Nobody changes what is returned: others may get it, too.
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
