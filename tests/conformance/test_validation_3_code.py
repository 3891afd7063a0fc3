"""The checks of FMI 3.0 FMUs find each fault planted into the C code of a native FMU."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest
from support.chains import hanging_chain

from m4e_fmi.fmu import build_fmu, validate_fmu
from m4e_fmi.fmu.export.native_fmu import shell_sources
from m4e_fmi.multibody import model_program
from m4e_fmi.runtime.compiler import compiler
from m4e_fmi.runtime.platforms import this_platform

FLAGS = ("-std=c11", "-O0", "-w", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off")
Fault = tuple[str, str, str, str, set[str]]
FAULTS: dict[str, Fault] = {
    "states are not restored": (
        "state.c",
        "memcpy(c->values, k->values, c->count * sizeof *c->values);",
        "memcpy(c->values, k->values, (c->n.parameters + c->n.inputs) * sizeof *c->values);",
        "state",
        {"state.rollback", "state.serialised"},
    ),
    "saving disturbs": (
        "state.c",
        "m4e_keep(c->integrator, k->values + c->count);\n    *state = k;\n",
        "m4e_keep(c->integrator, k->values + c->count);\n    *state = k;\n"
        "    c->x[0] += 1e-6;\n    c->now.ahead = 0;\n",
        "state",
        {"state.disturbs", "state.rollback", "state.serialised"},
    ),
    "reset forgets the states": (
        "fmi.c",
        "to_start(c);\n     c->last_error",
        "c->now.phase = INSTANTIATED;\n    c->now.stops = 0;\n     c->last_error",
        "instances",
        {"instances.reset"},
    ),
    "instances share a number": (
        "step.c",
        "    c->now.t = done ? end : report->time;",
        "    static double taken;\n    c->x[0] += 1e-3 * taken++;\n"
        "    c->now.t = done ? end : report->time;",
        "instances",
        {"instances.shared", "instances.reset"},
    ),
    "directional derivatives of the wrong sign": (
        "derivatives.c",
        "c->direction[direction_of(c, x[i])] += seed[i];",
        "c->direction[direction_of(c, x[i])] -= seed[i];",
        "directional",
        {"directional.mismatch"},
    ),
    "rates that are not those of the variables": (
        "variables.c",
        "rates[k] = c->rates[k];",
        "rates[k] = 1.01 * c->rates[k];",
        "start",
        {"start.order"},
    ),
    "another version": ("fmi.c", 'return "3.0";', 'return "2.0";', "start", {"start.version"}),
    "a function is not exported": (
        "fmi.c",
        "FUNCTION(fmi3EvaluateDiscreteStates,",
        "FUNCTION(evaluate_discrete_states,",
        "start",
        {"start.library"},
    ),
}
"""Fault → file, text in it, what it becomes, group that finds it, errors and warnings."""


@dataclass(frozen=True)
class Made:
    """An FMU, the sources of its library and an object file of each."""

    fmu: Path
    sources: Path

    def with_fault(self, name: str, folder: Path) -> Path:
        file, old, new, _, _ = FAULTS[name]
        text = (self.sources / file).read_text()
        assert text.count(old) == 1
        (folder / file).write_text(text.replace(old, new))
        compiled([folder / file], folder, self.sources)
        objects = [p for p in self.sources.glob("*.o") if p.stem != Path(file).stem]
        objects += folder.glob("*.o")
        library = folder / "faulty.so"
        run([*(compiler() or ["cc"]), "-shared", "-o", library, *objects, "-lm"])
        changed = folder / "faulty.fmu"
        with zipfile.ZipFile(self.fmu) as source, zipfile.ZipFile(changed, "w") as target:
            for member in source.namelist():
                ours = member.startswith(f"binaries/{this_platform().name}/")
                target.writestr(member, library.read_bytes() if ours else source.read(member))
        return changed


def run(command: Sequence[str | Path]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def compiled(files: Sequence[Path], folder: Path, include: Path) -> None:
    command = [*(compiler() or ["cc"]), *FLAGS, "-I", include, "-c", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    if this_platform().suffix != ".so":
        pytest.skip("compiled as for Linux")
    folder = tmp_path_factory.mktemp("made")
    for name, content in shell_sources().items():
        (folder / Path(name).name).write_bytes(content)
    compiled(sorted(folder.glob("*.c")), folder, folder)
    program = model_program(hanging_chain(2))
    return Made(build_fmu(program, folder / "chain.fmu", native=True, fmi="3"), folder)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_the_code_is_found(name: str, made: Made, tmp_path: Path) -> None:
    _, _, _, group, expected = FAULTS[name]
    report = validate_fmu(made.with_fault(name, tmp_path), only=(group,))
    assert {finding.id for finding in report.of_severity("error", "warning")} == expected
