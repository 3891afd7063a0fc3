"""The fuzzer of native FMUs, compiled with sanitizers, and its cases."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from support.driven import driven
from support.plane import plane

from m4e_fmi.fmu.export.from_program import describe, with_rates
from m4e_fmi.fmu.export.native_fmu import SETTINGS, native_fmu_files
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.runtime.compiler import SHELL_SOURCES, SOURCES, compiler, shell_sources

SOURCE = Path(__file__).parents[2] / "fuzz" / "fuzz_shell.c"
FLAGS = ("-std=gnu11", "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-fsanitize=address,undefined",
         "-fno-sanitize-recover=all", "-DM4E_STATIC")  # fmt: skip


@dataclass(frozen=True)
class ShellFuzzer:
    """The program, and the last words of its arguments: folders and tokens of its FMUs."""

    program: Path
    words: tuple[str, ...]

    def run(self, first: int, last: int, seed: int) -> subprocess.CompletedProcess[str]:
        """The process that has tried the cases from `first` up to before `last`."""
        command = [str(self.program), str(first), str(last), str(seed), *self.words]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def first_failure(self, first: int, last: int, seed: int) -> int:
        """The first case from `first` up to before `last` that fails, if one does."""
        while last - first > 1:
            middle = (first + last) // 2
            if self.run(first, middle, seed).returncode:
                last = middle
            else:
                first = middle
        return first


def shell_fuzzer(folder: Path) -> ShellFuzzer | None:
    """The fuzzer with two FMUs in `folder`; None if the compiler has no sanitizers."""
    words = []
    for fmi, program in (("2", with_rates(driven())), ("3", with_rates(plane()))):
        files = native_fmu_files(program, describe(program), Options(native=True, fmi=fmi))
        for name, content in files.items():
            path = folder / fmi / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        words.append((f"{folder / fmi / 'resources'}/", files[SETTINGS].decode().split()[0]))
    fuzzer = folder / "fuzz_shell"
    sources = [str(SOURCE), *map(str, shell_sources())]
    includes = ["-I", str(SOURCES), "-I", str(SHELL_SOURCES)]
    command = [*(compiler() or ["cc"]), *FLAGS, *includes, "-o", str(fuzzer), *sources, "-lm"]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if "cannot find" in built.stderr and "asan" in built.stderr:
        return None
    if built.returncode:
        raise RuntimeError(built.stderr)
    (folder2, token2), (folder3, token3) = words
    return ShellFuzzer(fuzzer, (folder2, folder3, token2, token3))
