"""The C sources: no warnings, no undefined behaviour on damaged programs, right without tricks."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from support.runtime_programs import chain, every_operation, robertson
from support.sanitized import FUZZERS, STRICT, sanitized

from m4e_fmi.program.binary_form import encode
from m4e_fmi.runtime.compiler import (
    FLAGS,
    SOURCES,
    CompilationError,
    cached_shared,
    compile_shared,
    compiler,
)

C_FILES = sorted(SOURCES.glob("*.c"))


def test_times_are_of_a_clock_that_is_never_set() -> None:
    found = [
        file.name for file in C_FILES if re.search(r"timespec_get|time\(NULL", file.read_text())
    ]
    assert not found


@pytest.mark.parametrize("more", [[], ["-DM4E_NO_COMPUTED_GOTO"]], ids=["goto", "switch"])
def test_sources_compile_without_a_warning(more: list[str]) -> None:
    command = [*(compiler() or ["cc"]), *FLAGS, *STRICT, *more, "-fPIC", "-fsyntax-only"]
    run = subprocess.run([*command, *map(str, C_FILES)], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("macros", [(), ("M4E_NO_COMPUTED_GOTO",)], ids=["goto", "switch"])
def test_damaged_programs_under_sanitizers(tmp_path: Path, macros: tuple[str, ...]) -> None:
    sources = [FUZZERS / "fuzz_program.c", *C_FILES]
    fuzzer = sanitized(tmp_path / "fuzzer", sources, *macros)
    seeds = []
    for program, entries in ((chain(2), []), (every_operation(), [(0, 0, 1)]), robertson()):
        seeds.append(tmp_path / program.name)
        seeds[-1].write_bytes(encode(program, entries))
    run = subprocess.run(
        [str(fuzzer), "15000", "7", *map(str, seeds)], capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    tried, taken = (int(word) for word in run.stdout.split() if word.isdigit())
    assert tried == 15000
    assert 0 < taken < tried


def test_a_worker_that_lies_about_its_answers(tmp_path: Path) -> None:
    """What is shared with an FMU may hold anything: the client takes it for lost, or for empty."""
    program = sanitized(tmp_path / "liar", [FUZZERS / "lying_worker.c", *C_FILES])
    run = subprocess.run([str(program)], capture_output=True, text=True, timeout=60)
    assert (run.returncode, run.stdout) == (0, "51 lost\n"), run.stderr


def test_every_kind_of_argument_goes_to_a_worker_and_back(tmp_path: Path) -> None:
    program = sanitized(tmp_path / "trip", [FUZZERS / "round_trip.c", *C_FILES])
    run = subprocess.run([str(program)], capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stdout + run.stderr


def test_what_is_compiled_is_kept_by_content(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path))
    source = "double m4e_one(void);\ndouble m4e_one(void) { return 1.0; }\n"
    first = cached_shared("one", [], source)
    made = first.stat().st_mtime_ns
    assert cached_shared("one", [], source) == first
    assert first.stat().st_mtime_ns == made
    assert cached_shared("one", [], source + "\n") != first


def test_a_compiler_that_refuses_or_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = tmp_path / "bad.c"
    source.write_text("this is no C\n")
    with pytest.raises(CompilationError, match="failed"):
        compile_shared([source], tmp_path / "bad.so")
    assert not (tmp_path / "bad.so").exists()
    monkeypatch.setattr("m4e_fmi.runtime.compiler.compiler", lambda: None)
    with pytest.raises(CompilationError, match="no C compiler"):
        compile_shared(C_FILES, tmp_path / "library.so")
