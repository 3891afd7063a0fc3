"""A cache of arrays on disk, by content: one .npz file per key.

The folder is $M4E_FMI_CACHE, else the user's cache folder. Files are written beside their place
and renamed into it, so that a reader sees a whole file or none; one that cannot be read (its
checksums are checked) counts as not there.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

ENVIRONMENT = "M4E_FMI_CACHE"


def cache_folder() -> Path:
    """Where cached results are; not necessarily existing."""
    own = os.environ.get(ENVIRONMENT)
    if own:
        return Path(own) / "hydrodynamics"
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("m4e_fmi")) / "hydrodynamics"


def content_key(content: Mapping[str, Any]) -> str:
    """A name (hexadecimal) made of the bits of arrays, numbers and texts."""
    digest = hashlib.sha256()
    for name in sorted(content):
        value = np.asarray(content[name])
        head = f"{name}:{value.dtype.str}:{value.shape};"
        digest.update(head.encode() + np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()[:32]


def load(key: str) -> dict[str, np.ndarray] | None:
    """The arrays stored under `key`, None if there are none or the file is damaged."""
    try:
        with np.load(cache_folder() / f"{key}.npz", allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error):
        return None


def store(key: str, arrays: Mapping[str, np.ndarray]) -> None:
    """Keep `arrays` under `key`; OSError if the folder cannot be written."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=key, suffix=".tmp", dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, allow_pickle=False, **arrays)
        Path(name).replace(folder / f"{key}.npz")
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
