"""Commands in folders of any name, and where a library or a binary is missing."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from m4e_fmi import load
from m4e_fmi.cli import main
from m4e_fmi.runtime.platforms import packaged_platforms

ROOT = Path(__file__).parents[2]
PENDULUM = ROOT / "examples/double_pendulum/double_pendulum.model.yaml"
MODEL = PENDULUM.name
SYSTEM = f"""\
name: alone
components: {{pendulum: {{model: {MODEL}}}}}
simulation: {{stop_time: 1, step_size: 0.1}}
"""
ODD = "a b é # % [x] 100%25 'q' &;+=ß漢"
COMMANDS = (
    ("build", MODEL),
    ("build", MODEL, "--native", "--build-folder", f"{ODD}/native"),
    ("build", "system.yaml", "--no-native"),
    ("simulate", MODEL, "--stop-time", "1", "--animate", f"{ODD}/#.html"),
    ("run", "system.yaml", "--report", f"{ODD}/# %41.html"),
    ("draw", MODEL, "--output-file", f"{ODD}/%.svg"),
    ("draw", MODEL, "--output-file", f"{ODD}/é.png"),
    ("run", "system.yaml", "--output-file", f"{ODD}/ä # %41.nc"),
    ("run", "system.yaml", "--no-native"),
    ("info", "build/double_pendulum.fmu"),
    ("info", f"{ODD}/native/double_pendulum.fmu"),
    ("validate", "build/double_pendulum.fmu", f"{ODD}/native/double_pendulum.fmu"),
)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of an odd name with a model and a system, where we are."""
    folder = tmp_path / ODD
    folder.mkdir()
    shutil.copy(PENDULUM, folder)
    (folder / "system.yaml").write_text(SYSTEM)
    monkeypatch.chdir(folder)
    return folder


def test_any_name(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of the project's folder, of files, of the folder for temporary files."""
    monkeypatch.setattr(tempfile, "tempdir", str(project))
    for command in COMMANDS:
        assert main(command) == 0, capsys.readouterr().err
    there = {p.relative_to(project).as_posix() for p in project.rglob("*") if p.is_file()}
    assert {f"{ODD}/{name}" for name in ("#.html", "%.svg", "é.png", "ä # %41.nc")} <= there
    assert {"build/double_pendulum.nc", "build/alone.nc", "build/alone.png"} <= there


RUN_TO_CSV = ("run", "system.yaml", "--output-file", "r.csv")
ELSEWHERE = """\
import sys
sys.modules["{missing}"] = None
from m4e_fmi import load
from m4e_fmi.cli import main
sys.exit(main(sys.argv[1:]))
"""


def without(missing: str, *command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command in a process that cannot import the module `missing`."""
    return subprocess.run(
        [sys.executable, "-c", ELSEWHERE.format(missing=missing), *command],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_without_moordyn(tmp_path: Path) -> None:
    """The FMU is built where MoorDyn is not; running it says what to install."""
    system = ROOT / "examples/flexible_pendulum/system.yaml"
    words = ("--build-folder", str(tmp_path), "--output-file", str(tmp_path / "r.nc"))
    done = without("moordyn", "run", str(system), *words)
    assert done.returncode == 1
    assert "MoorDyn is not installed for" in done.stderr
    assert "pip install moordyn==2.7.2" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.skipif(bool(packaged_platforms()), reason="libraries come with this installation")
def test_without_library_and_compiler(project: Path) -> None:
    """Native FMUs cannot be had, nor couplings, nor simulations."""
    nothing = {"M4E_FMI_CACHE": str(project / "none"), "PATH": str(project), "CC": ""}
    done = without("ziglang", "build", MODEL, "--native", **nothing)
    assert done.returncode == 1
    assert "there is no library for native FMUs" in done.stderr
    assert "install a C compiler" in done.stderr
    done = without("ziglang", "run", "system.yaml", **nothing)
    assert done.returncode == 1
    assert (
        "the C library, which runs programs and FMUs, cannot be had: no C compiler" in done.stderr
    )
    assert "install a C compiler, or `pip install ziglang`" in done.stderr
    assert "Traceback" not in done.stderr
    done = without("ziglang", "simulate", MODEL, "--stop-time", "0.1", "--no-plot", **nothing)
    assert done.returncode == 1
    assert "install a C compiler" in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@pytest.mark.parametrize("words", [("info", MODEL), (*RUN_TO_CSV, "--events")], ids=" ".join)
def test_an_output_that_is_full(words: tuple[str, ...], project: Path) -> None:
    """It is said, and a run keeps its results."""
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-c", ELSEWHERE.format(missing="none"), *words]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert "failed: the standard output cannot be written: No space left" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.returncode == 1
    if words[0] == "run":
        assert load(project / "r.nc").attributes["ended"] == "at the stop time"
        assert {path.name for path in project.glob("r.*")} == {"r.nc", "r.csv", "r.png"}


@pytest.mark.skipif(os.name == "nt", reason="the shell's words for it")
def test_standard_streams_that_are_closed(project: Path) -> None:
    """Nor does what the run opens take their numbers, which FMUs write to."""
    code = ELSEWHERE.format(missing="none")
    command = ["sh", "-c", 'exec "$0" "$@" <&- >&- 2>&-', sys.executable, "-c", code]
    done = subprocess.run([*command, *RUN_TO_CSV], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Error" not in done.stderr
    assert {path.name for path in project.glob("r.*")} == {"r.nc", "r.csv", "r.png"}
