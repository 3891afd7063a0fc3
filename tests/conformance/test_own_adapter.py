"""A package of somebody else brings its own kinds of FMU: examples/hydraulic_pto, installed by pip.

What docs/adapters.md tells of it is run and compared here.
"""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from doc_tools.run_page import run_page

from m4e_fmi import code_hash, doctor
from m4e_fmi.cosim import load_system, prepare, run
from m4e_fmi.cosim.preparation import components
from m4e_fmi.errors import RunError
from m4e_fmi.fmu import PythonSource, build_fmu, validate_fmu

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "hydraulic_pto"
PAGE = ROOT / "docs" / "adapters.md"
NAME = "hydraulic_pto"
VALUES = {"area": 0.02, "gas_volume": 0.2, "charge_pressure": 5e6, "conductance": 2.4e-9}


def forget() -> None:
    """Import the package anew next time, from where it is then."""
    for name in [n for n in sys.modules if n.partition(".")[0] == NAME]:
        del sys.modules[name]
    importlib.invalidate_caches()


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder that the package is installed into, found by Python while these tests run."""
    pytest.importorskip("hatchling", reason="pip builds the package with it")
    work, target = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("site")
    source = shutil.copytree(EXAMPLE, work / NAME)  # builds may leave files behind
    flags = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--target")
    command = [sys.executable, "-m", "pip", "install", *flags, target, source]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    sys.path.append(str(target))
    forget()
    yield target
    sys.path.remove(str(target))
    forget()


def python_source(package: Path) -> PythonSource:
    """What a copy of the package makes."""
    sys.path.insert(0, str(package.parent))
    forget()
    try:
        made = importlib.import_module(f"{NAME}.python_fmu")
        return made.KIND.build(made.KIND.config(rod="rod", **VALUES), name="hydraulics")
    finally:
        sys.path.remove(str(package.parent))
        forget()


@pytest.mark.usefixtures("site")
def test_it_is_found() -> None:
    found = {point.name for point in entry_points(group="m4e_fmi.fmus")}
    assert {"hydraulic_pto", "hydraulic_pto_scipy", "linear_pto"} <= found
    told = {finding.what: finding for finding in doctor.examine()}
    assert told["hydraulic_pto: scipy"].ok
    assert told["FMU kind hydraulic_pto"].detail == "hydraulic_pto.program_fmu"


@pytest.mark.usefixtures("site")
def test_the_page_shows_what_comes_out(tmp_path: Path) -> None:
    """`run_page` fails where a block does not give what the page shows."""
    run_page(PAGE, tmp_path / "page")


@pytest.mark.usefixtures("site")
def test_its_only_connection_is_missed_when_left_out(tmp_path: Path) -> None:
    system = load_system(EXAMPLE / "system.yaml")
    assert prepare(system, build_directory=tmp_path).warnings == ()
    (line,) = prepare(replace(system, connections=()), build_directory=tmp_path).warnings
    assert line == "float, hydraulics: no component is connected with another"


@pytest.mark.usefixtures("site")
def test_an_exception_ends_the_run_and_the_page_quotes_it(tmp_path: Path) -> None:
    system = load_system(EXAMPLE / "system_scipy.yaml").changed(start={"hydraulics.oil": 0.3})
    with pytest.raises(RunError) as caught:
        run(system, build_directory=tmp_path)
    assert caught.value.message in PAGE.read_text(encoding="utf-8")


def test_it_is_built_again_when_any_of_its_files_changes(site: Path, tmp_path: Path) -> None:
    def built() -> set[str]:
        told: list[str] = []
        code_hash.code_hash.cache_clear()
        code_hash.package_hash.cache_clear()
        components.fmu_files(load_system(EXAMPLE / "system.yaml"), tmp_path, tell=told.append)
        return {line.partition(":")[0] for line in told}

    assert built() == {"float", "hydraulics"}
    assert built() == set()
    changed = site / NAME / "circuit.py"
    text = changed.read_text()
    try:
        changed.write_text(f"{text}\n# changed")
        assert built() == {"hydraulics"}
    finally:
        changed.write_text(text)


DEFECTS = (  # file, what is there, what is there instead, what validate then finds
    ("slave.py", '"energy": self._accumulator.energy}', '"energy": 0.0}', "state.rollback"),
    ("accumulator.py", "self.oil = oil", "Accumulator.oil = oil", "instances.shared"),
    ("python_fmu.py", "dependencies=(speed,)", "dependencies=()", "dependencies.missing"),
)


@pytest.mark.parametrize(("file", "right", "wrong", "finding"), DEFECTS)
def test_what_validate_finds_of_mistakes(
    tmp_path: Path, file: str, right: str, wrong: str, finding: str
) -> None:
    """The table of the page; `test_the_page_shows_what_comes_out` has no finding."""
    package = shutil.copytree(EXAMPLE / NAME, tmp_path / NAME)
    text = (package / file).read_text()
    assert right in text
    (package / file).write_text(text.replace(right, wrong))
    fmu = build_fmu(python_source(package), tmp_path / "hydraulics.fmu")
    report = validate_fmu(fmu, only=[finding.partition(".")[0]])
    assert finding in {found.id for found in report.findings if found.severity == "error"}
    assert f"`{finding}`" in PAGE.read_text(encoding="utf-8")
