"""Lint, types and tests of a change: the inner loop of `make check`, within a minute.

The change is the working tree against the last commit, or the last commit if nothing is changed.
Test files are those that import a changed module, directly or not, or name a changed data file. The
mirror of the module in tests/unit runs first, then the files from the nearest to the farthest;
after `SECONDS` in all no further test starts. The last lines say what did not run.

Modules that are found by name while the program runs (kinds of FMU, code inside FMUs) are not seen
as imports: `make test` runs everything.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import networkx as nx
import pytest
from support import import_graph

ROOT = Path(__file__).parents[2]
PACKAGES = {
    "m4e_fmi": ROOT / "m4e_fmi",
    "m4e_adapters": ROOT / "adapters" / "m4e_adapters",
    "m4e_fmus": ROOT / "fmus" / "m4e_fmus",
    "": ROOT / "tests",
}
SECONDS = 45.0
"""Time after which no test starts; one may last ten seconds, those that are longer are slow."""
MOST_FILES = 20
"""Test files that are collected."""
KINDS = ("unit", "corpus", "property", "golden", "conformance", "verification")


def changed_files() -> list[Path]:
    """Files of the change that exist, relative to the root."""
    tree = [*_git("diff", "--name-only", "HEAD"), *_git("ls-files", "-o", "--exclude-standard")]
    names = tree or _git("diff", "--name-only", "HEAD~1", "HEAD")
    return [Path(name) for name in sorted(set(names)) if (ROOT / name).is_file()]


def _git(*arguments: str) -> list[str]:
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def tests_of(changed: list[Path]) -> list[Path]:
    """Test files that a change can touch, the most telling first, relative to the root."""
    modules = import_graph.modules(PACKAGES)
    importers = import_graph.graph(modules).reverse()
    names = {file.relative_to(ROOT): name for name, file in modules.items()}
    tests = {name: file for file, name in names.items() if file.name.startswith("test_")}
    conftests = {file.parent: name for file, name in names.items() if file.name == "conftest.py"}
    importers.add_edges_from(
        (conftests[folder], name)
        for name, file in tests.items()
        for folder in file.parents
        if folder in conftests
    )
    importers.add_edges_from(  # what is imported by its name alone, as kinds and checks are
        (name, name.rpartition(".")[0])
        for name in modules.keys() - tests.keys()
        if "." in name and not importers.out_degree(name)
    )
    near: dict[Path, int] = {}
    for file in changed:
        if file in names:
            distances = nx.single_source_shortest_path_length(importers, names[file])
        else:
            distances = {name: 1 for name, test in tests.items() if _names(ROOT / test, file)}
        for name, distance in distances.items():
            if name in tests:
                near[tests[name]] = min(distance, near.get(tests[name], distance))
    mirrors = {_mirror(file) for file in changed}
    rooms = {part for file in changed for part in file.parts[2:-1]}

    def rank(file: Path) -> tuple[bool, bool, int, int, Path]:
        kind = file.parts[1]
        kinds = KINDS.index(kind) if kind in KINDS else len(KINDS)
        aside = file.parent not in mirrors and file not in changed
        return aside, not any(room in file.stem for room in rooms), near[file], kinds, file

    return sorted(near, key=rank)


def _names(test: Path, file: Path) -> bool:
    return file.name in test.read_text(encoding="utf-8")


def _mirror(file: Path) -> Path:
    """Folder of the unit tests of a module."""
    inside = {"m4e_fmi": 1, "adapters": 2, "fmus": 2}.get(file.parts[0], 0)
    above = file.parts[:1] if inside == 2 else ()
    return Path("tests", "unit", *above, *file.parts[inside:-1])


class _Limit:
    """A plugin that starts no test after the limit, and counts those that have not run."""

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        self.session, self.left = session, len(session.items)
        self.end = time.monotonic() + SECONDS

    def pytest_runtest_logfinish(self) -> None:
        self.left -= 1
        if time.monotonic() > self.end:
            self.session.shouldstop = f"the time for tests, {SECONDS:g} s, is over"


def main() -> int:
    """Exit code: 0 if all that ran has passed."""
    limit, changed = _Limit(), changed_files()
    print("changed:", *changed)
    tool = Path(sys.executable).parent
    lint = [["check", "."], ["format", "--check", "--quiet", "."]]
    codes = [subprocess.run([tool / "ruff", *how], cwd=ROOT).returncode for how in lint]
    types = subprocess.Popen([tool / "pyrefly", "check"], cwd=ROOT)
    files = tests_of(changed)
    chosen = files[:MOST_FILES]
    arguments = ["--rootdir", str(ROOT), "-m", "not verify and not slow", "--no-header"]
    if chosen:
        code = pytest.main([*arguments, *(str(ROOT / f) for f in chosen)], plugins=[limit])
        over = code == pytest.ExitCode.INTERRUPTED and limit.left and not limit.session.testsfailed
        codes.append(0 if over or code == pytest.ExitCode.NO_TESTS_COLLECTED else code)
    codes.append(types.wait())
    print(f"tests of {len(chosen)} files, without those marked slow")
    if chosen and limit.left:
        print(f"NOT RUN for lack of time: {limit.left} tests, the last ones of", *chosen[-1:])
    if files[MOST_FILES:]:
        print(
            f"NOT RUN: {len(files) - MOST_FILES} test files farther away, from", files[MOST_FILES]
        )
    return int(any(codes))


if __name__ == "__main__":
    sys.exit(main())
