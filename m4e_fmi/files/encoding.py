"""Values as bytes, and back: dataclasses, arrays, containers, numbers.

They are pickled, but nothing in a file names code: only dataclasses of the requested package and
plain values are decoded; anything else is refused. Nothing else is checked here: a file needs a
checksum. An object that occurs twice is decoded once.
"""

from __future__ import annotations

import io
import pickle
import sys
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from pickle import UnpicklingError
from typing import TypeVar

import numpy as np

_KINDS = "biuf"
"""Kinds of NumPy's types that arrays may have."""
_Made = TypeVar("_Made")


def encode(value: object) -> bytes:
    """The bytes of a value; TypeError for one of a type that cannot be encoded."""
    file = io.BytesIO()
    _Pickler(file, pickle.HIGHEST_PROTOCOL).dump(value)
    return file.getvalue()


def decode(kind: type[_Made], content: bytes) -> _Made:
    """The value of a class, of what `encode` has made of it.

    UnpicklingError where it is of another class, or other code is named than dataclasses of the
    package of the class; other errors of pickle where `encode` has not made the content.
    """
    found = _Unpickler(io.BytesIO(content), kind.__module__.partition(".")[0]).load()
    if not isinstance(found, kind):
        raise UnpicklingError(f"it is {type(found).__name__}")
    return found


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: object) -> tuple[Callable[..., object], tuple[object, ...]]:
        """A call that makes the value again, by one of the functions below."""
        if isinstance(value, np.ndarray) and value.dtype.kind in _KINDS:
            return _array, (value.dtype.str, value.shape, value.tobytes())
        if isinstance(value, np.generic):
            return _plain, (value.item(),)
        if isinstance(value, Mapping):
            return _plain, (dict(value),)
        if is_dataclass(value) or any(value is one for one in _CALLED):
            return NotImplemented
        raise TypeError(f"there is no form for {type(value).__name__}")


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, package: str) -> None:
        super().__init__(file)
        self._package = package

    def find_class(self, module: str, name: str) -> object:
        """One of the functions that make values again, or a dataclass; UnpicklingError else."""
        found = getattr(sys.modules.get(module), name, None)
        if any(found is one for one in _CALLED):
            return found
        is_value = isinstance(found, type) and is_dataclass(found)
        if is_value and found.__module__.partition(".")[0] == self._package:
            return found
        raise UnpicklingError(f"{module}.{name} is no dataclass of {self._package}")


def _array(kind: str, shape: tuple[int, ...], data: bytes) -> np.ndarray:
    return np.frombuffer(data, kind).reshape(shape).copy()


def _plain(value: object) -> object:
    return value


_CALLED = (_array, _plain)
"""The functions that a file may call."""
