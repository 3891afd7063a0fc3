"""Damage of binary files by their fields: words of four and eight bytes become odd numbers."""

from __future__ import annotations

import random
import struct
import zlib

DOUBLES = (0.0, -0.0, 1e-45, 1e38, -1e38, 1e308, float("nan"), float("inf"), -float("inf"), 1.0)
WORDS = (0, 1, 2, 3, 0xFF, 0xFFFF, 2**20, 2**31 - 1, 2**31, 2**32 - 1)


def damaged_fields(content: bytes, rng: random.Random, head: int = 512) -> bytes:
    """The content with one to four numbers changed, half of them within `head` [bytes]."""
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        size = rng.choice((1, 2, 4, 4, 8))
        end = len(data) if rng.random() < 0.5 else min(head, len(data))
        if end < size:
            break
        at = rng.randrange(end - size + 1)
        order = rng.choice("<>")
        if size >= 4 and rng.random() < 0.4:
            value = struct.pack(f"{order}{'f' if size == 4 else 'd'}", *_number(size, rng))
        else:
            word = rng.choice(WORDS) & (256**size - 1)
            value = word.to_bytes(size, "little" if order == "<" else "big")
        data[at : at + size] = value
    return bytes(data)


def _number(size: int, rng: random.Random) -> tuple[float]:
    value = rng.choice(DOUBLES)
    return (value if size == 8 or abs(value) < 1e39 else float("inf"),)


def damaged_program(content: bytes, rng: random.Random) -> bytes:
    """A program's binary form with numbers changed, mostly with its right size and checksum."""
    data = bytearray(damaged_fields(content, rng, 80))
    if rng.random() < 0.2 and len(data) > 80:
        at = rng.randrange(80, len(data))
        del data[at : at + rng.choice((1, 4, 8))]
    if rng.random() < 0.85 and len(data) >= 24:
        data[:12] = content[:12]
        data[16:24] = len(data).to_bytes(8, "little")
        data[12:16] = zlib.crc32(data[16:]).to_bytes(4, "little")
    return bytes(data)
