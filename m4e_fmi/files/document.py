"""YAML documents whose every value knows its line and column.

`Document.load` reads a file; `Document.validate` turns (a part of) it into a pydantic model and
reports all problems of it at once. Models of this boundary derive from `Section`.
"""

from __future__ import annotations

import copy
import types
import typing
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from m4e_fmi.errors import YAML_SUFFIXES, InputError, Problem, suggestion
from m4e_fmi.files.file_kinds import YAML_FILE, as_path, check_suffix
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.units import parse_quantity

Location = tuple[str | int, ...]


class Section(BaseModel):
    """Base of everything read from a file: unknown keys are errors, values do not change.

    Where a number is expected, true and false do not pass as 1 and 0.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _no_words_for_numbers(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        found = {key: field.annotation for key, field in _fields(cls).items()}
        return {
            key: _marked(value, found[key]) if key in found else value
            for key, value in data.items()
        }


LARGEST_FILE = 10_000_000
"""Bytes that are read of one file."""
MOST_VALUES = 200_000
"""Keys and values of one file, each alias counted as often as it stands for something."""
_MOST_PRUNINGS = 20
_MOST_TAGS = 6
_LONGEST_SOURCE = 200
"""Characters of a line that are shown with a problem."""
_PLAIN_WORDS = {
    "string_type": "text",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "dict_type": "'key: value' lines",
    "model_type": "'key: value' lines",
    "model_attributes_type": "'key: value' lines",
    "tuple_type": "a list",
    "list_type": "a list",
}
_LIMITS = {
    "greater_than": "above",
    "greater_than_equal": "not below",
    "less_than": "below",
    "less_than_equal": "not above",
}
"""Errors of numbers out of range, and how their limits are told."""
SectionType = TypeVar("SectionType", bound=Section)


def rejected(message: str, remedy: str = "") -> PydanticCustomError:
    """The error a validator raises to reject a value with a remedy."""
    context = {"message": message, "remedy": remedy}
    return PydanticCustomError("rejected", "{message}", context)


class _Word:
    """A true or false where a number is expected, which no validator takes for 1 or 0."""

    def __init__(self, value: bool) -> None:
        self.value = value

    def __repr__(self) -> str:
        return str(self.value).lower()


def _marked(value: Any, annotation: Any, location: Location = ()) -> Any:
    """Data of type `annotation`, a true and false marked as a `_Word` where numbers are expected.

    Sections within are left as they are: they do this themselves.
    """
    if not isinstance(value, bool | dict | list):
        return value
    kinds = _types_at(annotation, location)
    if isinstance(value, bool):
        number = any(kind in (int, float) for kind in kinds)
        return _Word(value) if number and not any(kind in (bool, Any) for kind in kinds) else value
    if any(_fields(kind) for kind in kinds):
        return value
    if isinstance(value, list):
        return [_marked(member, annotation, (*location, k)) for k, member in enumerate(value)]
    return {key: _marked(member, annotation, (*location, key)) for key, member in value.items()}


class Document:
    """A YAML file: plain data, and where each piece of it stands."""

    def __init__(self, path: Path, text: str, data: Any, places: dict[Location, tuple]) -> None:
        self.path = path
        self.data = data
        self._lines = text.splitlines()
        self._places = places

    @classmethod
    def load(cls, path: str | Path) -> Document:
        """Read a YAML 1.2 file; InputError if it is missing, unreadable or no YAML mapping."""
        path = as_path(path)
        check_suffix(path, YAML_FILE)
        try:
            text = read_text(path, encoding="utf-8-sig", largest=LARGEST_FILE)
        except TooLongError as error:
            remedy = "put long tables into files of their own"
            raise InputError.single(str(error), remedy, str(path)) from None
        except FileNotFoundError:
            here = path.parent if path.parent.is_dir() else Path()
            names = [p.name for suffix in YAML_SUFFIXES for p in here.glob(f"*{suffix}")]
            raise InputError.single(
                "no such file", suggestion(path.name, names), str(path)
            ) from None
        except UnicodeDecodeError as error:
            message = f"cannot be read: byte {error.start + 1} is not valid UTF-8"
            raise InputError.single(
                message, "models, systems and parameter sets are text", str(path)
            ) from None
        except OSError as error:
            raise InputError.single(f"cannot be read: {error}", "", str(path)) from None
        return cls.parse(text, path)

    @classmethod
    def parse(cls, text: str, path: str | Path = "<text>") -> Document:
        """Like `load`, from text; `path` is what messages name."""
        path = Path(path)
        try:
            tree = YAML(typ="rt", pure=True).load(text)
        except DuplicateKeyError as error:
            detail = (error.problem or "").partition(" with value")[0]
            message = f"a key is given twice: {detail}"
            remedy = "rename or remove one of the two"
            raise InputError([_yaml_problem(path, text, error, message, remedy)]) from None
        except MarkedYAMLError as error:
            message = f"not valid YAML: {error.problem}"
            remedy = "check the indentation and the colons on this line and the one above"
            raise InputError([_yaml_problem(path, text, error, message, remedy)]) from None
        except YAMLError as error:
            raise InputError.single(f"not valid YAML: {error}", "", str(path)) from None
        except RecursionError:
            raise InputError.single("nested too deeply", "", str(path)) from None
        except TypeError:  # from the parser, for a key that is a mapping
            message, remedy = "a key is not a plain word", "check braces, brackets and colons"
            raise InputError.single(message, remedy, str(path)) from None
        except (ValueError, KeyError, IndexError, AttributeError, AssertionError) as error:
            # from the parser, for numbers, dates and tags that it cannot make anything of
            message = f"not valid YAML: {error}".splitlines()[0]
            raise InputError.single(
                message, "check numbers, dates and tags (!)", str(path)
            ) from None
        if not isinstance(tree, CommentedMap):
            message = "expected 'key: value' lines at the top level"
            raise InputError.single(message, "", str(path))
        places: dict[Location, tuple] = {}
        try:
            return cls(path, text, _plain(tree, (), places), places)
        except RecursionError:
            raise InputError.single("nested too deeply", "", str(path)) from None
        except _TooMany as error:
            remedy = "aliases (*) stand for all that is behind them: write fewer"
            message = f"stands for more than {MOST_VALUES} values"
            mark = (path, text, error.line, message, remedy)
            raise InputError([_problem_of_line(*mark)]) from None

    def validate(
        self,
        section: type[SectionType],
        *,
        at: Location = (),
        context: Mapping[str, Any] | None = None,
        drop: tuple[str, ...] = (),
    ) -> SectionType:
        """The part of the document at `at` as a `section`; InputError with all its problems.

        `context` reaches the validators; keys in `drop` are left out before validation.
        """
        data = self._at(at)
        if drop and isinstance(data, dict):
            data = {k: v for k, v in data.items() if k not in drop}
        try:
            return section.model_validate(data, context=dict(context or {}))
        except ValidationError as error:
            raise InputError(dict.fromkeys(self._all_translated(section, at, error))) from None

    def validate_as_far_as_possible(
        self, section: type[SectionType], *, required: Mapping[str, Any]
    ) -> tuple[SectionType | None, list[Problem]]:
        """The whole document as a `section` without the entries that are wrong, and what is wrong.

        So that later checks can look at the rest. An unknown key is left out; anything else that is
        wrong takes its entry (two levels from the top) with it. `required` gives values that stand
        in for required keys of the top level. None if nothing useful is left.
        """
        data = copy.deepcopy(self.data)
        problems: dict[Problem, None] = {}
        for _ in range(_MOST_PRUNINGS):
            try:
                return section.model_validate(data), list(problems)
            except ValidationError as error:
                wrong: dict[Location, None] = {}
                problems |= dict.fromkeys(self._all_translated(section, (), error))
                for item in error.errors():
                    location = self._in_data((), tuple(item["loc"]))
                    wrong[location if item["type"] == "extra_forbidden" else location[:2]] = None
                for location in reversed(wrong):  # backwards: the indices of a list stay right
                    _remove(data, location)
                data = {**required, **data}
        return None, list(problems)

    def valid_part(
        self, section: type[SectionType], *, at: Location = (), drop: tuple[str, ...] = ()
    ) -> SectionType | None:
        """The part of the document at `at` as a `section` without what is wrong in it.

        An unknown key is left out; a wrong value takes the section that it stands in with it. None
        if nothing useful is left. No problems are told: those of the rest may follow from what was
        left out.
        """
        data = copy.deepcopy(self._at(at))
        if not isinstance(data, dict):
            return None
        data = {k: v for k, v in data.items() if k not in drop}
        for _ in range(_MOST_PRUNINGS):
            try:
                return section.model_validate(data, context={})
            except ValidationError as error:
                wrong = {_wrong_part(data, item) for item in error.errors()}
                if () in wrong:
                    return None
                for location in sorted(wrong, key=str, reverse=True):
                    _remove(data, location)
        return None

    def _at(self, location: Location) -> Any:
        data: Any = self.data
        for key in location:
            data = data[key]
        return data

    def texts(self, at: Location) -> Iterator[tuple[Location, str]]:
        """All texts below `at`: the keys that lead to them from there, and what they are."""
        try:
            waiting: list[tuple[Location, Any]] = [((), self._at(at))]
        except (KeyError, IndexError, TypeError):  # the document does not have that part
            return
        while waiting:
            keys, value = waiting.pop()
            if isinstance(value, str):
                yield keys, value
            elif isinstance(value, dict | list):
                items = value.items() if isinstance(value, dict) else enumerate(value)
                waiting += (((*keys, key), member) for key, member in items)

    def _in_data(self, at: Location, relative: Location) -> Location:
        """`at` + `relative` without the parts that pydantic adds for unions and mapping keys."""
        node, result = self._at(at), list(at)
        for part in relative:
            items: Any = dict(enumerate(node)) if isinstance(node, list) else node
            if isinstance(items, dict) and part in items:
                node = items[part]
                result.append(part)
        return tuple(result)

    def problem(self, location: Location, message: str, remedy: str = "") -> Problem:
        """A problem at `location` (or at its nearest part that the file has)."""
        while location and location not in self._places:
            location = location[:-1]
        line, column, width = self._places.get(location, (0, 0, 0))
        source = self._lines[line - 1] if 0 < line <= len(self._lines) else ""
        source = source[: max(_LONGEST_SOURCE, column)]
        width = min(width, len(source) - column + 1)
        return Problem(message, remedy, str(self.path), line, column, source, width)

    def _all_translated(
        self, section: type[Section], at: Location, error: ValidationError
    ) -> Iterator[Problem]:
        """All that is wrong; where a value may be of several plain types, one problem of it."""
        plain: dict[Location, list] = {}
        for item in error.errors():
            if item["type"] in _PLAIN_WORDS:
                plain.setdefault(self._in_data(at, tuple(item["loc"])), []).append(item)
            else:
                yield self._translated(section, at, item)
        for location, items in plain.items():
            if len(items) == 1:
                yield self._translated(section, at, items[0])
                continue
            words = dict.fromkeys(_PLAIN_WORDS[item["type"]] for item in items)
            *others, last = words
            expected = f"{', '.join(others)} or {last}" if others else last
            where = ".".join(map(str, location[len(at) :]))
            message = f"{where}: expected {expected}{_got(items[0])}"
            yield self.problem((*location, "@value"), message)

    def _translated(self, section: type[Section], at: Location, item: Any) -> Problem:
        kind, relative = item["type"], tuple(item["loc"])
        context = item.get("ctx") or {}
        location = self._in_data(at, relative)
        if kind == "extra_forbidden":
            known = _keys_at(section, relative[:-1])
            remedy = suggestion(str(relative[-1]), known, "keys")
            return self.problem(location, f"unknown key {str(relative[-1])!r}", remedy)
        if kind == "missing" and isinstance(relative[-1], int):
            what = f"{relative[-2]}: too few entries, got {len(self._at(location))}"
            count = _count(_types_at(section, relative[:-1]))
            return self.problem(location, what, f"write {count} entries" if count else "")
        if kind == "too_long":
            count = f"expected {context['max_length']}, got {len(item['input'])}"
            remedy = f"write {context['max_length']} entries; numbers have a decimal point, as 1.5"
            return self.problem(location, f"{relative[-1]}: too many entries, {count}", remedy)
        if kind == "missing":
            what = f"missing key {str(relative[-1])!r}"
            return self.problem(location, what, f"add '{relative[-1]}: …' here")
        if kind == "rejected":
            return self.problem(location, context["message"], context["remedy"])
        if kind == "literal_error":
            words = context["expected"].replace(" or ", ", ").replace("'", "").split(", ")
            message = f"unknown {relative[-1]} {item['input']!r}"
            remedy = suggestion(str(item["input"]), words)
            return self.problem((*location, "@value"), message, remedy)
        if kind == "union_tag_invalid":
            tag = context["discriminator"].strip("'")
            known = _most_alike(_types_at(section, relative), item["input"])
            remedy = suggestion(str(context["tag"]), known)
            place = (*location, tag, "@value")
            return self.problem(place, f"unknown {tag} {context['tag']!r}", remedy)
        if kind == "union_tag_not_found":
            tag = context["discriminator"].strip("'")
            known = sorted({t for kind in _types_at(section, relative) for t in _tags(kind)})
            listed = f", one of {', '.join(known)}" if len(known) <= _MOST_TAGS else ""
            remedy = f"add '{tag}: …' here{listed}"
            return self.problem(location, f"missing key {tag!r}", remedy)
        if relative and relative[-1] == "[key]" and not isinstance(item["input"], str):
            message = f"{item['input']!r} cannot be a name"
            return self.problem(location, message, "use letters, digits and _, a letter first")
        remedy = ""
        if kind == "string_type" and isinstance(item["input"], int | float):
            remedy = f'write it in quotes: "{item["input"]}"'
        if kind in ("float_type", "float_parsing") and isinstance(item["input"], str):
            remedy = _number_instead(item["input"])
        if kind in _LIMITS:
            (limit,) = context.values()
            remedy = f"write a number {_LIMITS[kind]} {limit:g}"
        if kind == "dict_type" and isinstance(item["input"], list):
            remedy = f"give each entry a name: {relative[-1]}: {{name: {{…}}}}"
        if kind == "model_type":
            kinds = _types_at(section, relative)
            remedy = _example(str((*at, *relative)[-1]), kinds, item["input"])
        return self.problem((*location, "@value"), _pydantic_text(item), remedy)


def _wrong_part(data: Any, item: Any) -> Location:
    """What is to be left out of `data` for an error of pydantic's; () for all of it."""
    node, location = data, list[str | int]()
    for part in item["loc"]:  # without those that pydantic adds for unions and mapping keys
        items: Any = dict(enumerate(node)) if isinstance(node, list) else node
        if isinstance(items, dict) and part in items:
            node = items[part]
            location.append(part)
    if item["type"] == "extra_forbidden" or isinstance(node, dict | list):
        return tuple(location)
    return tuple(location[:-1] if len(location) > 1 else location)


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


def _pydantic_text(item: Any) -> str:
    text = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    text = _PLAIN_WORDS.get(item["type"], text)
    where = ".".join(str(part) for part in item["loc"])
    return f"{where}: {'expected ' if text != item['msg'] else ''}{text}{_got(item)}"


def _number_instead(text: str) -> str:
    """What to write in place of a text where a number stands."""
    try:
        given = parse_quantity(text)
    except ValueError:
        return "write a number without quotes; expressions stand where their value is used"
    if given.unit.text == "1":
        return "write a number without quotes"
    number = f"{given.value * given.unit.factor:.12g}"
    return f"write {number}: numbers here are in SI units ({text} is {number} {given.unit.si_text})"


def _count(kinds: Iterable[Any]) -> int:
    """Entries of a list of fixed length; 0 of any other."""
    return next((len(typing.get_args(k)) for k in kinds if typing.get_origin(k) is tuple), 0)


def _got(item: Any) -> str:
    value = item.get("input")
    if isinstance(value, list | dict):
        return f", got {'a list' if isinstance(value, list) else 'a mapping'}"
    shown = isinstance(value, str | int | float | bool | _Word | None)
    return f", got {value!r}" if shown else ""


class _TooMany(Exception):  # noqa: N818  caught where it is raised
    """The document stands for more values than are read; `line` of one, from 1."""

    def __init__(self, line: int) -> None:
        self.line = line


def _plain(node: Any, location: Location, places: dict[Location, tuple]) -> Any:
    """Plain Python data of a YAML tree; notes (line, column, width) of every key and value."""
    if len(places) > MOST_VALUES and isinstance(node, CommentedMap | CommentedSeq):
        raise _TooMany(node.lc.line + 1)
    if isinstance(node, CommentedMap):
        result: dict = {}
        for key, value in node.items():
            here = (*location, key if isinstance(key, int) else str(key))
            marks = (node.lc.data or {}).get(key)
            if marks is None:  # merged by <<: stands elsewhere
                places[here] = places.get(location, (0, 0, 0))
            else:
                line, column, value_line, value_column = marks
                places[here] = (line + 1, column + 1, len(str(key)))
                if not (value is None or isinstance(value, CommentedMap | CommentedSeq)):
                    places[(*here, "@value")] = (value_line + 1, value_column + 1, len(str(value)))
            result[here[-1]] = _plain(value, here, places)
        return result
    if isinstance(node, CommentedSeq):
        items = []
        for index, value in enumerate(node):
            line, column = node.lc.item(index) or (node.lc.line, node.lc.col)  # none after a tag
            width = 1 if isinstance(value, CommentedMap | CommentedSeq) else len(str(value))
            places[(*location, index)] = (line + 1, column + 1, width)
            items.append(_plain(value, (*location, index), places))
        return items
    for kind in (bool, int, float, str):
        if isinstance(node, kind):
            return kind(node)
    return None if node is None else str(node)


def _yaml_problem(
    path: Path, text: str, error: MarkedYAMLError, message: str, remedy: str
) -> Problem:
    mark = error.problem_mark or error.context_mark
    place = (mark.line + 1, mark.column + 1) if mark else (0, 0)
    return _problem_of_line(path, text, place[0], message.splitlines()[0], remedy, place[1])


def _problem_of_line(
    path: Path, text: str, line: int, message: str, remedy: str, column: int = 1
) -> Problem:
    lines = text.splitlines()
    source = lines[line - 1] if 0 < line <= len(lines) else ""
    source = source[: max(_LONGEST_SOURCE, column)]
    return Problem(message, remedy, str(path), line, column if line else 0, source)


def _keys_at(annotation: Any, location: Location) -> set[str]:
    """Names of the keys that may stand at `location` below something of type `annotation`."""
    return {key for kind in _types_at(annotation, location) for key in _fields(kind)}


def _types_at(annotation: Any, location: Location) -> list[Any]:
    """Types of what may stand at `location` below something of type `annotation`.

    Members of a union are listed one by one. In a location the tag of the chosen one comes first.
    """
    if hasattr(annotation, "__value__"):  # a `type X = …` alias
        return _types_at(annotation.__value__, location)
    origin = typing.get_origin(annotation)
    arguments = typing.get_args(annotation)
    if origin is typing.Annotated:
        return _types_at(arguments[0], location)
    if origin in (typing.Union, types.UnionType):
        chosen = [member for member in arguments if location and location[0] in _tags(member)]
        if chosen:
            return _types_at(chosen[0], location[1:])
        # of members without tags pydantic puts the name of the type there, of some nothing
        rests = [location, location[1:]] if location else [location]
        return [kind for member in arguments for rest in rests for kind in _types_at(member, rest)]
    if not location:
        return [annotation]
    if _fields(annotation):
        found = _fields(annotation).get(str(location[0]))
        return _types_at(found.annotation, location[1:]) if found else []
    if origin in (dict, list, tuple):
        return _types_at(arguments[-1 if origin is dict else 0], location[1:])
    return []


def _fields(kind: Any) -> dict[str, FieldInfo]:
    """The fields of a section by their keys; none of anything else."""
    if not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return {}
    return {field.alias or name: field for name, field in kind.model_fields.items()}


def _tags(kind: Any) -> set[str]:
    """The words by which a section is chosen from a union."""
    literals = (f.annotation for f in _fields(kind).values() if f.is_required())
    return {tag for a in literals if typing.get_origin(a) is Literal for tag in typing.get_args(a)}


def _most_alike(kinds: Iterable[Any], given: Mapping[str, Any]) -> set[str]:
    """Tags of those sections that have most of the keys `given`."""
    shared = [(len(_fields(kind).keys() & given.keys()), kind) for kind in kinds]
    most = max((count for count, _ in shared), default=0)
    return {tag for count, kind in shared if count == most for tag in _tags(kind)}


def _example(key: str, kinds: Iterable[Any], given: Any) -> str:
    """How to write the section under `key` where there is a `given` value instead."""
    needed = [name for kind in kinds for name, f in _fields(kind).items() if f.is_required()]
    first = given if isinstance(given, int | float) else "…"
    values = [first, *("…" for _ in needed[1:])]
    return f"write {key}: {{{', '.join(map('{}: {}'.format, needed, values))}}}" if needed else ""
