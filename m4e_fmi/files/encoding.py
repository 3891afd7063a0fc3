"""Values as bytes, and back: dataclasses, arrays, containers, numbers.

They are pickled, but nothing in a file names code: only dataclasses of the requested package,
others derived from these, and plain values are decoded; anything else is refused. The types
of their fields are checked. An object that occurs twice is decoded once. Fields with the
metadata LIVE are not in the file: they belong to the running process.
"""

from __future__ import annotations

import io
import pickle
import sys
from collections import deque
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import GenericAlias
from typing import Any, Protocol, TypeVar, cast, get_type_hints, runtime_checkable

import numpy as np
from pydantic import ConfigDict, TypeAdapter

LIVE = {"live": True}
"""Metadata of a field that is not saved; `Decoder` is given its value."""
_KINDS = "biuf"
"""Kinds of NumPy's types that arrays may have."""
_Made = TypeVar("_Made")
_PLACE = TypeAdapter(tuple[int, int])
_ERRORS = (pickle.UnpicklingError, ValueError, TypeError, LookupError, AttributeError, EOFError,
           ImportError, OverflowError, MemoryError, RecursionError)  # fmt: skip
"""Errors of Python for a pickle that is damaged."""


@runtime_checkable
class Checked(Protocol):
    """A dataclass whose fields must fit together."""

    def check(self) -> None:
        """ValueError if they do not."""
        ...


class DamagedError(Exception):
    """Data are not what was written; the text says where."""


class Encoder:
    """Encodes values one by one; an object is known again within one value only."""

    def __init__(self) -> None:
        self.blobs: list[bytes] = []
        """The values, one after the other."""

    def encode(self, value: object) -> tuple[int, int]:
        """The place and size of `value` in `blobs`; TypeError for a type that cannot be encoded."""
        file = io.BytesIO()
        _Pickler(file, pickle.HIGHEST_PROTOCOL).dump(value)
        place = sum(map(len, self.blobs))
        self.blobs.append(file.getvalue())
        return place, len(self.blobs[-1])


class Decoder:
    """Decodes what an `Encoder` has made, whose `blobs` follow one another here."""

    def __init__(self, blobs: memoryview) -> None:
        self._blobs = blobs

    def decode(self, kind: type[_Made], data: object, live: Mapping[str, object]) -> _Made:
        """The value of a class at a place and size; DamagedError if it is not one of it.

        `live` are the values of fields that are not in the file, by their names.
        """
        try:
            place, size = _PLACE.validate_python(data)
            file = io.BytesIO(self._blobs[place : place + size])
            found = _Unpickler(file, kind.__module__.partition(".")[0], live).load()
        except _ERRORS as error:
            raise DamagedError(f"{kind.__name__}: {type(error).__name__}: {error}") from error
        if not isinstance(found, kind):
            raise DamagedError(f"{type(found).__name__} is not of type {kind.__name__}")
        return found


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: object) -> Any:
        """A call that makes the value again, by one of the functions below."""
        if isinstance(value, np.ndarray) and value.dtype.kind in _KINDS:
            return _array, (value.dtype.str, value.shape, value.tobytes())
        if isinstance(value, np.generic):
            return _plain, (value.item(),)
        if isinstance(value, Mapping):
            return _plain, (dict(value),)
        if is_dataclass(value) and not isinstance(value, type):
            live = [f.name for f in fields(value) if f.metadata.get("live")]
            rest = {f.name: getattr(value, f.name) for f in fields(value) if f.name not in live}
            return _object, (type(value), rest, live)
        if isinstance(value, deque) or is_dataclass(value) or any(value is one for one in _CALLED):
            return NotImplemented
        raise TypeError(f"there is no form for {type(value).__name__}")


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, package: str, live: Mapping[str, object]) -> None:
        super().__init__(file)
        self._package, self._live = package, live

    def find_class(self, module: str, name: str) -> object:
        """One of the functions that make values again, or a dataclass; UnpicklingError else."""
        for one in _CALLED:
            if (one.__module__, one.__name__) == (module, name):
                return self._object if one is _object else one
        found = getattr(sys.modules.get(module), name, None)
        if isinstance(found, type) and is_dataclass(found):
            packages = {base.__module__.partition(".")[0] for base in found.__mro__}
            if self._package in packages:
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is no dataclass of {self._package}")

    def _object(self, kind: type, values: dict[str, object], live: list[str]) -> object:
        _types(kind).validate_python(tuple(values.values()))
        found = kind(**values, **{name: self._live[name] for name in live})
        if isinstance(found, Checked):
            found.check()
        return found


def _array(kind: str, shape: tuple[int, ...], data: bytes) -> np.ndarray:
    if np.dtype(kind).kind not in _KINDS:
        raise TypeError(f"an array of {kind}")
    return np.frombuffer(data, kind).reshape(shape).copy()


def _plain(value: object) -> object:
    return value


def _object(*_: object) -> None:
    """In a file it stands for `_Unpickler._object`."""


_CALLED = (_array, _plain, _object, deque)
"""The functions that a file may call."""


@cache
def _types(kind: type) -> TypeAdapter[object]:
    """Checks the values of all fields but those that are LIVE, in their order."""
    hints = get_type_hints(kind)
    saved = tuple(hints[f.name] for f in fields(kind) if not f.metadata.get("live"))
    config = ConfigDict(strict=True, arbitrary_types_allowed=True)
    return TypeAdapter(cast("type", GenericAlias(tuple, saved)), config=config)
