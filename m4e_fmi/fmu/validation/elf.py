"""Exported and needed symbols of a shared library of Linux, read from its dynamic section.

Source: Tool Interface Standard, Executable and Linking Format, version 1.2, book III; version
needs: Linux Standard Base Core Specification, section 10.7.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_DYNAMIC = struct.Struct("<QQ")
_NEED = struct.Struct("<HHIII")
_NEEDED_VERSION = struct.Struct("<IHHII")
_DYNSYM, _DYNAMIC_SECTION, _VERNEED = 11, 6, 0x6FFFFFFE
_NEEDED_LIBRARY = 1
_GLOBAL = (1, 2)  # bindings STB_GLOBAL, STB_WEAK


@dataclass(frozen=True)
class SharedLibrary:
    """`exports`: symbols others can link to; `needs`: libraries; `versions`: such as GLIBC_2.34."""

    exports: frozenset[str]
    needs: tuple[str, ...]
    versions: tuple[str, ...]


def read_elf(path: Path) -> SharedLibrary | None:
    """The 64-bit little-endian ELF library at `path`; None if it is something else, or damaged."""
    content = path.read_bytes()
    if content[:6] != b"\x7fELF\x02\x01":
        return None
    try:
        return _read(content)
    except (struct.error, IndexError, ValueError):
        return None


def _read(content: bytes) -> SharedLibrary:
    (offset,) = struct.unpack_from("<Q", content, 40)
    size, count = struct.unpack_from("<HH", content, 58)
    sections = [_SECTION.unpack_from(content, offset + k * size) for k in range(count)]

    def text(table: int, place: int) -> str:
        begin = sections[table][4] + place
        return content[begin : content.index(b"\0", begin)].decode("ascii", "replace")

    exports: set[str] = set()
    needs: list[str] = []
    versions: set[str] = set()
    for _, kind, _, _, begin, length, link, info, _, _ in sections:
        if kind == _DYNSYM:
            for place in range(begin, begin + length, _SYMBOL.size):
                name, how, _, section, _, _ = _SYMBOL.unpack_from(content, place)
                if section and how >> 4 in _GLOBAL:
                    exports.add(text(link, name))
        elif kind == _DYNAMIC_SECTION:
            for place in range(begin, begin + length, _DYNAMIC.size):
                tag, value = _DYNAMIC.unpack_from(content, place)
                if tag == _NEEDED_LIBRARY:
                    needs.append(text(link, value))
        elif kind == _VERNEED:
            place = begin
            for _ in range(info):
                _, entries, _, first, following = _NEED.unpack_from(content, place)
                entry = place + first
                for _ in range(entries):
                    _, _, _, name, after = _NEEDED_VERSION.unpack_from(content, entry)
                    versions.add(text(link, name))
                    entry += after
                place += following
    return SharedLibrary(frozenset(exports), tuple(needs), tuple(sorted(versions)))
