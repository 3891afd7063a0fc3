"""The libraries that ship, for every platform: their places in the package, how they are compiled.

`python -m m4e_fmi.runtime.platforms` compiles them all, with the package `ziglang`. The runtime is
a library by itself, for Python, and the inner part of the library of native FMUs. What was compiled
from other sources than those beside it counts as missing. Standard library only: the build hook
imports this module before anything is installed.
"""

from __future__ import annotations

import functools
import hashlib
import importlib.util
import platform
import shutil
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.runtime import compiler

FOLDER = Path(__file__).with_name("binaries")
DIGEST = "sources.sha256"
START_UP = "mingw-w64.txt"
"""License of what the compiler adds to libraries for Windows; beside them."""


@dataclass(frozen=True)
class Platform:
    """A processor and a system, by FMI 3's `name`; `fmi2` is the name of FMI 2's folder.

    `target` is the compiler's word for it, `flags` are those it needs besides.
    """

    name: str
    fmi2: str
    suffix: str
    target: str = ""
    flags: tuple[str, ...] = ()


SMALLER = ("-fno-asynchronous-unwind-tables", "-fno-unwind-tables")
"""No tables for exceptions, which C has not: a tenth of a library. Those for Windows need them."""
PLATFORMS = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "linux64", ".so", "x86_64-linux-gnu.2.17", SMALLER),
        # FMI 2 has no folder for it; importers on such a machine look into this one
        Platform("aarch64-linux", "linux64", ".so", "aarch64-linux-gnu.2.17", SMALLER),
        Platform("x86_64-windows", "win64", ".dll", "x86_64-windows-gnu"),
        Platform("x86_64-darwin", "darwin64", ".dylib", "x86_64-macos.10.13", SMALLER),
        Platform("aarch64-darwin", "darwin64", ".dylib", "aarch64-macos.11.0", SMALLER),
    )
}


LIBRARIES = {
    "runtime": (compiler.runtime_sources, compiler.RUNTIME_FLAGS),
    "fmi": (compiler.shell_sources, compiler.SHELL_FLAGS),
}
"""Libraries by name: what gives their sources, and flags."""


def this_platform() -> Platform:
    """The platform of this machine, which need not be one of PLATFORMS."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    folder = {"windows": "win64", "darwin": "darwin64"}.get(system, "linux64")
    name = f"{machine}-{system}"
    return PLATFORMS.get(name) or Platform(name, folder, compiler.SUFFIX)


def library_file(library: str, platform: Platform) -> str:
    """Path of a library ("runtime", "fmi") in the folder of binaries."""
    return f"{platform.name}/{library}{platform.suffix}"


def packaged(library: str, platform: Platform, beside: str = "") -> Path | None:
    """The packaged library for a platform, or the file `beside` it; None if missing or outdated."""
    path = FOLDER / library_file(library, platform)
    path = path.with_name(beside) if beside else path
    digest = path.with_name(DIGEST)
    kept = path.exists() and digest.exists() and digest.read_text("ascii") == source_digest()
    return path if kept else None


def packaged_platforms() -> list[Platform]:
    """Those that the package has the library of native FMUs for."""
    known = {**PLATFORMS, this_platform().name: this_platform()}
    return [p for p in known.values() if packaged("fmi", p)]


@functools.cache
def source_digest() -> str:
    """Hash of the C sources and of the flags they are compiled with."""
    flags = (compiler.FLAGS, SMALLER, *(flags for _, flags in LIBRARIES.values()))
    digest = hashlib.sha256(repr(flags).encode())
    for folder in (compiler.SOURCES, compiler.SHELL_SOURCES):
        for path in sorted(folder.glob("*.[ch]")):
            digest.update(f"\0{path.name}\0{path.read_text('utf-8')}".encode())
    return digest.hexdigest()


def compile_libraries(platforms: Iterable[Platform], folder: Path) -> None:
    """Compile both libraries of each platform into `folder`; CompilationError if one cannot be.

    A platform without `target` is this machine's, and its own compiler's work.
    """
    zig = [sys.executable, "-m", "ziglang", "cc", "-target"]
    for one in platforms:
        command = [*zig, one.target] if one.target else None
        for name, (sources, flags) in LIBRARIES.items():
            target = folder / library_file(name, one)
            flags = (*flags, *one.flags)
            compiler.compile_shared(sources(), target, flags=flags, command=command)
        if one.suffix == ".dll" and command:
            spec = importlib.util.find_spec("ziglang")
            assert spec is not None, "it compiled a moment ago"
            license_ = Path(str(spec.origin)).parent / "lib/libc/mingw/COPYING"
            shutil.copyfile(license_, folder / one.name / START_UP)
        (folder / one.name / DIGEST).write_text(source_digest(), "ascii")


def chosen(names: str) -> list[Platform]:
    """Platforms by a list of names with commas, or "all"; ValueError with unknown names."""
    if names == "all":
        return list(PLATFORMS.values())
    unknown = [name for name in names.split(",") if name not in PLATFORMS]
    if unknown:
        raise ValueError(f"no platforms: {', '.join(unknown)}; there are {', '.join(PLATFORMS)}")
    return [PLATFORMS[name] for name in names.split(",")]


if __name__ == "__main__":
    compile_libraries(chosen(",".join(sys.argv[1:]) or "all"), FOLDER)
