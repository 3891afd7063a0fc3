"""Native FMUs on Windows, as far as wine is one: the bits of this machine, value by value."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import pytest
from support.c_programs import (
    compiled_for_windows,
    compiled_here,
    run_here,
    run_on_windows,
    windows_path,
)
from support.chains import hanging_chain
from support.driven import fragile
from support.flap_file import TEXT, WAVE
from support.runtime_programs import every_operation

from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.from_program import with_rates
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import SHELL_SOURCES
from m4e_fmi.runtime.platforms import PLATFORMS, packaged

SUPPORT = Path(__file__).parents[1] / "support"
INCLUDES = ("-I", str(SHELL_SOURCES), "-I", str(SUPPORT))
STEPS, H = 60, 0.02


@dataclass(frozen=True)
class Hosts:
    """The same program for this machine and for Windows."""

    here: Path
    windows: Path


def compiled(source: Path, folder: Path) -> Hosts:
    if packaged("fmi", PLATFORMS["x86_64-windows"]) is None:
        pytest.skip("no library of native FMUs for Windows here: make platforms")
    windows = compiled_for_windows(source, folder / "host.exe", flags=INCLUDES)
    return Hosts(compiled_here(source, folder / "host", flags=INCLUDES), windows)


@pytest.fixture(scope="module")
def hosts(tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    return compiled(SUPPORT / "fmu_host.c", tmp_path_factory.mktemp("hosts"))


@pytest.fixture(scope="module")
def hosts_3(tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    return compiled(SUPPORT / "fmu3_host.c", tmp_path_factory.mktemp("hosts_3"))


def chain(_: Path) -> Program:
    return model_program(hanging_chain(10))


def flap(folder: Path) -> Program:
    """Tables, laws of springs and dampers, stops, drag, friction."""
    (folder / "wave.csv").write_text(WAVE)
    path = folder / "flap.model.yaml"
    path.write_text(TEXT)
    return model_program(load_model(path))


def words(program: Program, guid: str, resources: str, library: str) -> list[str]:
    program = with_rates(program)
    first = len(program.parameters) + len(program.calculated)
    inputs = len(program.inputs)
    reals = first + inputs + len(program.states) + len(program.outputs)
    return [library, resources, guid, *map(str, (reals, first, inputs, STEPS, H))]


def lines(hosts: Hosts, program: Program, folder: Path) -> tuple[list[str], list[str]]:
    """What the host prints here and on Windows."""
    fmu = build_fmu(program, folder / "model.fmu", native=True)
    unpacked = folder / "unpacked"
    fmpy.extract(str(fmu), str(unpacked))
    guid = fmpy.read_model_description(str(fmu)).guid or ""
    uri = (unpacked / "resources").as_uri()
    [library] = (unpacked / "binaries" / "linux64").iterdir()
    here = run_here(hosts.here, words(program, guid, uri, str(library)))
    assert here.returncode == 0, here.stderr
    [library] = (unpacked / "binaries" / "win64").iterdir()
    uri = uri.replace("file:///", "file:///Z:/")
    there = run_on_windows(hosts.windows, words(program, guid, uri, windows_path(library)))
    assert there.returncode == 0, there.stdout + there.stderr
    return here.stdout.splitlines(), there.stdout.splitlines()


def operations(_: Path) -> Program:
    return every_operation()


@pytest.mark.parametrize("make", [chain, flap, operations])
def test_the_bits_of_this_machine(
    hosts: Hosts, make: Callable[[Path], Program], tmp_path: Path
) -> None:
    """Values, logged messages, states as bytes, and what follows a restored state."""
    here, there = lines(hosts, make(tmp_path), tmp_path)
    for ours, theirs in zip(here, there, strict=True):
        assert theirs == ours
    assert sum(line.startswith("log host 3 logStatusError") for line in there) == 1
    second = [line for line in there if line.startswith("second")]
    assert len(second) == 3 * (STEPS // 2)
    assert second[: STEPS // 2] * 3 == second


def test_discard(hosts: Hosts, tmp_path: Path) -> None:
    """x' = rate·x² has no state beyond some time; both say the same one."""
    here, there = lines(hosts, fragile(), tmp_path)
    assert there == here
    assert any(line.startswith("reached") for line in there)
    assert any(line.startswith("log host 2 logStatusDiscard") for line in there)


def listed(variables: list[Any]) -> list[str]:
    """Value references with commas, and the number of scalars."""
    scalars = sum(math.prod(v.shape or ()) for v in variables)
    return [",".join(str(v.valueReference) for v in variables), str(scalars)]


@pytest.mark.parametrize("make", [chain, flap, operations])
def test_the_bits_of_this_machine_by_fmi_3(
    hosts_3: Hosts, make: Callable[[Path], Program], tmp_path: Path
) -> None:
    """Values, times reached, states as bytes, what follows a restored state, derivatives."""
    fmu = build_fmu(make(tmp_path), tmp_path / "model.fmu", native=True, fmi="3")
    unpacked = tmp_path / "unpacked"
    fmpy.extract(str(fmu), str(unpacked))
    description: Any = fmpy.read_model_description(str(fmu))
    reals = [v for v in description.modelVariables if v.type == "Float64"]
    inputs, outputs = ([v for v in reals if v.causality == c] for c in ("input", "output"))
    more = [*listed(reals), *listed(inputs), *listed(outputs), str(STEPS), str(H)]
    resources, token = str(unpacked / "resources"), str(description.guid)
    [library] = (unpacked / "binaries" / "x86_64-linux").iterdir()
    here = run_here(hosts_3.here, [str(library), f"{resources}/", token, *more])
    assert here.returncode == 0, here.stdout[-500:] + here.stderr
    [library] = (unpacked / "binaries" / "x86_64-windows").iterdir()
    place = windows_path(unpacked / "resources") + "\\"
    there = run_on_windows(hosts_3.windows, [windows_path(library), place, token, *more])
    assert there.returncode == 0, there.stdout[-500:] + there.stderr
    assert there.stdout.splitlines() == here.stdout.splitlines()
    kinds = {line.split()[0] for line in there.stdout.splitlines()}
    assert {"first", "second", "state", "directional", "adjoint"} <= kinds
