"""An algorithm is one file with one descriptor: nothing else knows its name."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cli import main
from m4e_fmi.coupling_algorithms import (
    DEFAULT_ALGORITHM,
    LinkDelay,
    algorithm_descriptor,
    algorithm_names,
)

ROOT = Path(__file__).parents[4]
EXAMPLE = "last_first"


def arguments(c_fmu: Callable[[str], Path], folder: Path) -> list[str]:
    """A command that runs an FMU by the example; all else about it asks `test_contract.py`."""
    file = folder / "system.yaml"
    file.write_text(
        f"name: one\ncomponents:\n  a: {{fmu: {c_fmu('mass')}}}\n"
        "simulation: {stop_time: 1, step_size: 0.1}\n"
    )
    results = str(folder / "r.nc")
    return [
        "run",
        str(file),
        "--output-file",
        results,
        "--no-plot",
        "--verbose",
        "--algorithm",
        EXAMPLE,
    ]


@pytest.mark.usefixtures("example")
def test_a_new_algorithm_is_one_file(
    c_fmu: Callable[[str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments(c_fmu, tmp_path)) == 0
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    assert EXAMPLE in capsys.readouterr().out


def test_names_are_spelt_in_their_files_only() -> None:
    spelt = re.compile(rf"""["']({"|".join(algorithm_names())})\b""")
    own = {ROOT / "m4e_fmi" / "cosim" / "algorithms" / f"{name}.py" for name in algorithm_names()}
    found = [
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / "m4e_fmi").rglob("*.py")
        if file not in own and spelt.search(file.read_text("utf-8"))
    ]
    assert found == ["m4e_fmi/coupling_algorithms.py"]
    assert DEFAULT_ALGORITHM in algorithm_names()


def table() -> str:
    """The table of docs/coupling.md."""
    lines = [
        "| algorithm | in a step | order | inputs | algebraic loops | FMUs |",
        "|---|---|---|---|---|---|",
    ]
    for one in map(algorithm_descriptor, algorithm_names()):
        loops = "at communication points"
        if one.link_delay is LinkDelay.SOLVED:
            loops = "within steps too"
        rollback = "all must be able to go back" if one.needs_rollback else "any"
        lines.append(
            f"| `{one.name}` | {one.summary} | {one.order} | {one.link_delay.value} | {loops} "
            f"| {rollback} |"
        )
    return "\n".join(lines)


def test_the_docs_have_the_descriptors(request: pytest.FixtureRequest) -> None:
    page = ROOT / "docs" / "coupling.md"
    text = page.read_text("utf-8")
    start = text.index("| algorithm | in a step |")
    expected = text[:start] + table() + text[text.index("\n\n", start) :]
    if request.config.getoption("--update"):
        page.write_text(expected, encoding="utf-8")
        text = expected
    assert text == expected
