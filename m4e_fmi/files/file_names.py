"""File names made of names that users choose: a name never becomes a path.

Users name systems, models, components and the entries of packages as they like. A file named after
one of them stays in its folder, on Linux and on Windows.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable

LONGEST = 100
"""Bytes of a name; suffixes and what others add leave it below the 255 of file systems."""
_FORBIDDEN = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]')
_RESERVED = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³])(\.|$)", re.IGNORECASE)


def file_stem(name: str) -> str:
    """`name` where it is a valid file name everywhere, else a similar one with a hash.

    Not valid: separators and other characters that file systems refuse, a dot at the start, a dot
    or space at the end, devices of Windows, more than LONGEST bytes.
    """
    plain = _FORBIDDEN.sub("_", name).encode("utf-8", "replace")[:LONGEST].decode("utf-8", "ignore")
    plain = plain.lstrip(".").rstrip(". ")
    if plain == name and not _RESERVED.match(name):
        return name
    return _marked(plain, name)


def is_device(name: str) -> bool:
    """True for a name that Windows takes for a device, whatever its suffix."""
    return bool(_RESERVED.match(name))


def file_stems(names: Iterable[str]) -> dict[str, str]:
    """The `file_stem` of each name; no two agree, nor differ in capitals only."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        stem = file_stem(name)
        if stem.casefold() in taken:
            stem = _marked(stem, name)
        taken.add(stem.casefold())
        found[name] = stem
    return found


def _marked(plain: str, name: str) -> str:
    digest = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    return f"{plain.replace('.', '_') or 'name'}-{digest}"
