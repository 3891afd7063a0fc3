"""The runtime's shared library: found in the package, or built once into the user's cache."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

from m4e_fmi.runtime.compiler import SOURCES, SUFFIX, CompilationError, cached_shared
from m4e_fmi.runtime.declarations import load

PACKAGED = Path(__file__).with_name(f"_m4e{SUFFIX}")


@functools.cache
def _found() -> tuple[ctypes.CDLL | None, str]:
    try:
        if PACKAGED.exists():
            return load(PACKAGED), str(PACKAGED)
        path = cached_shared("m4e_runtime", sorted(SOURCES.glob("*.c")))
        return load(path), str(path)
    except (CompilationError, OSError) as error:
        return None, str(error)


def library() -> ctypes.CDLL | None:
    """The loaded library, or None where there is none and none can be built."""
    return _found()[0]


def library_path() -> Path | None:
    """Where the library is; None where there is none."""
    found, detail = _found()
    return Path(detail) if found else None


def library_detail() -> str:
    """Where the library is, or why there is none."""
    return _found()[1]
