"""An algorithm is one file with one descriptor: nothing else knows its name."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import m4e_fmi
from m4e_fmi.cli import main
from m4e_fmi.coupling_algorithms import (
    DEFAULT_ALGORITHM,
    FOLDERS,
    PACKAGE,
    algorithm_descriptor,
    algorithm_names,
)
from m4e_fmi.errors import InputError

ROOT = Path(__file__).parents[4]
EXAMPLE = "extrapolated_jacobi"
STOP, STEPS = 10.0, (0.1, 0.05, 0.025)
POSITION = (np.cos(STOP) + np.cos(np.sqrt(3.0) * STOP)) / 2
"""Exact position of the first of two unit masses and springs, released at 1 m [m]."""


@pytest.fixture
def example() -> Iterator[None]:
    """The folder of `tests/support/algorithms` as one of the folders of algorithms."""
    folder = str(ROOT / "tests" / "support" / "algorithms")
    FOLDERS.append(folder)
    yield
    FOLDERS.remove(folder)
    sys.modules.pop(f"{PACKAGE}.{EXAMPLE}", None)


def system_file(c_fmu: Callable[[str], Path], folder: Path, step: float) -> Path:
    """A two-mass oscillator that is coupled by the example."""
    file = folder / "system.yaml"
    file.write_text(
        "name: two masses\ncomponents:\n"
        f"  a: {{fmu: {c_fmu('mass')}, start: {{stiffness: 1.0, body.m.x: 1.0}}}}\n"
        f"  b: {{fmu: {c_fmu('partner')}}}\n"
        "connections: [a.m <-> b.end]\n"
        f"simulation: {{stop_time: {STOP}, step_size: {step}, algorithm: {EXAMPLE}}}\n"
    )
    return file


@pytest.mark.usefixtures("example")
def test_a_new_algorithm_is_one_file(
    c_fmu: Callable[[str], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    errors = []
    for step in STEPS:
        results = tmp_path / "r.nc"
        outcome = m4e_fmi.run(system_file(c_fmu, tmp_path, step), results=results)
        assert outcome.order == 2
        errors.append(abs(outcome.results()["a.body.m.x"].values[-1] - POSITION))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.2)  # 0.2: terms of the next order
    file = str(system_file(c_fmu, tmp_path, STEPS[-1]))
    command = ["run", file, "--output-file", str(tmp_path / "cli.nc"), "--algorithm", EXAMPLE]
    assert main(command) == 0
    found = m4e_fmi.load(tmp_path / "cli.nc")["a.body.m.x"].values
    assert abs(found[-1] - POSITION) == errors[-1]
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    assert EXAMPLE in capsys.readouterr().out


def test_it_is_unknown_without_its_file(c_fmu: Callable[[str], Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"unknown algorithm '{EXAMPLE}'"):
        m4e_fmi.load_system(system_file(c_fmu, tmp_path, 0.1))


@pytest.mark.parametrize("name", algorithm_names())
def test_descriptors_are_those_of_their_files(name: str) -> None:
    assert algorithm_descriptor(name).name == name


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
        loops = "within steps too" if one.solves_loops else "at communication points"
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
