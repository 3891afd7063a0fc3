"""The fuzzer of native FMUs, compiled with sanitizers, and its cases."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

from support.driven import driven
from support.plane import plane
from support.sanitized import FUZZERS, sanitized, written

from m4e_fmi.runtime.compiler import shell_sources


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


def shell_fuzzer(folder: Path) -> ShellFuzzer:
    """The fuzzer with two FMUs in `folder`; the test is skipped without sanitizers."""
    given = (("2", driven()), ("3", plane()))
    tokens = [written(program, fmi, folder / fmi)[1] for fmi, program in given]
    sources = [FUZZERS / "fuzz_shell.c", *shell_sources()]
    program = sanitized(folder / "fuzz_shell", sources)
    return ShellFuzzer(program, (*(f"{folder / fmi / 'resources'}/" for fmi in "23"), *tokens))
