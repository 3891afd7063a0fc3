"""Native FMUs in C hosts, here and on Windows as far as wine is one: bits, and where files are.

The bits of this machine, value by value; URIs and paths of Linux and of Windows, any folder.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import pytest
from support.c_fmus.compiled import FMI_HEADERS
from support.c_programs import (
    compiled_for_windows,
    compiled_here,
    run_here,
    run_on_windows,
    windows_path,
)
from support.chains import hanging_chain
from support.driven import driven, fragile
from support.flap_file import TEXT, WAVE
from support.runtime_programs import every_operation

from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.description import with_rates
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program
from m4e_fmi.runtime.compiler import SHELL_SOURCES, SOURCES
from m4e_fmi.runtime.platforms import PLATFORMS, packaged

SUPPORT = Path(__file__).parents[1] / "support"
INCLUDES = tuple(f"-I{p}" for p in (SHELL_SOURCES, SOURCES, FMI_HEADERS, SUPPORT))
STEPS, H = 60, 0.02
FOLDER = "a b é # % ü+;&(x)"
EVERYWHERE = {
    "file:///a/b": "/a/b/f",
    "file:////a/b": "//a/b/f",
    "file:/a/b/": "/a/b/f",
    "file://localhost/a": "/a/f",
    "file:///a%20b/%C3%A9%23%25": "/a b/é#%/f",
    "file:///a%2": "/a%2/f",
    "file:///100%zz": "/100%zz/f",
    "/plain/100%41": "/plain/100%41/f",
}
LINUX = {**EVERYWHERE, "file://machine/a": "/a/f"}
WINDOWS = {
    **EVERYWHERE,
    "file:///C:/a/b": "C:/a/b/f",
    "file:/C:/a": "C:/a/f",
    "file://localhost/C:/a": "C:/a/f",
    "file://machine/share/a": "//machine/share/a/f",
    "file:////machine/share/a": "//machine/share/a/f",
    "C:\\a\\b": "C:\\a\\b/f",
}


@dataclass(frozen=True)
class Hosts:
    """The same program in C for this machine and for Windows, and its files there."""

    folder: Path
    source: Path
    flags: tuple[str, ...] = INCLUDES

    def compiled(self, system: str) -> Path:
        made = self.folder / ("host" if system == "linux" else "host.exe")
        if made.exists():
            return made
        if system == "linux":
            return compiled_here(self.source, made, flags=self.flags)
        if packaged("fmi", PLATFORMS["x86_64-windows"]) is None and self.flags == INCLUDES:
            pytest.skip("no library of native FMUs for Windows here: make platforms")
        return compiled_for_windows(self.source, made, flags=self.flags)

    def lines(self, system: str, words: list[str]) -> list[str]:
        """What it prints."""
        run = run_here if system == "linux" else run_on_windows
        done = run(self.compiled(system), words)
        assert done.returncode == 0, done.stdout[-500:] + done.stderr
        return done.stdout.splitlines()


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    return Hosts(tmp_path_factory.mktemp("hosts"), SUPPORT / "fmu_host.c")


@pytest.fixture(scope="module")
def host_3(tmp_path_factory: pytest.TempPathFactory) -> Hosts:
    return Hosts(tmp_path_factory.mktemp("hosts_3"), SUPPORT / "fmu3_host.c")


@pytest.mark.parametrize(("system", "expected"), [("linux", LINUX), ("windows", WINDOWS)])
def test_paths(system: str, expected: dict[str, str], tmp_path: Path) -> None:
    files = (*INCLUDES, str(SHELL_SOURCES / "files.c"))
    found = Hosts(tmp_path, SUPPORT / "file_paths.c", files).lines(system, list(expected))
    assert dict(zip(expected, found, strict=True)) == expected


@pytest.mark.parametrize("system", ["linux", "windows"])
def test_any_folder(host: Hosts, system: str, tmp_path: Path) -> None:
    """That nobody may write to, under a name that needs encoding; resources by URI or path."""
    path = build_fmu(driven(), tmp_path / "driven.fmu", native=True)
    unpacked = tmp_path / FOLDER
    host.compiled(system)
    fmpy.extract(str(path), str(unpacked))
    for place in (*unpacked.rglob("*"), unpacked):
        place.chmod(0o555 if place.is_dir() else 0o444)
    resources = unpacked / "resources"
    uri, library, folder = resources.as_uri(), "", str(resources)
    if system == "linux":
        [found] = (unpacked / "binaries" / "linux64").iterdir()
        library = str(found)
    else:  # the host of this test opens libraries by plain names only
        [found] = (unpacked / "binaries" / "win64").iterdir()
        (tmp_path / "driven.dll").write_bytes(found.read_bytes())
        library, folder = windows_path(tmp_path / "driven.dll"), windows_path(resources)
        uri = uri.replace("file:///", "file:///Z:/")
    guid = str(fmpy.read_model_description(str(unpacked)).guid)
    for given in (uri, folder):
        lines = host.lines(system, [library, given, guid, "10", "4", "2", "4", "0.01"])
        assert sum(line.startswith("second") for line in lines) == 6


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


def lines(host: Hosts, program: Program, folder: Path) -> tuple[list[str], list[str]]:
    """What the host prints here and on Windows."""
    host.compiled("windows")
    fmu, unpacked = build_fmu(program, folder / "model.fmu", native=True), folder / "unpacked"
    fmpy.extract(str(fmu), str(unpacked))
    guid = fmpy.read_model_description(str(fmu)).guid or ""
    uri = (unpacked / "resources").as_uri()
    [library] = (unpacked / "binaries" / "linux64").iterdir()
    here = host.lines("linux", words(program, guid, uri, str(library)))
    [library] = (unpacked / "binaries" / "win64").iterdir()
    uri = uri.replace("file:///", "file:///Z:/")
    return here, host.lines("windows", words(program, guid, uri, windows_path(library)))


def operations(_: Path) -> Program:
    return every_operation()


@pytest.mark.parametrize("make", [chain, flap, operations])
def test_the_bits_of_this_machine(
    host: Hosts, make: Callable[[Path], Program], tmp_path: Path
) -> None:
    """Values, logged messages, states as bytes, and what follows a restored state."""
    here, there = lines(host, make(tmp_path), tmp_path)
    for ours, theirs in zip(here, there, strict=True):
        assert theirs == ours
    assert sum(line.startswith("log host 3 logStatusError") for line in there) == 1
    second = [line for line in there if line.startswith("second")]
    assert len(second) == 3 * (STEPS // 2)
    assert second[: STEPS // 2] * 3 == second


def test_discard(host: Hosts, tmp_path: Path) -> None:
    """x' = rate·x² has no state beyond some time; both say the same one."""
    here, there = lines(host, fragile(), tmp_path)
    assert there == here
    assert any(line.startswith("reached") for line in there)
    assert any(line.startswith("log host 2 logStatusDiscard") for line in there)


def listed(variables: list[Any]) -> list[str]:
    """Value references with commas, and the number of scalars."""
    scalars = sum(math.prod(v.shape or ()) for v in variables)
    return [",".join(str(v.valueReference) for v in variables), str(scalars)]


@pytest.mark.parametrize("make", [chain, flap, operations])
def test_the_bits_of_this_machine_by_fmi_3(
    host_3: Hosts, make: Callable[[Path], Program], tmp_path: Path
) -> None:
    """Values, times reached, states as bytes, what follows a restored state, derivatives."""
    host_3.compiled("windows")
    fmu = build_fmu(make(tmp_path), tmp_path / "model.fmu", native=True, fmi="3")
    unpacked = tmp_path / "unpacked"
    fmpy.extract(str(fmu), str(unpacked))
    description: Any = fmpy.read_model_description(str(fmu))
    reals = [v for v in description.modelVariables if v.type == "Float64"]
    inputs, outputs = ([v for v in reals if v.causality == c] for c in ("input", "output"))
    more = [*listed(reals), *listed(inputs), *listed(outputs), str(STEPS), str(H)]
    resources, token = str(unpacked / "resources"), str(description.guid)
    [library] = (unpacked / "binaries" / "x86_64-linux").iterdir()
    here = host_3.lines("linux", [str(library), f"{resources}/", token, *more])
    [library] = (unpacked / "binaries" / "x86_64-windows").iterdir()
    place = windows_path(unpacked / "resources") + "\\"
    there = host_3.lines("windows", [windows_path(library), place, token, *more])
    assert there == here
    kinds = {line.split()[0] for line in there}
    assert {"first", "second", "state", "directional", "adjoint"} <= kinds
