"""Faults of one line, planted in a copy of the tree: the tests named with each must fail.

A survivor is a loose bound of a test: mend the test. That each fault still has its place is checked
by `tests/unit/test_planted_faults.py`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.planted_faults import FAULTS

ROOT = Path(__file__).parents[2]
PARTS = ("m4e_fmi", "adapters", "fmus", "tests", "examples", "docs", "pyproject.toml")
LEFT_OUT = shutil.ignore_patterns("__pycache__", "build", "generated", "*.fmu", "benchmark")
LONGEST = 900.0
"""Seconds for the tests of one fault."""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the source tree."""
    copy = tmp_path_factory.mktemp("tree")
    for part in PARTS:
        source = ROOT / part
        if source.is_dir():
            shutil.copytree(source, copy / part, ignore=LEFT_OUT)
        else:
            shutil.copy(source, copy)
    return copy


def outcome(tree: Path, tests: str) -> subprocess.CompletedProcess[str]:
    """Exit code and output of pytest in the copy, up to the first failure."""
    paths = [str(tree / "tests" / name) for name in tests.split()]
    packages = os.pathsep.join(str(tree / part) for part in (".", "adapters", "fmus"))
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", *paths],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": packages},
        capture_output=True,
        text=True,
        timeout=LONGEST,
    )


@pytest.mark.parametrize("tests", sorted({fault.tests for fault in FAULTS.values()}))
def test_without_a_fault_the_tests_pass(tree: Path, tests: str) -> None:
    done = outcome(tree, tests)
    assert done.returncode == pytest.ExitCode.OK, done.stdout


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_noticed(tree: Path, name: str) -> None:
    fault = FAULTS[name]
    file = fault.file(tree)
    text = file.read_text("utf-8")
    file.write_text(text.replace(fault.original, fault.planted), "utf-8")
    try:
        assert outcome(tree, fault.tests).returncode == pytest.ExitCode.TESTS_FAILED
    finally:
        file.write_text(text, "utf-8")
