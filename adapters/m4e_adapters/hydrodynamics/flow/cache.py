"""A cache of arrays on disk, by content: one file per key.

The folder is $M4E_FMI_CACHE, else the user's cache folder. Files appear whole or not at all, and
begin with a hash of their key and content: one that was damaged since is known as such. Processes
may read and write the same ones at one time.
"""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from m4e_fmi.errors import RunError
from m4e_fmi.files.writing import remove_leftovers, written

ENVIRONMENT = "M4E_FMI_CACHE"
_HASH = hashlib.sha256().digest_size


class _DamagedError(Exception):
    """A cached file is not what was stored; the message says which."""


def cache_folder() -> Path:
    """Where cached results are; not necessarily existing."""
    own = os.environ.get(ENVIRONMENT)
    if own:
        return Path(own) / "hydrodynamics"
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("m4e_fmi")) / "hydrodynamics"


def content_key(content: Mapping[str, ArrayLike]) -> str:
    """A name (hexadecimal) made of the bits of `content`: values in SI, scalar or arrays."""
    digest = hashlib.sha256()
    for name in sorted(content):
        value = np.asarray(content[name])
        head = f"{name}:{value.dtype.str}:{value.shape};"
        digest.update(head.encode() + np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()[:32]


@lru_cache(maxsize=512)
def _read(key: str, path: Path, _changed: int, _size: int) -> dict[str, np.ndarray]:
    """The arrays of a file, which cannot be written to: read once while it stays as it is."""
    stored = path.read_bytes()
    if stored[:_HASH] != _hash(key, stored[_HASH:]):
        raise _DamagedError(f"{path} is damaged")
    with np.load(io.BytesIO(stored[_HASH:]), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


def found(key: str, progress: Callable[[str], object]) -> dict[str, np.ndarray] | None:
    """The arrays stored under `key`, read-only, with the shape of then, in SI units, or None.

    `progress` is told of what is there but cannot be used.
    """
    path = _path(key)
    try:
        state = path.stat()
        return dict(_read(key, path, state.st_mtime_ns, state.st_size))
    except FileNotFoundError:
        return None
    except (_DamagedError, OSError) as error:
        progress(f"note: coefficients in the cache cannot be used and are computed again: {error}")
        return None


def keep(key: str, arrays: Mapping[str, np.ndarray], progress: Callable[[str], object]) -> None:
    """Keep `arrays` (any shape of each, SI) under `key`, or tell `progress` why that fails."""
    packed = io.BytesIO()
    np.savez_compressed(packed, allow_pickle=False, **arrays)
    content = packed.getvalue()
    path = _path(key)
    try:
        remove_leftovers(path.parent)
        with written(path) as part:
            part.write_bytes(_hash(key, content) + content)
    except RunError as error:
        progress(f"note: the coefficients are not cached: {error.message}")


def _path(key: str) -> Path:
    return cache_folder() / f"{key}.coefficients"


def _hash(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + content).digest()
