"""Native FMUs: FMI 2.0 or 3.0, without Python and without a compiler.

`src/` is the shell around the runtime's C library: `instance.h` first, then `fmi.c`, the
standards' names for what is declared there. Both together are one shared library, the same for
every FMU of a platform; what a model is lies in `resources/`: `model.m4e`, the program in its
binary form, `tangent.m4e`, its directional derivatives, and `fmu.txt`: the GUID, the number of the
integration method, the default tolerance and the longest step [s] of rk4; for FMI 3.0 also
`variables.txt` and `dependencies.txt`, which `layout_files` explains. Imports `runtime`, `errors`.
"""

from __future__ import annotations

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.export.native.universal import universal
from m4e_fmi.runtime import compiler
from m4e_fmi.runtime.platforms import packaged, packaged_platforms, this_platform


def shell_binaries(identifier: str, *, fmi: str = "2") -> dict[str, bytes]:
    """Name in the archive → content of the shared library, for every platform there is one for.

    Libraries come with the package; where this machine's is missing, it is compiled once into the
    cache. Folders are those of version `fmi` of the standard. RunError if there is none at all.
    """
    here = this_platform()
    found = {p: path.read_bytes() for p in packaged_platforms() if (path := packaged("fmi", p))}
    if here not in found:
        try:
            found[here] = _compiled()
        except compiler.CompilationError as error:
            if not found:
                message = f"there is no library for native FMUs, and none can be compiled: {error}"
                remedy = "install a C compiler, or build without --native"
                raise RunError(message, remedy) from error
    if fmi == "3":
        return {f"binaries/{p.name}/{identifier}{p.suffix}": found[p] for p in found}
    darwin = [content for p, content in found.items() if p.fmi2 == "darwin64"]
    chosen = {p.fmi2: (p, content) for p, content in reversed(found.items())}
    chosen |= {p.fmi2: (p, content) for p, content in found.items() if p == here}
    return {
        f"binaries/{folder}/{identifier}{p.suffix}": universal(darwin)
        if folder == "darwin64"
        else content
        for folder, (p, content) in chosen.items()
    }


def shell_sources() -> dict[str, bytes]:
    """Name in the archive → content of the library's C sources, headers among them."""
    headers = (*compiler.SOURCES.glob("*.h"), *compiler.SHELL_SOURCES.glob("*.h"))
    paths = (*compiler.shell_sources(), *headers)
    return {f"sources/{path.name}": path.read_bytes() for path in paths}


def _compiled() -> bytes:
    flags = compiler.SHELL_FLAGS
    path = compiler.cached_shared("m4e_fmi", compiler.shell_sources(), flags=flags)
    return path.read_bytes()
