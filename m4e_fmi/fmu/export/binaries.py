"""PythonFMU's binaries, which every Python FMU carries, and the one defect mended in them.

The Linux binary of 0.7.0 releases its static Python state twice when it is unloaded: once by the
destructor of the static, once more in an unload handler that runs after it. The second release
decrements a word of memory that is free by then, perhaps somebody else's; processes end with
"corrupted double-linked list". The handler's jump becomes a return: the destructor suffices.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from m4e_fmi.errors import InputError

BINARIES = {"linux64": "libpythonfmu-export.so", "win64": "pythonfmu-export.dll"}


@dataclass(frozen=True)
class _Mend:
    """In the file of this SHA-256, the byte at `offset` becomes `byte`."""

    sha256: str
    offset: int
    byte: bytes


_MENDS = (
    _Mend(
        sha256="4be156a552c16f30eb4395805c59855d8d4086056d0f165442565f6c5fbac0c9",
        offset=0x16F34,  # `jmp finalizePythonInterpreter` of the unload handler
        byte=b"\xc3",  # `ret`
    ),
)


def binaries(identifier: str) -> dict[str, bytes]:
    """Name in the archive → content of the binary, for every platform there is one for."""
    paths = {platform: binary_path(platform) for platform in BINARIES}
    return {
        f"binaries/{platform}/{identifier}{path.suffix}": _mended(path.read_bytes())
        for platform, path in paths.items()
    }


def binary_path(platform: str) -> Path:
    """PythonFMU's binary for an FMI platform name such as "linux64"."""
    return pythonfmu_folder() / "resources" / "binaries" / platform / BINARIES[platform]


def pythonfmu_folder() -> Path:
    """Where PythonFMU is installed; InputError if it is not."""
    # not the importable module: once an FMU has run in this process, that is the FMU's own copy
    try:
        return Path(str(distribution("pythonfmu").locate_file("pythonfmu")))
    except PackageNotFoundError:
        remedy = "pip install pythonfmu==0.7.0"
        raise InputError.single("pythonfmu is not installed", remedy) from None


def _mended(content: bytes) -> bytes:
    digest = hashlib.sha256(content).hexdigest()
    for mend in _MENDS:
        if mend.sha256 == digest:
            return content[: mend.offset] + mend.byte + content[mend.offset + 1 :]
    return content
