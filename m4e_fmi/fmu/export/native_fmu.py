"""The files of a native FMU: FMI 2.0 or 3.0, without Python and without a compiler.

`native/src/` is the shell around the runtime's C library: `instance.h` first, then `fmi.c`, the
standards' names for its functions. Both together are one shared library, the same for
every FMU of a platform; the model lies in `resources/`: `model.m4e`, the program in its
binary form, `tangent.m4e`, its directional derivatives, and `fmu.txt`: the GUID, the number of the
integration method, the default tolerance and the longest step [s] of rk4.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.limits import LARGEST_PROGRAM
from m4e_fmi.fmu.export.archive import model_identifier
from m4e_fmi.fmu.export.description import ModelDescription, Options
from m4e_fmi.program import TIME, Program, rate_entries, tangent
from m4e_fmi.program.binary_form import decode, encode
from m4e_fmi.runtime import compiler
from m4e_fmi.runtime.declarations import METHODS
from m4e_fmi.runtime.platforms import packaged, packaged_platforms, this_platform

PROGRAM, TANGENT, SETTINGS = "model.m4e", "tangent.m4e", "resources/fmu.txt"
FAT_MAGIC = 0xCAFEBABE
MACH_O_64 = 0xFEEDFACF
ALIGNMENT = 1 << 14  # a page of Apple's processors


def native_members(
    program: Program, description: ModelDescription, options: Options
) -> dict[str, bytes]:
    """Members of a native FMU beside its description: name in the archive → content.

    The GUID, which is that of all files, is still to be put in front of `SETTINGS`.
    """
    files = shell_binaries(model_identifier(description.name), fmi=options.fmi)
    files[f"resources/{PROGRAM}"] = model_file(program, options.method)
    files[f"resources/{TANGENT}"] = encode(_tangent(program))
    numbers = (_without_point(v) for v in (description.tolerance, description.step_size))
    files[SETTINGS] = f"{METHODS[options.method]} {' '.join(numbers)}\n".encode()
    return files | (shell_sources() if options.sources else {})


def _without_point(value: float) -> str:
    """`value` as "25e-2": C reads it in every locale, whose decimal point may be a comma."""
    _, digits, exponent = Decimal(repr(value)).as_tuple()
    return f"{''.join(map(str, digits))}e{exponent}"


def model_file(program: Program, method: str) -> bytes:
    """The program in its binary form, with what `method` needs."""
    return encode(program, rate_entries(program) if method == "rodas" else ())


def _tangent(program: Program) -> Program:
    """Directional derivatives of rates, outputs and calculated parameters, in this order.

    Directions follow the inputs: of time, states, inputs, parameters. Outputs are numbered: one may
    be a rate, and have its name.
    """
    outputs = enumerate((*program.outputs, *program.calculated))
    shown = replace(
        program,
        outputs=tuple(replace(v, name=f"y[{k}]", description=v.name) for k, v in outputs),
        results=(*program.results, *program.constants),
        calculated=(),
        constants=(),
    )
    groups = (program.states, program.inputs, program.parameters)
    return tangent(shown, along=[TIME, *(v.name for group in groups for v in group)])


def carried_program(fmu: Path) -> Program | None:
    """The program that a native FMU of ours carries; None of another FMU, or of another version."""
    try:
        with ZipFile(fmu) as archive:
            info = archive.getinfo(f"resources/{PROGRAM}")
            if info.file_size > LARGEST_PROGRAM:
                return None
            return decode(archive.read(info))[0]
    except (KeyError, InputError, OSError, BadZipFile):
        return None


def shell_binaries(identifier: str, *, fmi: str = "2") -> dict[str, bytes]:
    """Name in the archive → content of the shared library, for every platform that has one.

    Libraries come with the package; if this machine's is missing, it is compiled once into the
    cache. Folders are those of version `fmi` of the standard. RunError without any library.
    """
    here = this_platform()
    found = {p: path.read_bytes() for p in packaged_platforms() if (path := packaged("fmi", p))}
    if here not in found:
        try:
            found[here] = compiler.cached_shared(
                "m4e_fmi", compiler.shell_sources(), flags=compiler.SHELL_FLAGS
            ).read_bytes()
        except compiler.CompilationError as error:
            if not found:
                message = f"there is no library for native FMUs, and none can be compiled: {error}"
                remedy = "install a C compiler, or build without --native"
                raise RunError(message, remedy) from error
    if fmi == "3":
        return {f"binaries/{p.name}/{identifier}{p.suffix}": found[p] for p in found}
    chosen = {p.fmi2: (p, content) for p, content in reversed(found.items())}
    chosen |= {p.fmi2: (p, content) for p, content in found.items() if p == here}
    files = {f"binaries/{p.fmi2}/{identifier}{p.suffix}": c for p, c in chosen.values()}
    if darwin := [content for p, content in found.items() if p.fmi2 == "darwin64"]:
        files[f"binaries/darwin64/{identifier}.dylib"] = universal(darwin)
    return files


def universal(libraries: Sequence[bytes]) -> bytes:
    """One file of macOS' libraries, each for a processor of its own; ValueError if one is no
    Mach-O.

    A signature inside a library stays valid: it covers that library alone. Source: Apple,
    `mach-o/fat.h` and `mach-o/loader.h`; the header is big-endian.
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
        power = ALIGNMENT.bit_length() - 1
        header += struct.pack(">IIIII", processor, variant, place, len(library), power)
        content += bytes(place - first - len(content)) + library
        place = _aligned(place + len(library))
    return header + bytes(first - len(header)) + bytes(content)


def _aligned(place: int) -> int:
    return (place + ALIGNMENT - 1) // ALIGNMENT * ALIGNMENT


def shell_sources() -> dict[str, bytes]:
    """Name in the archive → content of the library's C sources, headers among them."""
    headers = (*compiler.SOURCES.glob("*.h"), *compiler.SHELL_SOURCES.glob("*.h"))
    paths = (*compiler.shell_sources(), *headers)
    return {f"sources/{path.name}": path.read_bytes() for path in paths}
