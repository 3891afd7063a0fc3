"""Programs in C: for this machine, and for Windows, compiled by ziglang and run by wine."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from m4e_fmi.runtime.compiler import cache_folder, compiler
from m4e_fmi.runtime.platforms import PLATFORMS

ROOT = Path(__file__).parents[2]
WINDOWS = PLATFORMS["x86_64-windows"]


def compiled_here(source: Path, target: Path, *, flags: Sequence[str] = ()) -> Path:
    """`source` as a program of this machine."""
    command = [*(compiler() or ["cc"]), "-O2", *flags, "-o", str(target), str(source), "-ldl"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return target


def run_here(program: Path, words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run([program, *words], capture_output=True, encoding="utf-8", check=False)


def zig() -> list[str]:
    """Command of the compiler; the test is skipped where there is none."""
    own = [sys.executable] if importlib.util.find_spec("ziglang") else []
    beside = ROOT / ".venv-platforms" / "bin" / "python"
    for python in [*own, *([str(beside)] if beside.exists() else [])]:
        return [python, "-m", "ziglang", "cc"]
    pytest.skip("no compiler for Windows here: make platforms")


def compiled_for_windows(source: Path, target: Path, *, flags: Sequence[str] = ()) -> Path:
    """`source` as a program of Windows."""
    command = [*zig(), "-target", WINDOWS.target, "-O2", *flags, "-o", str(target), str(source)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return target


def run_on_windows(program: Path, words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run a program of Windows; the test is skipped where there is no wine."""
    wine = shutil.which("wine")
    if wine is None:
        pytest.skip("no wine here")
    prefix = cache_folder() / "wine"
    prefix.parent.mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, "WINEPREFIX": str(prefix), "WINEDEBUG": "-all"}
    return subprocess.run(
        [wine, str(program), *words],
        capture_output=True,
        encoding="utf-8",
        check=False,
        env=environment,
    )


def windows_path(path: Path) -> str:
    """Name of `path` under wine."""
    return "Z:" + str(path).replace("/", "\\")
