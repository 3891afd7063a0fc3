"""The C compiler of this machine, its flags, and the user's cache of what it compiled.

Libraries that ship, for every platform, are the work of `platforms`, with the same `FLAGS`.
Standard library only and without imports from the package: the build hook loads this file by path.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

SOURCES = Path(__file__).with_name("src")
SHELL_SOURCES = Path(__file__).parents[1] / "fmu" / "export" / "native" / "src"
SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
# one rounding per operation, whatever the processor: the same bits everywhere
FLAGS = (
    "-std=c11",
    "-O2",
    "-ftree-vectorize",
    "-fno-unroll-loops",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fvisibility=hidden",
    "-shared",
)

RUNTIME_FLAGS = ("-DM4E_SHARED", "-s")
"""Of the runtime as a library of its own, which exports its functions, those of masters too."""
SHELL_FLAGS = ("-s",)
"""Of the library of native FMUs, which exports nothing but FMI."""
NOT_IN_FMUS = (
    *("ensemble.c", "fmus.c", "line_steps.c", "lines.c", "loop.c"),
    *("remote.c", "remote_client.c", "remote_server.c"),
)
"""Sources for running many models, a master, or mooring lines."""

VECTOR_FLAGS = {
    "avx512": ("-mavx512f", "-mprefer-vector-width=512"),
    "avx2": ("-mavx2",),
    "": (),
}
"""By instruction set of the processor. None of them fuses operations: the bits are the same."""


def runtime_sources() -> list[Path]:
    """C files of the runtime as a library of its own."""
    return sorted(SOURCES.glob("*.c"))


def shell_sources() -> list[Path]:
    """C files of the library of native FMUs: the runtime and the FMI shell around it."""
    runtime = (path for path in runtime_sources() if path.name not in NOT_IN_FMUS)
    return sorted([*runtime, *SHELL_SOURCES.glob("*.c")])


class CompilationError(Exception):
    """No compiler, or the compiler refused; the message says what it said."""


def compiler() -> list[str] | None:
    """Command of the C compiler: $CC, cc, gcc, clang or the `ziglang` package; None if none is."""
    for name in (os.environ.get("CC"), "cc", "gcc", "clang"):
        if name and shutil.which(name.split()[0]):
            return name.split()
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc"]
    return None


def cache_folder() -> Path:
    """Where compiled libraries are kept: $M4E_FMI_CACHE, or the user's cache."""
    given = os.environ.get("M4E_FMI_CACHE")
    if given:
        return Path(given)
    import platformdirs

    return Path(platformdirs.user_cache_dir("m4e_fmi", appauthor=False))


def compile_shared(
    sources: Sequence[Path],
    target: Path,
    *,
    flags: Sequence[str] = (),
    command: Sequence[str] | None = None,
    prefix: str | None = None,
) -> None:
    """Compile C files into the shared library `target`, which appears whole or not at all.

    `command` is that of another compiler than this machine's, `prefix` how the name of the folder
    begins in which it is made, beside `target`. Raises CompilationError.
    """
    command = command or compiler()
    if command is None:
        raise CompilationError("no C compiler was found (cc, gcc, clang, or the package ziglang)")
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=prefix) as folder:
        made = Path(folder) / target.name
        place = () if target.suffix == ".dll" else ("-fPIC",)
        arguments = [*command, *FLAGS, *place, *flags, "-I", str(SOURCES), "-o", str(made)]
        try:
            run = subprocess.run(
                [*arguments, *map(str, sources), "-lm"], capture_output=True, text=True, check=False
            )
        except OSError as error:
            raise CompilationError(f"{command[0]} did not start: {error}") from error
        if run.returncode != 0:
            raise CompilationError(f"{' '.join(command)} failed: {run.stderr.strip()[:2000]}")
        made.replace(target)


def cached_shared(
    name: str, sources: Sequence[Path], text: str = "", *, flags: Sequence[str] = ()
) -> Path:
    """Path of the library compiled from `sources`, or from `text`, compiled now unless it is kept.

    The name in the cache carries a hash of all that it is made from, the compiler among it.
    Processes may compile the same at one time. Raises CompilationError.
    """
    from m4e_fmi.files.writing import part_prefix, remove_leftovers

    command = compiler() or [""]
    parts = [" ".join([*command, *FLAGS, *flags]), _program_file(command[0]), platform.machine()]
    parts += [text, sysconfig.get_platform()]
    headers = [h for folder in {SOURCES, *(s.parent for s in sources)} for h in folder.glob("*.h")]
    parts += [path.read_text("utf-8") for path in sorted({*sources, *headers})]
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]
    target = cache_folder() / f"{name}-{digest}{SUFFIX}"
    try:
        if target.exists():
            return target
        remove_leftovers(target.parent)
        with tempfile.TemporaryDirectory() as folder:
            if text:
                sources = [Path(folder) / f"{name}.c"]
                sources[0].write_text(text, encoding="utf-8")
            compile_shared(sources, target, flags=flags, prefix=part_prefix())
    except OSError as error:
        with suppress(OSError):
            if target.exists():  # Windows does not replace what another process has loaded
                return target
        raise CompilationError(f"the cache cannot be written: {error}") from error
    return target


def _program_file(name: str) -> str:
    """The file that a command runs, its size and time: another version of it is another."""
    path = shutil.which(name) if name else None
    if path is None:
        return ""
    file = Path(path).resolve()
    return f"{file} {file.stat().st_size} {file.stat().st_mtime_ns}"
