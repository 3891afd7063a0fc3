"""The file of a checkpoint: a line, its checksum, JSON, and the bytes of its parts.

::

    m4e_fmi checkpoint 1\\n
    SHA-256 of all that follows, 64 hexadecimal digits\\n
    number of bytes of the JSON, in decimal digits\\n
    JSON (UTF-8), with the places of the parts among
    their bytes (see `encoding`)

A file appears whole or not at all, and one that is cut off or altered is refused. The checksum
tells damage, and no forgery: the states in it go to the FMUs, so that a checkpoint is to be trusted
as they are.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

from m4e_fmi.errors import InputError
from m4e_fmi.files.encoding import DamagedError, Decoder, Encoder
from m4e_fmi.files.files_read import opened
from m4e_fmi.files.limits import LARGEST_CHECKPOINT
from m4e_fmi.files.writing import written

SUFFIX = ".checkpoint"
MAGIC = b"m4e_fmi checkpoint "
VERSION = 5
"""The number of the form; files of other numbers are refused."""
_REMEDY = "take another checkpoint, or run again from the start"
_Made = TypeVar("_Made")


def checkpoint_of(results: str | Path) -> Path:
    """The checkpoint beside a results file."""
    path = Path(results)
    return path.with_name(path.name + SUFFIX)


def results_of(checkpoint: Path) -> Path:
    """The results file beside a checkpoint; InputError if that is not named as one."""
    if checkpoint.suffix != SUFFIX:
        message = f"is not named as a checkpoint, RESULTS{SUFFIX}"
        raise InputError.single(message, "give the checkpoint beside its results", str(checkpoint))
    return checkpoint.with_suffix("")


@dataclass(frozen=True)
class CheckpointParts:
    """The parts of a checkpoint at `path`, by name."""

    path: Path
    _data: dict[str, object]
    _decoder: Decoder

    def part(
        self, name: str, kind: type[_Made], live: Mapping[str, object] = MappingProxyType({})
    ) -> _Made:
        """The dataclass of that name; `live` are the fields that a file does not have.

        InputError if it is not one of this kind.
        """
        try:
            return self._decoder.decode(kind, self._data.get(name), live)
        except DamagedError as error:
            raise InputError.single(f"is damaged: {error}", _REMEDY, str(self.path)) from error


def write_checkpoint(path: Path, parts: Mapping[str, object]) -> None:
    """Write dataclasses to `path`, in place of what is there once they are on the disk.

    RunError if that fails; TypeError if they hold what cannot be saved.
    """
    encoder = Encoder()
    data = {name: encoder.encode(part) for name, part in parts.items()}
    text = json.dumps(data, separators=(",", ":")).encode()
    content = (b"%d\n" % len(text), text, *encoder.blobs)
    digest = hashlib.sha256()
    for one in content:
        digest.update(one)
    with written(path) as place, place.open("wb") as file:
        file.write(MAGIC + b"%d\n" % VERSION)
        file.write(digest.hexdigest().encode() + b"\n")
        file.writelines(content)
        file.flush()
        os.fsync(file.fileno())


def read_checkpoint(path: Path) -> CheckpointParts:
    """The parts of the checkpoint at `path`.

    InputError if there is no such file, if it is cut off, altered or too large, or of a form that
    is not read here.
    """
    content = _content(path)
    head, _, rest = content.partition(b"\n")
    size = int(head) if head.isdigit() and len(head) < len(str(LARGEST_CHECKPOINT)) else -1
    try:
        if not 0 <= size <= len(rest):
            raise DamagedError(f"{size} bytes of JSON")
        data = json.loads(rest[:size])
        if not isinstance(data, dict):
            raise DamagedError("it has no parts")
    except (DamagedError, ValueError, RecursionError) as error:
        raise InputError.single(f"is damaged: {error}", _REMEDY, str(path)) from error
    return CheckpointParts(path, data, Decoder(memoryview(rest)[size:]))


def _content(path: Path) -> bytes:
    """All that is behind the checksum of a file, which is right; or InputError."""
    try:
        if path.stat().st_size > LARGEST_CHECKPOINT:
            message = f"is larger than {LARGEST_CHECKPOINT} bytes, which no checkpoint is"
            raise InputError.single(message, _REMEDY, str(path))
        with opened(path) as file:
            magic, digest = file.readline(len(MAGIC) + 20), file.readline(65)
            if not magic.startswith(MAGIC):
                raise InputError.single("is not a checkpoint", _REMEDY, str(path))
            if magic != MAGIC + b"%d\n" % VERSION:
                version = magic.removeprefix(MAGIC).strip().decode("ascii", "replace")
                message = f"is a checkpoint of form {version[:20]}; only {VERSION} is read here"
                raise InputError.single(message, _REMEDY, str(path))
            content = file.read(LARGEST_CHECKPOINT)
    except OSError as error:
        why = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
        message = f"the checkpoint cannot be read: {why}"
        raise InputError.single(message, _REMEDY, str(path)) from None
    if hashlib.sha256(content).hexdigest().encode() + b"\n" != digest:
        message = "is cut off or altered: its checksum is not that of its content"
        raise InputError.single(message, _REMEDY, str(path))
    return content
