"""Universal binaries of macOS: the same library for several processors in one file.

Source: Apple, `mach-o/fat.h` and `mach-o/loader.h`; the header is big-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

FAT_MAGIC = 0xCAFEBABE
MACH_O_64 = 0xFEEDFACF
ALIGNMENT = 14  # power of two: a page of Apple's processors


def universal(libraries: Sequence[bytes]) -> bytes:
    """One file of the libraries, each for a processor of its own; ValueError if one is no Mach-O.

    A signature inside a library stays valid: it covers that library alone.
    """
    if len(libraries) == 1:
        return libraries[0]
    header = struct.pack(">II", FAT_MAGIC, len(libraries))
    place = _aligned(len(header) + 20 * len(libraries))
    content = bytearray()
    first = place
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_O_64:
            raise ValueError("not a 64-bit Mach-O library")
        header += struct.pack(">IIIII", processor, variant, place, len(library), ALIGNMENT)
        content += bytes(place - first - len(content)) + library
        place = _aligned(place + len(library))
    return header + bytes(first - len(header)) + bytes(content)


def _aligned(place: int) -> int:
    page = 1 << ALIGNMENT
    return (place + page - 1) // page * page
