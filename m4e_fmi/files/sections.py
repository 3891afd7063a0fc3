"""Sections of a file as pydantic models, and what may stand at a place within one."""

from __future__ import annotations

import types
import typing
from collections.abc import Iterable
from typing import Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import InitErrorDetails, PydanticCustomError

Location = tuple[str | int, ...]
"""Keys and indices (from 0) that lead to a value from the top of a file, or of a section."""


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
    """The error of what is rejected at a `place` below a section, for a ValidationError."""
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
    """Fields of a section by their keys; none of anything else."""
    if not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return {}
    return {field.alias or name: field for name, field in kind.model_fields.items()}


def tags(kind: object) -> set[str]:
    """Words by which a section is chosen from a union."""
    literals = (f.annotation for f in fields_of(kind).values() if f.is_required())
    return {tag for a in literals if typing.get_origin(a) is Literal for tag in typing.get_args(a)}


def tags_most_alike(kinds: Iterable[object], given: Iterable[str]) -> set[str]:
    """Tags of those sections that have most of the keys `given`."""
    shared = [(len(fields_of(kind).keys() & given), kind) for kind in kinds]
    most = max((count for count, _ in shared), default=0)
    return {tag for count, kind in shared if count == most for tag in tags(kind)}
