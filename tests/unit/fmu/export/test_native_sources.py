"""The C sources of native FMUs: no warnings, and no call that breaks them."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

import pytest
from support.driven import driven
from support.fuzz.shell import shell_fuzzer
from support.plane import plane

from m4e_fmi.fmu.export.from_program import describe, with_rates
from m4e_fmi.fmu.export.native_fmu import SETTINGS, native_fmu_files
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import (
    FLAGS,
    SHELL_FLAGS,
    SHELL_SOURCES,
    SOURCES,
    compiler,
    shell_sources,
)

STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
FUZZERS = Path(__file__).parents[3] / "fuzz"
FUZZ = {"2": FUZZERS / "fuzz_fmi.c", "3": FUZZERS / "fuzz_fmi3.c"}
FUNCTIONS = {"fmi2": 44, "fmi3": 75}


def compiled(arguments: list[str], sources: list[Path]) -> subprocess.CompletedProcess[str]:
    includes = ["-I", str(SOURCES), "-I", str(SHELL_SOURCES)]
    command = [*(compiler() or ["cc"]), *STRICT, *includes, *arguments, *map(str, sources), "-lm"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_shell_compiles_without_a_warning_and_exports_fmi_only(tmp_path: Path) -> None:
    library = tmp_path / "library.so"
    built = compiled([*FLAGS, *SHELL_FLAGS, "-o", str(library)], shell_sources())
    assert built.returncode == 0, built.stderr
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True, check=True
    )
    names = [line.split()[-1] for line in listed.stdout.splitlines()]
    assert Counter(name[:4] for name in names) == FUNCTIONS


@pytest.mark.parametrize(("fmi", "program"), [("2", driven()), ("3", plane())])
def test_random_calls_under_sanitizers(tmp_path: Path, fmi: str, program: Program) -> None:
    program = with_rates(program)
    files = native_fmu_files(program, describe(program), Options(native=True, fmi=fmi))
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    guid = files[SETTINGS].decode().split()[0]
    flags = ["-std=c11", "-O0", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    fuzzer = tmp_path / "fuzzer"
    built = compiled([*flags, "-DM4E_STATIC", "-o", str(fuzzer)], [FUZZ[fmi], *shell_sources()])
    if "cannot find" in built.stderr and "asan" in built.stderr:
        pytest.skip("this compiler has no sanitizers")
    assert built.returncode == 0, built.stderr
    groups = ("parameters", "calculated", "inputs", "states", "outputs")
    variables = sum(len(getattr(program, group)) for group in groups)
    if fmi == "3":
        variables = len(files["resources/variables.txt"].splitlines())
    resources = tmp_path / "resources"
    place = resources.as_uri() if fmi == "2" else f"{resources}/"
    words = ["100000", "1", place, guid, str(variables), str(len(program.states))]
    run = subprocess.run([str(fuzzer), *words], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    done, discarded, errors, messages, *updates = (
        int(w) for w in run.stdout.split() if w.isdigit()
    )
    assert min(done, discarded, errors, *updates) > 50
    assert messages > errors / 2  # logging is off now and then


def test_damaged_resources_under_sanitizers(tmp_path: Path) -> None:
    fuzzer = shell_fuzzer(tmp_path)
    if fuzzer is None:
        pytest.skip("this compiler has no sanitizers")
    run = fuzzer.run(0, 2000, 1)
    assert run.returncode == 0, run.stderr
    cases, instances = (int(word) for word in run.stdout.split() if word.isdigit())
    assert cases == 2000
    assert cases / 3 <= instances < cases
