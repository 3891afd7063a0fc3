"""Files of others: every MoorDyn file of a folder is started, stepped, and taken back.

The folder is in the environment variable MOORDYN_FILES; those of MoorDyn's own tests and examples
are in its public repository. A process each: MoorDyn may end one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.lines_in_waves import started

from m4e_adapters.moordyn import ready_mooring
from m4e_fmi.errors import InputError

FOLDER = os.environ.get("MOORDYN_FILES")
SUFFIXES = (".txt", ".dat")
SHARE = 0.88  # of the files that are to run: 38 of the 43 of MoorDyn's repository
LONGEST = 300.0  # [s] a file
STEPS, STEP = 10, 0.01  # number, [s]
DEPTH = 50.0  # [m] where a file leaves it to OpenFAST
NO_FILE = "LINES is missing"  # of what is no MoorDyn file


def run_file(path: Path) -> str:
    """What became of a file: 'ran', with notes, or the first line of each problem."""
    begun = time.perf_counter()
    try:
        made = ready_mooring(path, fairleads={}, in_space=True)
    except InputError as error:
        if not any("WtrDpth, is missing" in problem.message for problem in error.problems):
            raise
        made = ready_mooring(path, fairleads={}, water={"depth": DEPTH}, in_space=True)
    lines = started(made)
    rest = [(0.0, 0.0, 0.0)] * len(made.fairleads)
    places = [fairlead.place for fairlead in made.fairleads]
    begins, saved = lines.force, lines.save()
    found = []
    for _ in range(2):
        for k in range(STEPS):
            lines.advance(k * STEP, STEP, places, rest)
        found.append((lines.force, lines.tensions(), lines.save()["system"]))
        lines.restore(saved)
        assert lines.force == begins
    assert found[0] == found[1] or made.no_way_back, "another way after it was taken back"
    warnings = [text for text in lines.warnings if text not in made.notes]
    lines.close()
    return f"ran, {time.perf_counter() - begun:.1f} s; {'; '.join((*made.notes, *warnings))}"


def result_of(path: Path) -> str:
    """What `run_file` says in a process of its own."""
    command = [sys.executable, __file__, str(path)]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=LONGEST, env=environment, check=False
        )
    except subprocess.TimeoutExpired:
        return f"has not ended after {LONGEST:g} s"
    said = (done.stdout or done.stderr).strip().splitlines()
    return said[-1] if said else f"ended with {done.returncode}"


@pytest.mark.skipif(not FOLDER, reason="MOORDYN_FILES names no folder")
def test_published_files_run_as_they_are() -> None:
    assert FOLDER
    files = [path for path in sorted(Path(FOLDER).rglob("*")) if path.suffix in SUFFIXES]
    files = [path for path in files if "@" not in path.read_text("latin-1")]  # templates
    results = {path: result_of(path) for path in files}
    results = {path: text for path, text in results.items() if NO_FILE not in text}
    for path, text in results.items():
        print(f"{path.relative_to(FOLDER)}: {text}")
    ran = [text.startswith("ran") for text in results.values()]
    print(f"{sum(ran)} of {len(ran)} ran")
    assert sum(ran) >= SHARE * len(ran)


if __name__ == "__main__":
    try:
        print(run_file(Path(sys.argv[1])))
    except InputError as error:
        print("refused: " + " | ".join(problem.message for problem in error.problems))
    except Exception as error:  # noqa: BLE001  # the table is of whatever happens
        print(f"failed: {type(error).__name__}: {' '.join(str(error).split())}")
