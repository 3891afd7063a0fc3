"""Libraries that certainly keep nothing between calls: instances of an FMU may share those.

Looked at are libraries of Linux for x86-64. What may be written in one, beside what the loader
fills in and then protects, is in .data and .bss. Compilers put two things of their own there: a
pointer to itself at the start of .data, and one byte at the start of .bss, which pads to 8. Where
there is no more, and no instruction that refers to the padding, there are no static variables.
Source: Tool Interface Standard, Executable and Linking Format, version 1.2, book I; System V
Application Binary Interface, AMD64 supplement, section 4.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

_SECTION = struct.Struct("<IIQQQQIIQQ")
_RELOCATION = struct.Struct("<QQq")
_SYMBOL = struct.Struct("<IBBHQQ")
_X86_64, _RELATIVE = 62, 8
_RELA, _DYNSYM = 4, 11
_WRITABLE, _ALLOCATED, _CODE, _THREADS = 1, 2, 4, 0x400
_OF_THE_LOADER = {
    *(".init_array", ".fini_array", ".data.rel.ro", ".dynamic", ".got", ".got.plt"),
}
_COMPARE, _MOVE, _ADDRESS = b"\x80\x3d", b"\xc6\x05", 0x8D
"""How instructions begin that compare and set the compiler's byte, where one more byte follows, and
those that take its address."""
_SLOT = 8


@dataclass(frozen=True)
class _Section:
    name: str
    kind: int
    flags: int
    address: int
    size: int
    content: bytes


def keeps_nothing(library: Path) -> bool:
    """True if the library at this path certainly has no static variables."""
    content = library.read_bytes()
    if content[:6] != b"\x7fELF\x02\x01" or content[18:20] != struct.pack("<H", _X86_64):
        return False
    try:
        return _keeps_nothing(list(_sections(content)))
    except (struct.error, IndexError, ValueError):
        return False


def _sections(content: bytes) -> Iterator[_Section]:
    (offset,) = struct.unpack_from("<Q", content, 40)
    size, count, names = struct.unpack_from("<HHH", content, 58)
    found = [_SECTION.unpack_from(content, offset + k * size) for k in range(count)]
    for name, kind, flags, address, begin, length, *_ in found:
        start = found[names][4] + name
        text = content[start : content.index(b"\0", start)].decode("ascii", "replace")
        yield _Section(text, kind, flags, address, length, content[begin : begin + length])


def _keeps_nothing(sections: list[_Section]) -> bool:
    both = _WRITABLE | _ALLOCATED
    written = {s.name: s for s in sections if s.flags & both == both}
    if not sections or any(s.flags & _THREADS for s in sections):
        return False
    data, bss = written.pop(".data", None), written.pop(".bss", None)
    if written.keys() - _OF_THE_LOADER:
        return False
    if data and data.size and not _points_to_itself(data, sections):
        return False
    if not bss or not bss.size:
        return True
    own = data is not None and data.size > 0  # both or none are the compiler's
    return own and bss.size <= _SLOT and not _referred(bss, sections)


def _points_to_itself(data: _Section, sections: list[_Section]) -> bool:
    """True if a section is a pointer to itself and nothing else."""
    relocations = (
        _RELOCATION.unpack_from(s.content, place)
        for s in sections
        if s.kind == _RELA
        for place in range(0, s.size, _RELOCATION.size)
    )
    own = (data.address, _RELATIVE, data.address)
    return data.size == _SLOT and own in relocations


def _referred(bss: _Section, sections: list[_Section]) -> bool:
    """True if symbols, or perhaps instructions, refer to more of a section than its first byte.

    An instruction has a distance of four bytes, counted from its end: up to four bytes may follow.
    """
    for s in sections:
        if s.kind == _DYNSYM:
            for place in range(0, s.size, _SYMBOL.size):
                _, _, _, section, value, _ = _SYMBOL.unpack_from(s.content, place)
                if section and bss.address <= value < bss.address + bss.size:
                    return True
        if not s.flags & _CODE:
            continue
        for shift in range(4):
            whole = (len(s.content) - shift) // 4
            distances = np.frombuffer(s.content, "<i4", max(whole, 0), min(shift, len(s.content)))
            places = shift + 4 * np.arange(len(distances))
            beyond = s.address + places + 4 + distances - bss.address
            for k in np.flatnonzero((beyond > -_SLOT) & (beyond < bss.size)):
                before = s.content[places[k] - 2 : places[k]]
                own = beyond[k] == -1 and before in (_COMPARE, _MOVE)
                if not own and not (beyond[k] == 0 and before[:1] == bytes([_ADDRESS])):
                    return True
    return False
