"""The runtime's shared library, found and loaded.

It is the one that ships, of `platforms`, if that is up to date; else `compiler` builds it once, by
this machine's compiler, into the user's cache.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

from m4e_fmi.runtime.compiler import (
    RUNTIME_FLAGS,
    CompilationError,
    cached_shared,
    runtime_sources,
)
from m4e_fmi.runtime.declarations import load
from m4e_fmi.runtime.platforms import packaged, this_platform


@functools.cache
def _found() -> tuple[ctypes.CDLL | None, str]:
    path = packaged("runtime", this_platform())
    try:
        if path is None:
            path = cached_shared("m4e_runtime", runtime_sources(), flags=RUNTIME_FLAGS)
        return load(path), str(path)
    except (CompilationError, OSError) as error:
        return None, str(error)


def library() -> ctypes.CDLL | None:
    """The loaded library, or None if it is missing and cannot be built."""
    return _found()[0]


def library_path() -> Path | None:
    """Path of the library; None without one."""
    found, detail = _found()
    return Path(detail) if found else None


def library_detail() -> str:
    """Path of the library, or the reason why it is missing."""
    return _found()[1]
