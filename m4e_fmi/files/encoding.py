"""Values as JSON and raw bytes, and back by type hints: dataclasses, arrays, containers, numbers.

Nothing in a file names code: what is decoded follows from the hints of the class that is asked for,
down to each field, and anything else is refused. A dataclass that is met twice is one object again.
Fields with the metadata LIVE are not in the file: they belong to the running process.
"""

from __future__ import annotations

import types
import typing
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import Field, fields, is_dataclass
from functools import cache
from typing import (
    Protocol,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    runtime_checkable,
)

import numpy as np

LIVE = {"live": True}
"""Metadata of a field that is not saved; `Decoder` is given its value."""
_AT, _TYPE, _SIZE, _SHAPE, _CLASS, _SAME = "at", "dtype", "size", "shape", "class", "same"
_KINDS = "biuf"
"""Kinds of NumPy's types that arrays may have."""
_Made = TypeVar("_Made")
Json = typing.Any
"""Values that `json` reads and writes."""
Hint = Json
"""A type hint: a class, or what `typing` makes of one."""
Decoded = Json
"""A value of the type that a hint asks for."""


@runtime_checkable
class Checked(Protocol):
    """A dataclass whose fields must fit together."""

    def check(self) -> None:
        """ValueError if they do not."""
        ...


class DamagedError(Exception):
    """Data are not what was written; the text says where."""


class Encoder:
    """Encodes values; their arrays and bytes are in `blobs`, one after the other.

    Each is encoded for itself: an object is known again within one value only.
    """

    def __init__(self) -> None:
        self.blobs: list[bytes | memoryview] = []
        self._size = 0
        self._known: dict[int, int] = {}
        self._kept: list[object] = []

    def encode(self, value: object) -> Json:
        """`value` as JSON; TypeError for a type that cannot be encoded."""
        self._known, self._kept = {}, []
        return self._encoded(value)

    def _encoded(self, value: object) -> Json:
        if isinstance(value, np.generic):
            value = value.item()
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, bytes):
            return {_AT: self._put(value), _SIZE: len(value)}
        if isinstance(value, np.ndarray):
            return self._array(value)
        if isinstance(value, Mapping):
            return [[self._encoded(k), self._encoded(v)] for k, v in value.items()]
        if isinstance(value, list | tuple | deque):
            return [self._encoded(one) for one in value]
        if isinstance(value, set | frozenset):
            return sorted((self._encoded(one) for one in value), key=repr)
        if is_dataclass(value) and not isinstance(value, type):
            return self._object(value)
        raise TypeError(f"there is no form for {type(value).__name__}")

    def _object(self, value: object) -> Json:
        if id(value) in self._known:
            return {_SAME: self._known[id(value)]}
        self._kept.append(value)  # so that no other object gets its id
        self._known[id(value)] = len(self._known)
        found = {f.name: self._encoded(getattr(value, f.name)) for f in _saved(type(value))}
        return {_CLASS: type(value).__name__, **found}

    def _array(self, value: np.ndarray) -> Json:
        if value.dtype.kind not in _KINDS:
            raise TypeError(f"there is no form for array of {value.dtype}")
        plain = np.ascontiguousarray(value, value.dtype.newbyteorder("<"))
        at = self._put(plain.reshape(-1).view(np.uint8).data)
        return {_AT: at, _TYPE: plain.dtype.str, _SHAPE: list(value.shape)}

    def _put(self, data: bytes | memoryview) -> int:
        at, self._size = self._size, self._size + len(data)
        self.blobs.append(data)
        return at


class Decoder:
    """Decodes what an `Encoder` has made, whose `blobs` follow one another here."""

    def __init__(self, blobs: memoryview) -> None:
        self._blobs = blobs
        self._live: Mapping[str, object] = {}
        self._known: list[object] = []

    def decode(self, kind: type[_Made], data: Json, live: Mapping[str, object]) -> _Made:
        """The value of a class; DamagedError if `data` is not one of it.

        `live` are the values of fields that are not in `data`, by their names.
        """
        self._live, self._known = live, []
        try:
            return self._decode(kind, data)
        except (TypeError, ValueError, KeyError, IndexError, OverflowError) as error:
            raise DamagedError(f"{kind.__name__}: {type(error).__name__}: {error}") from error
        except RecursionError:
            raise DamagedError(f"{kind.__name__}: nested too deeply") from None

    def _decode(self, hint: Hint, data: Json) -> Decoded:
        origin, arguments = get_origin(hint), get_args(hint)
        if origin in (Union, types.UnionType):
            return self._one_of(arguments, data)
        if origin is not None:
            return self._container(origin, arguments, data)
        if hint is np.ndarray:
            return self._array(data)
        if hint is bytes:
            return bytes(self._part(data[_AT], data[_SIZE]))
        if is_dataclass(hint):
            return self._object(hint, data)
        if hint is float and type(data) is int:
            return float(data)
        if hint in (bool, int, float, str, types.NoneType) and type(data) is hint:
            return data
        raise _not_a(hint, data)

    def _one_of(self, hints: Iterable[Hint], data: Json) -> Decoded:
        for hint in sorted(hints, key=lambda one: one is float):  # an integer is one first of all
            known = len(self._known)
            try:
                return self._decode(hint, data)
            except (DamagedError, TypeError, ValueError, KeyError):
                del self._known[known:]
        raise DamagedError(f"{_shown(data)} has none of the types that it may have")

    def _container(self, origin: Hint, arguments: tuple[Hint, ...], data: Json) -> Decoded:
        if not isinstance(data, list):
            raise _not_a(origin, data)
        if issubclass(origin, Mapping):
            key, value = arguments
            return {self._decode(key, k): self._decode(value, v) for k, v in data}
        if origin is tuple and arguments[-1] is not Ellipsis:
            pairs = zip(arguments, data, strict=True)
            return tuple(self._decode(hint, one) for hint, one in pairs)
        if origin in (list, tuple, set, frozenset, deque):
            return origin(self._decode(arguments[0], one) for one in data)
        raise TypeError(f"there is no form for {origin.__name__}")

    def _object(self, hint: Hint, data: Json) -> Decoded:
        if not isinstance(data, dict):
            raise _not_a(hint, data)
        if _SAME in data:
            found = self._known[_index(data[_SAME])]
            if not isinstance(found, hint):
                raise _not_a(hint, type(found).__name__)
            return found
        kind = _class(hint, data[_CLASS])
        place = len(self._known)
        self._known.append(None)
        hints, saved = _hints(kind), _saved(kind)
        if data.keys() != {_CLASS, *(f.name for f in saved)}:
            raise DamagedError(f"{kind.__name__} has other fields")
        given = {f.name: self._live[f.name] for f in fields(kind) if f.metadata.get("live")}
        found = kind(**given, **{f.name: self._decode(hints[f.name], data[f.name]) for f in saved})
        self._known[place] = found
        if isinstance(found, Checked):
            found.check()
        return found

    def _array(self, data: Json) -> np.ndarray:
        kind, shape = np.dtype(data[_TYPE]), tuple(_index(n) for n in data[_SHAPE])
        if kind.kind not in _KINDS or kind.str != data[_TYPE]:
            raise DamagedError(f"an array of {data[_TYPE]}")
        count = 1
        for length in shape:
            count *= length
        part = self._part(data[_AT], count * kind.itemsize)
        found = np.frombuffer(part, kind) if count else np.zeros(0, kind)
        return found.reshape(shape).astype(kind.newbyteorder("="))

    def _part(self, at: Json, size: Json) -> memoryview:
        first, length = _index(at), _index(size)
        if first + length > len(self._blobs):
            raise DamagedError(f"{length} bytes at {first}, of {len(self._blobs)}")
        return self._blobs[first : first + length]


def _index(data: Json) -> int:
    if type(data) is not int or data < 0:
        raise _not_a(int, data)
    return data


def _not_a(hint: Hint, data: Json) -> DamagedError:
    return DamagedError(f"{_shown(data)} is not of type {getattr(hint, '__name__', hint)}")


def _shown(data: Json) -> str:
    return type(data).__name__ if isinstance(data, list | dict) else repr(data)[:40]


@cache
def _saved(kind: type) -> tuple[Field[object], ...]:
    return tuple(f for f in fields(kind) if not f.metadata.get("live"))


@cache
def _hints(kind: type) -> dict[str, Hint]:
    return get_type_hints(kind)


def _class(hint: type, name: Json) -> type:
    """The class of a name among `hint` and the classes derived from it."""
    kinds = [hint]
    for kind in kinds:
        if kind.__name__ == name:
            return kind
        kinds += kind.__subclasses__()
    raise DamagedError(f"{_shown(name)} is not a {hint.__name__}")
