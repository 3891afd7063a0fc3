"""Damage of ZIP archives: in their entries, in the fields of their headers, in what they hold."""

from __future__ import annotations

import io
import random
import stat
import warnings
import zipfile
from collections.abc import Callable, Mapping

NAMES = (
    "../out", "/out", "a\\b", "x" * 300, "con", "a/../../b", "C:/out", "a//b", "./a", "aux.txt",
    "a/" * 300 + "b", "a\x1b[2J", "a\u202eb", "a.", "resources", "binaries", "", "/", "~/x", "a:b",
)  # fmt: skip
HEADERS = {b"PK\x03\x04": 30, b"PK\x01\x02": 46, b"PK\x05\x06": 22}
"""Signatures of headers, and their sizes [bytes]."""
ODD = (0, 1, 2, 8, 9, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFE, 0xFFFFFFFF)


def packed(files: Mapping[str, bytes | str], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """An archive with these files."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content, method)
    return file.getvalue()


def damaged_archive(
    content: bytes, rng: random.Random, damage: Callable[[bytes, str], bytes]
) -> bytes:
    """An archive with its fields, its entries or their content changed.

    `damage` gives the damaged content of a file that is inside, by its content and name.
    """
    if rng.random() < 0.15:
        return _changed_field(content, rng)
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            files = {info.filename: archive.read(info) for info in archive.infolist()}
    except Exception:  # noqa: BLE001  of damage that came before
        return content
    if not files:
        return content
    name = rng.choice(list(files))
    if rng.random() < 0.15:
        return _odd_entry(files, name, rng)
    if name.endswith((".xml", ".ssd", ".ssv", ".fmu")) or rng.random() < 0.3:
        files[name] = damage(files[name], name) if files[name] else b"\x7fELF" + bytes(60)
    elif rng.random() < 0.5:
        del files[name]
    else:
        files[name] = rng.randbytes(rng.choice((0, 1, 100)))
    return packed(files, rng.choice((zipfile.ZIP_DEFLATED, zipfile.ZIP_STORED)))


def _odd_entry(files: dict[str, bytes], name: str, rng: random.Random) -> bytes:
    """The archive with one more entry: an odd name, a link, a twin, a bomb."""
    file = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        warnings.simplefilter("ignore")  # of names that are there twice
        for each, content in files.items():
            archive.writestr(zipfile.ZipInfo(each), content)
        info, content = zipfile.ZipInfo(rng.choice(NAMES) or "a"), b"x"
        match rng.randrange(5):
            case 0:
                info.external_attr = (stat.S_IFLNK | 0o777) << 16
                content = rng.choice((b"/etc/passwd", b"../../..", b"/"))
            case 1:
                info.filename = rng.choice((name.upper(), f"{name}/a", name))
            case 2:
                content = bytes(20_000_000)
            case 3:
                info.extra = rng.randbytes(rng.choice((1, 4, 60)))
            case _:
                pass
        try:
            archive.writestr(info, content, zipfile.ZIP_DEFLATED)
        except Exception:  # noqa: BLE001  an entry that cannot be written
            return packed(files)
    return file.getvalue()


def _changed_field(content: bytes, rng: random.Random) -> bytes:
    """The archive with two or four bytes of a header changed."""
    places = [
        place
        for signature, size in HEADERS.items()
        for place in _found(content, signature)
        if place + size <= len(content)
    ]
    if not places:
        return content
    place = rng.choice(places)
    size = HEADERS[content[place : place + 4]]
    at, width = place + 4 + 2 * rng.randrange((size - 6) // 2), rng.choice((2, 4))
    value = (rng.choice(ODD) & (256**width - 1)).to_bytes(width, "little")
    return content[:at] + value + content[at + width :]


def _found(content: bytes, signature: bytes) -> list[int]:
    found, at = [], content.find(signature)
    while at >= 0:
        found.append(at)
        at = content.find(signature, at + 1)
    return found
