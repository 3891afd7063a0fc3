"""The runtime's functions for calls in workers, and the beginning of the memory they share."""

from __future__ import annotations

import ctypes
import functools
from ctypes import c_char_p, c_int, c_int32, c_size_t, c_uint32, c_void_p
from itertools import count

from m4e_fmi.runtime.library import library_path

PREFIX = "m4e_remote_"


class Channel(ctypes.Structure):
    """The fields that `m4e_channel` of remote.h begins with."""

    _fields_ = [
        ("lost", c_int32),
        ("calls", c_uint32),
        ("busy", c_int32),
        ("present", c_uint32),
        ("late_function", c_uint32),
        ("late_status", c_int32),
    ]
    calls: int
    busy: int
    present: int
    late_function: int
    late_status: int


@functools.cache
def remote_library() -> ctypes.CDLL | None:
    """The runtime, loaded for its functions of remote.h; None where there is no runtime."""
    path = library_path()
    if path is None:
        return None
    found = ctypes.CDLL(str(path))
    for name, result, *arguments in (
        ("new", c_void_p, c_void_p),
        ("free", None, c_void_p),
        ("use", None, c_void_p),
        ("await", c_int, c_void_p),
        ("flush", c_int, c_void_p),
        ("end", c_int, c_void_p),
        ("give_up", None, c_void_p),
        ("text", c_char_p, c_void_p),
        ("name", c_char_p, c_uint32),
        ("size", c_size_t),
    ):
        function = getattr(found, PREFIX + name)
        function.restype, function.argtypes = result, arguments
    return found


@functools.cache
def function_names() -> tuple[str, ...]:
    """Names of the functions of FMI that can be called in workers, by their numbers."""
    found = remote_library()
    assert found is not None
    names: list[str] = []
    for number in count():
        name = found.m4e_remote_name(number)
        if name is None:
            return tuple(names)
        names.append(name.decode("ascii"))
    raise AssertionError
