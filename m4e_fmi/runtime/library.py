"""The runtime's shared library, found and loaded.

It is the one that ships, of `platforms`, if that is up to date; else `compiler` builds it once, by
this machine's compiler, into the user's cache.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

from m4e_fmi.errors import RunError
from m4e_fmi.runtime.compiler import (
    RUNTIME_FLAGS,
    CompilationError,
    cached_shared,
    runtime_sources,
)
from m4e_fmi.runtime.declarations import load
from m4e_fmi.runtime.platforms import packaged, this_platform


@functools.cache
def library_path() -> Path:
    """Path of the library; RunError if it is missing and cannot be built."""
    path = packaged("runtime", this_platform())
    try:
        return path or cached_shared("m4e_runtime", runtime_sources(), flags=RUNTIME_FLAGS)
    except CompilationError as error:
        raise _missing(error) from error


@functools.cache
def library() -> ctypes.CDLL:
    """The loaded library; RunError if it is missing and cannot be built."""
    try:
        return load(library_path())
    except OSError as error:
        raise _missing(error) from error


def _missing(error: Exception) -> RunError:
    message = f"the C library, which runs programs and FMUs, cannot be had: {error}"
    return RunError(message, "install a C compiler, or `pip install ziglang`")
