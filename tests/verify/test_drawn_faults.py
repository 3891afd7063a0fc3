"""Faults drawn from all statements of the product: the nearest tests must notice nearly all.

``M4E_FMI_SEED`` draws others. A survivor that changes what users see wants a test.
"""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from support import check
from support.drawn_faults import draw
from support.planted_faults import copy_tree, outcome

ROOT = Path(__file__).parents[2]
SEED = int(os.environ.get("M4E_FMI_SEED", "42"))
COUNT, MOST_SURVIVORS = 40, 3
MOST_FILES = 20
"""Test files for a fault, the nearest ones; the wrong inputs of tests/corpus come after them."""

FAILING = re.compile(r"^(?:FAILED|ERROR) ([^ :]+)", re.MULTILINE)
"""The file of a test in the summary."""


def test_drawn_faults_are_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree = copy_tree(ROOT, tmp_path)
    survivors: list[str] = []
    for fault in draw(tree, COUNT, SEED):
        nearest = check.tests_of([fault.path])[:MOST_FILES]
        text = fault.plant(tree)
        try:
            files = [*(str(test.relative_to("tests")) for test in nearest), "corpus"]
            done = outcome(tree, " ".join(files))
            died = done.returncode in (pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.INTERRUPTED)
            failing = {Path(name) for name in FAILING.findall(done.stdout)}
        except subprocess.TimeoutExpired:
            died, failing = True, set[Path]()
        (tree / fault.path).write_text(text, "utf-8")
        for test in failing:  # without the fault they pass
            assert outcome(tree, str(test.relative_to("tests"))).returncode == pytest.ExitCode.OK
        with capsys.disabled():
            print(f"seed {SEED}: {'noticed ' if died else 'SURVIVED'} {fault}", flush=True)
        survivors += [] if died else [str(fault)]
    assert len(survivors) <= MOST_SURVIVORS, survivors
