"""The C sources of native FMUs: no warnings, and no call that breaks them."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

import pytest
from support.driven import driven
from support.fuzz.shell import shell_fuzzer
from support.plane import plane
from support.sanitized import FUZZERS, INCLUDES, STRICT, sanitized, written

from m4e_fmi.fmu.export.description import with_rates
from m4e_fmi.fmu.export.native_fmu import shell_binaries
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import FLAGS, compiler, shell_sources
from m4e_fmi.runtime.platforms import this_platform

FUNCTIONS = {"fmi2": 44, "fmi3": 75}


def test_the_shell_compiles_without_a_warning_and_exports_fmi_only(tmp_path: Path) -> None:
    command = [*(compiler() or ["cc"]), *STRICT, *INCLUDES, *FLAGS, "-fsyntax-only"]
    checked = subprocess.run(
        [*command, *map(str, shell_sources())], capture_output=True, text=True, check=False
    )
    assert checked.returncode == 0, checked.stderr
    library, made = tmp_path / "library.so", shell_binaries("f", fmi="3")
    library.write_bytes(made[f"binaries/{this_platform().name}/f{this_platform().suffix}"])
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True, check=True
    )
    names = [line.split()[-1] for line in listed.stdout.splitlines()]
    assert Counter(name[:4] for name in names) == FUNCTIONS


@pytest.mark.parametrize(
    ("fmi", "source", "program"),
    [("2", "fuzz_fmi.c", driven()), ("3", "fuzz_fmi3.c", plane())],
)
def test_random_calls_under_sanitizers(
    tmp_path: Path, fmi: str, source: str, program: Program
) -> None:
    _, guid = written(program, fmi, tmp_path)
    fuzzer = sanitized(tmp_path / "fuzzer", [FUZZERS / source, *shell_sources()])
    program = with_rates(program)
    groups = ("parameters", "calculated", "inputs", "states", "outputs")
    variables = sum(len(getattr(program, group)) for group in groups)
    variables += fmi == "3"  # time
    resources = tmp_path / "resources"
    place = resources.as_uri() if fmi == "2" else f"{resources}/"
    words = ["50000", "1", place, guid, str(variables), str(len(program.states))]
    run = subprocess.run([str(fuzzer), *words], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    done, discarded, errors, messages, *updates = (
        int(w) for w in run.stdout.split() if w.isdigit()
    )
    assert min(done, discarded, errors, *updates) > 25
    assert messages > errors / 2  # logging is off now and then


def test_damaged_resources_under_sanitizers(tmp_path: Path) -> None:
    run = shell_fuzzer(tmp_path).run(0, 1000, 1)
    assert run.returncode == 0, run.stderr
    cases, instances = (int(word) for word in run.stdout.split() if word.isdigit())
    assert cases == 1000
    assert cases / 5 <= instances < cases
