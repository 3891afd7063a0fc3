"""Sections of a file as pydantic models, and what may stand at a place within one.

`complaints` are messages for unknown keys ("did you mean"), wrong types and values in a section.
"""

from __future__ import annotations

import re
import types
import typing
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, NamedTuple, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from m4e_fmi.errors import suggestion
from m4e_fmi.units import TOO_LARGE, parse_quantity

Location = tuple[str | int, ...]
"""Keys and indices (from 0) that lead to a value from the top of a file, or of a section."""
_MOST_TAGS = 6
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
    "dataclass_type": "'key: value' lines",
    "model_attributes_type": "'key: value' lines",
    "tuple_type": "a list",
    "list_type": "a list",
}
_SECTIONS = ("model_type", "dataclass_type")
_SHAPES = ("dict_type", *_SECTIONS, "model_attributes_type", "tuple_type", "list_type")
"""Errors of a value as a whole that should be a list or a section."""
_OF_UNIONS = re.compile(r"(tuple|list|dict|union)\[")
_LIMITS = {
    "greater_than": "above",
    "greater_than_equal": "not below",
    "less_than": "below",
    "less_than_equal": "not above",
}
"""Words for the limits of numbers that are out of range."""


class Section(BaseModel):
    """Base of everything read from a file: unknown keys are errors, values do not change.

    Where a number is expected, true and false do not pass as 1 and 0.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False, defer_build=True)

    @model_validator(mode="before")
    @classmethod
    def _no_words_for_numbers(cls, data: object) -> object:
        if not isinstance(data, dict):
            return data
        found = {key: field.annotation for key, field in fields_of(cls).items()}
        return {
            key: _marked(value, found[key]) if key in found else value
            for key, value in data.items()
        }


SectionType = TypeVar("SectionType", bound=Section)


def rejected(message: str, remedy: str = "") -> PydanticCustomError:
    """The error a validator raises to reject a value with a remedy."""
    context = {"message": message, "remedy": remedy}
    return PydanticCustomError("rejected", "{message}", context)


def rejected_at(place: Location, message: str, remedy: str) -> InitErrorDetails:
    """The error of a value rejected at a `place` below a section, for a ValidationError."""
    return InitErrorDetails(type=rejected(message, remedy), loc=place, input=None)


class Word:
    """A true or false where a number is expected, which no validator takes for 1 or 0."""

    def __init__(self, value: bool) -> None:
        self.value = value

    def __repr__(self) -> str:
        return str(self.value).lower()


def _marked(value: object, annotation: object, location: Location = ()) -> object:
    """Data of type `annotation`, with true and false as a `Word` where numbers are expected.

    Sections within are left as they are: they do this themselves.
    """
    if not isinstance(value, (bool, dict, list)):
        return value
    kinds = types_at(annotation, location)
    if isinstance(value, bool):
        number = any(kind in (int, float) for kind in kinds)
        return Word(value) if number and not any(kind in (bool, Any) for kind in kinds) else value
    if any(fields_of(kind) for kind in kinds):
        return value
    if isinstance(value, list):
        return [_marked(member, annotation, (*location, k)) for k, member in enumerate(value)]
    return {key: _marked(member, annotation, (*location, key)) for key, member in value.items()}


def keys_at(annotation: object, location: Location) -> set[str]:
    """Keys that may stand at `location` below something of type `annotation`."""
    return {key for kind in types_at(annotation, location) for key in fields_of(kind)}


def types_at(annotation: object, location: Location) -> list[Any]:
    """Types of values that may stand at `location` below something of type `annotation`.

    Members of a union are listed one by one. In a location the tag of the chosen one comes first.
    """
    origin = typing.get_origin(annotation)
    arguments = typing.get_args(annotation)
    if origin is typing.Annotated:
        return types_at(arguments[0], location)
    if origin in (typing.Union, types.UnionType):
        chosen = [member for member in arguments if location and location[0] in tags(member)]
        if chosen:
            return types_at(chosen[0], location[1:])
        # of members without tags pydantic puts the name of the type there, of some nothing
        rests = [location, location[1:]] if location else [location]
        return [kind for member in arguments for rest in rests for kind in types_at(member, rest)]
    if not location:
        return [annotation]
    if fields_of(annotation):
        found = fields_of(annotation).get(str(location[0]))
        return types_at(found.annotation, location[1:]) if found else []
    if origin in (dict, list, tuple):
        return types_at(arguments[-1 if origin is dict else 0], location[1:])
    return []


def fields_of(kind: object) -> dict[str, FieldInfo]:
    """Fields of a section, or of a checked dataclass, by their keys; none of anything else."""
    found = getattr(kind, "__pydantic_fields__", {})
    return {field.alias or name: field for name, field in found.items()}


def tags(kind: object) -> set[str]:
    """Words by which a section is chosen from a union."""
    literals = (f.annotation for f in fields_of(kind).values() if f.is_required())
    return {tag for a in literals if typing.get_origin(a) is Literal for tag in typing.get_args(a)}


class Complaint(NamedTuple):
    """Text of an error; `location` is where to point, from the top of the section."""

    location: Location
    message: str
    remedy: str = ""


def complaints(
    section: type[Section], data: object, error: ValidationError, at: Location = ()
) -> Iterator[Complaint]:
    """A complaint about each error that validation of `data` as a `section` found.

    `at` is where the section stands in its file. A value that fits none of several plain types
    gets one complaint.
    """
    cases = _of_meant_types([_case(section, data, at, item) for item in error.errors()])
    plain: dict[Location, list[_Case]] = {}
    for case in cases:
        if case.type in _PLAIN_WORDS:
            plain.setdefault(case.location, []).append(case)
        else:
            yield _SENTENCES.get(case.type, _wrong_value)(case)
    for location, [first, *more] in plain.items():
        if not more:
            yield _wrong_value(first)
            continue
        *others, last = dict.fromkeys(_PLAIN_WORDS[case.type] for case in (first, *more))
        expected = f"{', '.join(others)} or {last}" if others else last
        where = ".".join(map(str, location))
        message = f"{where}: expected {expected}{_got(first.given)}"
        yield Complaint((*location, "@value"), message)


def _of_meant_types(cases: list[_Case]) -> list[_Case]:
    """The cases without those of types that were not meant, if a value may have several types.

    A wrong shape (a list for a section, or the reverse) is left out if another of the types has
    found an error within the value.
    """
    inner = [case for case in cases if case.type not in _SHAPES]

    def is_meant(case: _Case) -> bool:
        if case.type not in _SHAPES or not isinstance(case.given, (list, dict)) or not case.keys:
            return True
        *above, tag = case.keys
        depth = len(above)
        return not any(
            other.keys[:depth] == tuple(above) and other.keys[depth:] and other.keys[depth] != tag
            for other in inner
        )

    return [case for case in cases if is_meant(case)]


def _plain_keys(keys: Location) -> Location:
    """Keys without pydantic's own of unions, as ``tuple[float, float]``."""
    return tuple(k for k in keys if k == "[key]" or not _OF_UNIONS.match(str(k))) or keys


def found_at(data: Any, keys: Location) -> tuple[Location, Any]:
    """Location and value to which `keys` lead in nested data, and those that it lacks skipped.

    Pydantic adds keys of its own for unions and for keys of mappings.
    """
    location = list[str | int]()
    for key in keys:
        items: Any = dict(enumerate(data)) if isinstance(data, list) else data
        if isinstance(items, dict) and key in items:
            data = items[key]
            location.append(key)
    return tuple(location), data


class _Case(NamedTuple):
    """One error of pydantic's in `data`, which stand at `at` in their file."""

    section: type[Section]
    data: object
    at: Location
    type: str
    keys: Location
    location: Location
    given: object
    context: Mapping[str, object]
    text: str

    def types(self) -> list[type]:
        """Types of values that may stand there."""
        return types_at(self.section, self.keys)


def _case(section: type[Section], data: object, at: Location, error: ErrorDetails) -> _Case:
    keys, context = tuple(error["loc"]), error.get("ctx") or {}
    location, _ = found_at(data, keys)
    given, text = error.get("input"), error["msg"]
    return _Case(section, data, at, error["type"], keys, location, given, context, text)


def _unknown_key(case: _Case) -> Complaint:
    *above, key = case.keys
    known = keys_at(case.section, tuple(above))
    remedy = "remove it: it belongs to another choice than the one made here"
    if key not in known:
        remedy = suggestion(str(key), known, "keys")
    return Complaint(case.location, f"unknown key {str(key)!r}", remedy)


def _missing(case: _Case) -> Complaint:
    key = case.keys[-1]
    if not isinstance(key, int):
        return Complaint(case.location, f"missing key {str(key)!r}", f"add '{key}: …' here")
    _, there = found_at(case.data, case.keys)
    message = f"{case.keys[-2]}: too few entries, got {_length(there)}"
    kinds = types_at(case.section, case.keys[:-1])
    count = next((len(typing.get_args(k)) for k in kinds if typing.get_origin(k) is tuple), 0)
    return Complaint(case.location, message, f"write {count} entries" if count else "")


def _length(value: object) -> int:
    return len(value) if isinstance(value, (list, dict, tuple)) else 0


def _too_long(case: _Case) -> Complaint:
    most = case.context["max_length"]
    count = f"expected {most}, got {_length(case.given)}"
    remedy = f"write {most} entries; numbers have a decimal point, as 1.5"
    name = _plain_keys(case.keys)[-1]
    return Complaint(case.location, f"{name}: too many entries, {count}", remedy)


def _unknown_word(case: _Case) -> Complaint:
    words = str(case.context["expected"]).replace(" or ", ", ").replace("'", "").split(", ")
    given = str(case.given)
    quoted = isinstance(case.given, str) and given.isdecimal() and given in words
    remedy = f"write {given} without quotes" if quoted else suggestion(given, words)
    return Complaint((*case.location, "@value"), f"unknown {case.keys[-1]} {case.given!r}", remedy)


def _unknown_tag(case: _Case) -> Complaint:
    key, tag = str(case.context["discriminator"]).strip("'"), str(case.context["tag"])
    remedy = suggestion(tag, {tag for kind in case.types() for tag in tags(kind)})
    return Complaint((*case.location, key, "@value"), f"unknown {key} {tag!r}", remedy)


def _missing_tag(case: _Case) -> Complaint:
    key = str(case.context["discriminator"]).strip("'")
    known = sorted({tag for kind in case.types() for tag in tags(kind)})
    listed = f", one of {', '.join(known)}" if len(known) <= _MOST_TAGS else ""
    return Complaint(case.location, f"missing key {key!r}", f"add '{key}: …' here{listed}")


def _wrong_value(case: _Case) -> Complaint:
    if case.keys and case.keys[-1] == "[key]" and not isinstance(case.given, str):
        remedy = "use letters, digits and _, a letter first"
        return Complaint(case.location, f"{case.given!r} cannot be a name", remedy)
    text = case.text.removeprefix("Value error, ").removeprefix("Input should be ")
    text = _PLAIN_WORDS.get(case.type, text)
    expected = "expected " if text != case.text else ""
    where = ".".join(map(str, _plain_keys(case.keys) or case.at[-1:]))
    message = f"{where}: {expected}{text}{_got(case.given)}"
    return Complaint((*case.location, "@value"), message, _instead(case))


def _instead(case: _Case) -> str:
    """The value to write in place of one of a wrong type or size; "" if that is unknown."""
    kind, given = case.type, case.given
    if kind == "string_type" and isinstance(given, int | float):
        return f'write it in quotes: "{given}"'
    if kind in ("float_type", "float_parsing") and isinstance(given, str):
        return _number_instead(given)
    if kind in _LIMITS:
        (limit,) = case.context.values()
        return f"write a number {_LIMITS[kind]} {limit:g}"
    return ""


def _number_instead(text: str) -> str:
    """The number to write in place of a text."""
    try:
        given = parse_quantity(text)
    except ValueError:
        return "write a number without quotes; expressions stand where their value is used"
    if given.unit.text == "1":
        return "write a number without quotes"
    if not (number := given.si_number):
        return TOO_LARGE
    told = f"{text} is {number} {given.unit.si_text}"
    return f"write a number in the unit of the key, SI units where none stands beside it: {told}"


def _got(value: object) -> str:
    if isinstance(value, (list, dict)):
        return f", got {'a list' if isinstance(value, list) else 'a mapping'}"
    shown = isinstance(value, str | int | float | bool | Word | None)
    return f", got {value!r}" if shown else ""


_SENTENCES: dict[str, Callable[[_Case], Complaint]] = {
    "extra_forbidden": _unknown_key,
    "unexpected_keyword_argument": _unknown_key,
    "missing": _missing,
    "too_long": _too_long,
    "rejected": lambda case: Complaint(case.location, *map(str, case.context.values())),
    "literal_error": _unknown_word,
    "union_tag_invalid": _unknown_tag,
    "union_tag_not_found": _missing_tag,
}
"""Complaints by the type of pydantic's error; all others are about a wrong value."""
