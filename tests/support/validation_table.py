"""docs/validation.md from the tests: what each verifies, against what, how closely.

A test, or a class of tests, says so in a marker:

    @pytest.mark.verifies("periods over 80 s", published="paper, table 11", tolerance="1e-4")

with one of `analytic`, `published` (a citation) and `independent` (another code or formulation) as
its source. The tolerance is "identical", or a number that the test contains, or one of the support
modules that it imports ("1e-8 rad", "order 2 ± 0.1"): who loosens a test has to change the marker.
Markers are read from the sources, so their arguments are literal.

`pytest --update tests/unit/test_validation_table.py` writes the page anew.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass
from pathlib import Path

TESTS = Path(__file__).parents[1]
PAGE = TESTS.parent / "docs" / "validation.md"
FOLDERS = {"verification": "Cases", "property": "Random systems"}
SOURCES = {
    "analytic": "analytic",
    "published": "published",
    "independent": "independent code",
}
SPELLING = {
    "cosim": "co-simulation",
    "lagrange": "by Lagrange",
    "paper": "the paper's",
    "ssp": "SSP",
}
IDENTICAL = "identical"
TOLERANCE = re.compile(r"(?:.* ± )?(\d+(?:\.\d+)?(?:e-?\d+)?)")
HEAD = """\
# Validation

All verified results, with their references and tolerances. This page is made from the markers of
the tests and compared with them in every test run; tolerances are those that the tests assert,
relative unless they have a unit. `make test` measures all of it.

*Analytic*: a solution, an identity or a balance from mathematics or mechanics; *published*: cited
figures or formulas; *independent code*: another program, or another formulation written for the
test alone.
"""


class MarkerError(Exception):
    """A marker does not say what it should, or a test has none."""


@dataclass(frozen=True)
class Claim:
    """One row of the table: `what` is verified against `source`, of a `kind` of SOURCES."""

    what: str
    kind: str
    source: str
    tolerance: str


@dataclass(frozen=True)
class Module:
    """A file of tests with its claims."""

    path: Path
    summary: str
    claims: tuple[Claim, ...]

    @property
    def title(self) -> str:
        words = self.path.stem.removeprefix("test_").split("_")
        text = " ".join(SPELLING.get(word, word) for word in words)
        return text[0].upper() + text[1:]


def modules(folder: Path) -> list[Module]:
    """The files of tests in a folder; MarkerError with all problems of all of them."""
    found, problems = [], []
    for path in sorted(folder.glob("test_*.py")):
        try:
            found.append(read_module(path))
        except MarkerError as error:
            problems.append(str(error))
    if problems:
        raise MarkerError("\n".join(problems))
    return found


def read_module(path: Path) -> Module:
    """The claims of one file of tests; MarkerError if it has none."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    numbers = _numbers(tree)
    claims, problems = [], []
    for call in _markers(tree):
        try:
            claims.append(_claim(call, numbers))
        except MarkerError as error:
            problems.append(f"{path.name}:{call.lineno}: {error}")
    if not claims and not problems:
        problems.append(f"{path.name}: say what it verifies: @pytest.mark.verifies(…)")
    if problems:
        raise MarkerError("\n".join(problems))
    summary = (ast.get_docstring(tree) or "").split("\n\n")[0]
    return Module(path, " ".join(summary.split()), tuple(claims))


def _markers(tree: ast.Module) -> list[ast.Call]:
    """The markers `verifies` on tests and classes of tests, in the order of the file."""
    tests = (n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.ClassDef))
    marks = (mark for test in tests for mark in test.decorator_list)
    calls = (m for m in marks if isinstance(m, ast.Call))
    found = [call for call in calls if ast.unparse(call.func) == "pytest.mark.verifies"]
    return sorted(found, key=lambda call: call.lineno)


def _claim(call: ast.Call, numbers: set[float]) -> Claim:
    try:
        (what,) = (ast.literal_eval(argument) for argument in call.args)
        said = {str(k.arg): ast.literal_eval(k.value) for k in call.keywords}
        tolerance = said.pop("tolerance")
        ((kind, source),) = said.items()
        claim = Claim(what, SOURCES[kind], source, tolerance)
    except (ValueError, KeyError):
        form = f"verifies('what', {' | '.join(SOURCES)}='…', tolerance='…')"
        raise MarkerError(f"a marker is {form}, of texts") from None
    if tolerance != IDENTICAL and not _is_asserted(tolerance, numbers):
        message = f"the tolerance {tolerance!r} is not {IDENTICAL!r} and no number of the test"
        raise MarkerError(message)
    return claim


def _is_asserted(tolerance: str, numbers: set[float]) -> bool:
    number = TOLERANCE.match(tolerance)
    return bool(number) and float(number[1]) in numbers


def _numbers(tree: ast.Module) -> set[float]:
    """The numbers in a file of tests and in the support modules that it imports."""
    imports = (n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom))
    names = [str(n.module) for n in imports if str(n.module).startswith("support.")]
    files = [TESTS.joinpath(*name.split(".")).with_suffix(".py") for name in names]
    trees = [tree, *(ast.parse(f.read_text(encoding="utf-8")) for f in files if f.is_file())]
    nodes = (n for each in trees for n in ast.walk(each) if isinstance(n, ast.Constant))
    return {float(n.value) for n in nodes if isinstance(n.value, int | float)}


def page() -> str:
    """The text of docs/validation.md; MarkerError with all that markers lack."""
    parts = [HEAD]
    for folder, title in FOLDERS.items():
        parts.append(f"## {title}\n")
        for module in modules(TESTS / folder):
            parts.append(f"### {module.title}\n\n{module.summary}\n")
            parts.append("| verified | against | kind | tolerance |\n|---|---|---|---|")
            parts.extend(
                f"| {c.what} | {c.source} | {c.kind} | {c.tolerance} |" for c in module.claims
            )
            parts.append(f"\n`tests/{folder}/{module.path.name}`\n")
    return "\n".join(parts)
