"""Where native FMUs find their resources: URIs and paths of Linux and of Windows, any folder."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from support.c_programs import (
    compiled_for_windows,
    compiled_here,
    run_here,
    run_on_windows,
    windows_path,
)
from support.driven import driven

from m4e_fmi.fmu import build_fmu
from m4e_fmi.runtime.compiler import SHELL_SOURCES
from m4e_fmi.runtime.platforms import PLATFORMS, packaged

SUPPORT = Path(__file__).parents[1] / "support"
INCLUDES = ("-I", str(SHELL_SOURCES), "-I", str(SUPPORT))
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
Run = Callable[..., subprocess.CompletedProcess[str]]


def assert_paths(program: Path, run: Run, expected: dict[str, str]) -> None:
    done = run(program, list(expected))
    assert done.returncode == 0
    assert dict(zip(expected, done.stdout.splitlines(), strict=True)) == expected


FILES = (*INCLUDES, str(SHELL_SOURCES / "files.c"))


def test_paths_on_linux(tmp_path: Path) -> None:
    program = compiled_here(SUPPORT / "file_paths.c", tmp_path / "paths", flags=FILES)
    assert_paths(program, run_here, LINUX)


def test_paths_on_windows(tmp_path: Path) -> None:
    program = compiled_for_windows(SUPPORT / "file_paths.c", tmp_path / "paths.exe", flags=FILES)
    assert_paths(program, run_on_windows, WINDOWS)


@pytest.fixture
def unpacked(tmp_path: Path) -> Path:
    """An FMU in a folder that nobody may write to, under a name that needs encoding."""
    path = build_fmu(driven(), tmp_path / "driven.fmu", native=True)
    folder = tmp_path / FOLDER
    fmpy.extract(str(path), str(folder))
    for place in (*folder.rglob("*"), folder):
        place.chmod(0o555 if place.is_dir() else 0o444)
    return folder


def assert_steps(program: Path, run: Run, library: str, unpacked: Path, resources: str) -> None:
    guid = fmpy.read_model_description(str(unpacked)).guid
    done = run(program, [library, resources, str(guid), "10", "4", "2", "4", "0.01"])
    assert done.returncode == 0, done.stdout + done.stderr
    assert sum(line.startswith("second") for line in done.stdout.splitlines()) == 6


def test_any_folder_on_linux(unpacked: Path, tmp_path: Path) -> None:
    program = compiled_here(SUPPORT / "fmu_host.c", tmp_path / "host", flags=INCLUDES)
    [library] = (unpacked / "binaries" / "linux64").iterdir()
    for resources in ((unpacked / "resources").as_uri(), str(unpacked / "resources")):
        assert_steps(program, run_here, str(library), unpacked, resources)


def test_any_folder_on_windows(unpacked: Path, tmp_path: Path) -> None:
    if packaged("fmi", PLATFORMS["x86_64-windows"]) is None:
        pytest.skip("no library of native FMUs for Windows here: make platforms")
    program = compiled_for_windows(SUPPORT / "fmu_host.c", tmp_path / "host.exe", flags=INCLUDES)
    [library] = (unpacked / "binaries" / "win64").iterdir()
    # the host of this test opens libraries by plain names only
    plain = tmp_path / "driven.dll"
    plain.write_bytes(library.read_bytes())
    uri = (unpacked / "resources").as_uri()
    for resources in (uri.replace("file:///", "file:///Z:/"), windows_path(unpacked / "resources")):
        assert_steps(program, run_on_windows, windows_path(plain), unpacked, resources)
