"""ZIP archives of others, FMUs and SSP packages: checked before anything is unpacked from them."""

from __future__ import annotations

import lzma
import struct
import sys
import zipfile
import zlib
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.file_names import is_device
from m4e_fmi.files.limits import (
    DEEPEST_FOLDER,
    LARGEST_RATIO,
    LARGEST_UNPACKED,
    LONGEST_NAME,
    MB,
    MOST_ENTRIES,
    SMALL,
)

ERRORS = (zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError, OSError,
          RuntimeError, ValueError)  # fmt: skip
"""Errors of Python for archives that are damaged, encrypted or packed by unknown methods."""
ENCRYPTED = 1
"""The bit of an entry's flags that says so."""
_DISTRUST = "do not use this file: no tool that exports FMUs or systems writes such an archive"


@contextmanager
def opened_archive(path: Path, kind: str, *, whole: bool) -> Generator[zipfile.ZipFile]:
    """The archive at `path`, to be read in the block; InputError if it cannot be, or see below.

    Its entries are checked: no name leads out of the folder that it is unpacked into, is too long
    or, on Windows, a device; none is there twice with different contents; none lies in another one.
    If the archive is unpacked as a `whole`, names do not differ in capitals only where that is the
    same to the file system. Number and sizes of entries are within `files.limits`. `kind` names the
    file in messages.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            alike = whole and sys.platform in ("win32", "darwin")
            for message, remedy in _wrong(archive, path.stat().st_size, alike=alike):
                raise InputError.single(f"the archive {message}", remedy, str(path))
            yield archive
    except ERRORS as error:
        remedy = f"copy or export the file again: it is truncated, or was never {kind}"
        raise InputError.single(
            f"not a readable ZIP archive: {error}", remedy, str(path)
        ) from error


def _wrong(archive: zipfile.ZipFile, size: int, *, alike: bool) -> Iterator[tuple[str, str]]:
    """Message and remedy for all that is wrong with an archive of that `size` [bytes].

    `alike`: names in capitals and without are the same.
    """
    infos = archive.infolist()
    if any(info.flag_bits & ENCRYPTED for info in infos):
        yield "is encrypted", "save it without a password, or ask for such a file"
    if len(infos) > MOST_ENTRIES:
        yield f"has {len(infos):,} entries; {MOST_ENTRIES:,} are taken at most", _DISTRUST
    for info in infos:
        yield from _wrong_name(info.filename)
    unpacked = sum(info.file_size for info in infos)
    packed = sum(info.compress_size for info in infos)
    if packed > size:
        yield "has entries that lie in one another", _DISTRUST
    if unpacked > LARGEST_UNPACKED or (unpacked > SMALL and unpacked > LARGEST_RATIO * packed):
        text = f"would unpack to {unpacked / MB:.0f} MB from {packed / MB:.2f} MB"
        most = f"at most {LARGEST_UNPACKED // MB} MB and {LARGEST_RATIO} times its size"
        yield f"{text}; {most} are taken", _DISTRUST
    yield from _twins(archive, alike=alike)


def _wrong_name(name: str) -> Iterator[tuple[str, str]]:
    parts = name.rstrip("/").split("/")
    if "\\" in name:
        remedy = "only / may stand between folders (FMI 2.0.4, section 2.3): pack it again"
        yield f"holds {name[:LONGEST_NAME]!r}, a path with backslashes", remedy
    if max(len(part.encode(errors="replace")) for part in parts) > LONGEST_NAME:
        yield f"holds a name of {len(name)} characters", "give its files shorter names"
    if len(parts) > DEEPEST_FOLDER:
        yield f"holds folders {len(parts)} levels deep; {DEEPEST_FOLDER} are taken", _DISTRUST
    if name.splitlines() != [name]:
        yield f"holds {name!r}, a name with an end of line in it", _DISTRUST
    if ":" in name or name.startswith("/") or ".." in parts:
        yield f"holds {name!r}, which leads out of its folder", _DISTRUST
    if sys.platform == "win32" and any(map(is_device, parts)):
        yield f"holds {name!r}, which Windows takes for a device", "rename it, and pack it again"


def _twins(archive: zipfile.ZipFile, *, alike: bool) -> Iterator[tuple[str, str]]:
    """Entries of one name that differ: nobody can tell which one is meant.

    Some tools pack a folder twice; entries that are the same do no harm.
    """
    known: dict[str, zipfile.ZipInfo] = {}
    remedy = "pack it again, with one of them"
    for info in archive.infolist():
        first = known.setdefault(info.filename.casefold() if alike else info.filename, info)
        if (first.file_size, first.CRC) != (info.file_size, info.CRC):
            names = " and ".join(map(repr, dict.fromkeys((first.filename, info.filename))))
            yield f"holds {names} twice, with different contents", remedy
    for folder in {"/".join(n.split("/")[:k]) for n in known for k in range(1, n.count("/") + 1)}:
        if folder in known:
            yield f"holds {known[folder].filename!r} as a file and as a folder", remedy
