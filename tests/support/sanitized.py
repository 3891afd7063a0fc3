"""C programs with sanitizers, which end where they do what is undefined, and without a warning."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from support.c_fmus.compiled import FMI_HEADERS, KEPT

from m4e_fmi.fmu import Options
from m4e_fmi.fmu.export.build import fmu_files
from m4e_fmi.fmu.export.native_fmu import SETTINGS
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import SHELL_SOURCES, SOURCES, compiler

STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
FLAGS = ("-std=gnu11", "-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
INCLUDES = ("-I", str(SOURCES), "-I", str(SHELL_SOURCES), "-isystem", str(FMI_HEADERS))
FUZZERS = Path(__file__).parents[1] / "fuzz"


def sanitized(program: Path, sources: Iterable[Path], *macros: str) -> Path:
    """The program of C sources; the test is skipped where the compiler has no sanitizers.

    Objects are kept by content. Macros are defined for sources that they may matter to.
    """
    with ThreadPoolExecutor(2) as pool:
        objects = list(pool.map(lambda source: _object(source, macros), sources))
    _run([*_cc(), *FLAGS, "-o", str(program), *map(str, objects), "-lm", "-pthread"])
    return program


def _cc() -> list[str]:
    return [*(compiler() or ["cc"])]


def _object(source: Path, macros: Iterable[str]) -> Path:
    text, folders = source.read_text("utf-8"), (SOURCES, SHELL_SOURCES, FUZZERS)
    found = {path.name: path.read_text("utf-8") for f in folders for path in f.glob("*.h")}
    headers, waiting = {}, [text]
    while waiting:
        for name in re.findall(r'#include "(\w+\.h)"', waiting.pop()):
            if name in found and name not in headers:
                headers[name] = found[name]
                waiting.append(found[name])
    text += "".join(headers[name] for name in sorted(headers))
    defined = [f"-D{macro}" for macro in macros if macro in text]
    command = [*_cc(), *FLAGS, *STRICT, *INCLUDES, *defined, "-c", str(source), "-o"]
    kept = KEPT / hashlib.sha256("\0".join([*command, text]).encode()).hexdigest()
    if not kept.exists():
        KEPT.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(f".{os.getpid()}.{source.stem}")
        _run([*command, str(part)])
        part.replace(kept)
    return kept


def _run(command: list[str]) -> None:
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if "cannot find" in built.stderr and "asan" in built.stderr:
        pytest.skip("this compiler has no sanitizers")
    assert built.returncode == 0, built.stderr


def written(program: Program, fmi: str, folder: Path) -> tuple[Mapping[str, bytes], str]:
    """The files of a native FMU, which are written into a folder, and its GUID or token."""
    files = fmu_files(program, Options(native=True, fmi=fmi))
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return files, files[SETTINGS].decode().split()[0]
