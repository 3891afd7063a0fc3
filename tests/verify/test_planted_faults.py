"""Faults of one line, planted in a copy of the tree: the tests named with each must fail.

A survivor is a loose bound of a test: mend the test. That each fault still has its place is checked
by `tests/unit/test_planted_faults.py`.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.planted_faults import FAULTS, copy_tree, outcome

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the source tree."""
    return copy_tree(ROOT, tmp_path_factory.mktemp("tree"))


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
