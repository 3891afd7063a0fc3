"""Checkpoints that someone else has altered, with the right checksum."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from m4e_fmi.files.encoding import Encoder, _Unpickler


def forge(path: Path, part: str, change: Callable[[Any], object]) -> None:
    """Put the result of `change` in place of a part of the checkpoint at `path`."""
    magic, _, content = path.read_bytes().split(b"\n", 2)
    length, _, rest = content.partition(b"\n")
    data, blobs = json.loads(rest[: int(length)]), rest[int(length) :]
    place, size = data[part]
    live = {"run": None}
    found = _Unpickler(io.BytesIO(blobs[place : place + size]), "m4e_fmi", live).load()
    encoder = Encoder()
    _, size = encoder.encode(change(found))
    text = json.dumps({**data, part: [len(blobs), size]}).encode()
    content = b"%d\n" % len(text) + text + blobs + encoder.blobs[0]
    digest = hashlib.sha256(content).hexdigest().encode()
    path.write_bytes(magic + b"\n" + digest + b"\n" + content)
