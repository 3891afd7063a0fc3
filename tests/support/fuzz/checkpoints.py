"""Damage of checkpoints: of their JSON or of the parts behind it, most with the right checksum."""

from __future__ import annotations

import hashlib
import random

from support.fuzz.texts import damaged_bytes
from support.fuzz.trees import damaged_json


def damaged_checkpoint(content: bytes, rng: random.Random) -> bytes:
    """The content of a checkpoint with one kind of damage."""
    kind = rng.random()
    if kind < 0.15:
        return damaged_bytes(content, rng)
    magic, _, size, rest = content.split(b"\n", 3)
    text, blobs = rest[: int(size)], rest[int(size) :]
    if kind < 0.3:
        text = damaged_json(text, rng)
    else:
        blobs = damaged_bytes(blobs, rng)
    content = b"%d\n" % len(text) + text + blobs
    return b"\n".join((magic, hashlib.sha256(content).hexdigest().encode(), content))
