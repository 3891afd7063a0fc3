"""Contents of shared libraries of other systems than this one."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

LC_SYMTAB, LC_ID_DYLIB, LC_CODE_SIGNATURE = 0x2, 0xD, 0x1D
EXTERNAL, KIND, IN_SECTION = 0x01, 0x0E, 0x0E  # of a symbol's type
PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "aarch64"}


@dataclass(frozen=True)
class MachO:
    """A library of macOS. Source: Apple, mach-o/loader.h and mach-o/nlist.h."""

    processor: str
    kind: int
    commands: frozenset[int]
    exported: frozenset[str]


def universal_parts(content: bytes) -> Iterator[bytes]:
    """The libraries in a universal binary, each of which must begin on a page."""
    magic, count = struct.unpack_from(">II", content)
    assert magic == 0xCAFEBABE
    end = 8 + 20 * count
    for k in range(count):
        processor, _, place, size, alignment = struct.unpack_from(">5I", content, 8 + 20 * k)
        assert place >= end
        assert place % (1 << alignment) == 0
        end = place + size
        part = content[place:end]
        assert struct.unpack_from("<I", part, 4) == (processor,)
        yield part
    assert end == len(content)


def mach_o(content: bytes) -> MachO:
    magic, processor, _, kind, count = struct.unpack_from("<5I", content)
    assert magic == 0xFEEDFACF
    commands, exported, place = set(), set(), 32
    for _ in range(count):
        command, size = struct.unpack_from("<II", content, place)
        commands.add(command)
        if command == LC_SYMTAB:
            exported.update(_symbols(content, *struct.unpack_from("<4I", content, place + 8)))
        place += size
    return MachO(PROCESSORS[processor], kind, frozenset(commands), frozenset(exported))


def _symbols(content: bytes, place: int, count: int, names: int, _: int) -> Iterator[str]:
    for k in range(count):
        name, kind = struct.unpack_from("<IB", content, place + 16 * k)
        if kind & EXTERNAL and kind & KIND == IN_SECTION:
            yield _text(content, names + name).removeprefix("_")


def dll_exports(content: bytes) -> set[str]:
    """Names that a 64-bit DLL exports. Source: Microsoft, PE Format."""
    head = struct.unpack_from("<I", content, 0x3C)[0]
    assert content[head : head + 4] == b"PE\0\0"
    machine, sections = struct.unpack_from("<HH", content, head + 4)
    assert machine == 0x8664
    options = struct.unpack_from("<H", content, head + 20)[0]
    table = head + 24 + options
    listed = [struct.unpack_from("<4I", content, table + 40 * k + 8) for k in range(sections)]

    def place(address: int) -> int:
        [found] = [
            raw + address - start for size, start, _, raw in listed if 0 <= address - start < size
        ]
        return found

    directory = place(struct.unpack_from("<I", content, head + 24 + 112)[0])
    count, _, names = struct.unpack_from("<3I", content, directory + 24)
    return {
        _text(content, place(struct.unpack_from("<I", content, place(names) + 4 * k)[0]))
        for k in range(count)
    }


def _text(content: bytes, place: int) -> str:
    return content[place : content.index(b"\0", place)].decode("ascii")
