"""Random numbers that follow from their place alone, so that steps may be repeated."""

from __future__ import annotations

import math
from hashlib import blake2b


def uniform(seed: int, name: str, index: int) -> tuple[float, float]:
    """Two independent numbers in (0, 1) for the drawing number `index` of `name`."""
    digest = blake2b(f"{seed} {index} {name}".encode(), digest_size=16).digest()
    first, second = (int.from_bytes(part, "little") >> 11 for part in (digest[:8], digest[8:]))
    return (first + 0.5) / 2**53, (second + 0.5) / 2**53


def normal(seed: int, name: str, index: int) -> float:
    """A number of the standard normal distribution (Box and Muller, 1958)."""
    one, other = uniform(seed, name, index)
    return math.sqrt(-2.0 * math.log(one)) * math.cos(2.0 * math.pi * other)
