"""Keys of kept runs: what is other than in a kept run is never taken for it."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.small_study import SYSTEM, Here, written_study

from m4e_fmi.code_hash import package_hash
from m4e_fmi.study import run_study
from m4e_fmi.study.systems.plan import imports_of

STUDY = """\
name: carts
system: system.yaml
start_up: 0
simulation: {stop_time: 0.1}
vary: {cart.k: [30]}
wanted:
  y: {variable: own.y, statistic: maximum}
"""
OWN = """\
import helper_of_own


class Own:
    \"\"\"A value of a module beside the FMU.\"\"\"

    outputs = {"y": "1"}

    def step(self, t, h, v):
        return {"y": helper_of_own.value()}
"""


@pytest.fixture
def modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of local modules."""
    folder = tmp_path / "modules"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    yield folder
    package_hash.cache_clear()


def changed(module: Path, text: str) -> None:
    """Write a module as another process would find it."""
    module.write_text(text, "utf-8")
    package_hash.cache_clear()


def test_a_module_that_python_code_imports_is_part_of_the_key(
    tmp_path: Path, modules: Path
) -> None:
    """It does not travel in the FMU, whose content stays as it is."""
    system = SYSTEM.replace("  push:", "  own: {kind: python, file: own.py}\n  push:")
    study = written_study(tmp_path, STUDY, system=system)
    (tmp_path / "own.py").write_text(OWN, "utf-8")
    kept = []
    for value in (1, 25, 25):
        changed(modules / "helper_of_own.py", f"def value(): return {value}\n")
        outcome = run_study(study, build_directory=tmp_path / "build", executor=Here())
        assert not outcome.failures
        kept.append(outcome.kept)
    assert kept == [0, 0, 1]


def test_imports_of_an_fmu_lead_to_all_local_modules(tmp_path: Path, modules: Path) -> None:
    fmu = tmp_path / "x.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("resources/slave.py", "import math, first_of_x, numpy\nimport beside\n")
        archive.writestr("resources/user/beside.py", "")
    (modules / "first_of_x.py").write_text("import second_of_x\n", "utf-8")
    found = []
    for text in ("", "a = 1\n", ""):
        changed(modules / "second_of_x.py", text)
        changed(modules / "beside.py", f"other = {len(found)}\n")  # that in the FMU is used
        found.append(imports_of(fmu))
    assert found[0] == found[2] != found[1]
    with zipfile.ZipFile(tmp_path / "native.fmu", "w") as archive:
        archive.writestr("binaries/x.so", "")
    assert imports_of(tmp_path / "native.fmu") == ""


SEA = """\
class Sea:
    \"\"\"Waves that grow at first.\"\"\"

    parameters = {"ramp_time": (0.05, "s")}
    outputs = {"y": "1"}

    def step(self, t, h, v):
        return {"y": t}
"""


def test_a_start_up_that_ends_within_the_ramp_of_a_sea_is_warned_of(tmp_path: Path) -> None:
    system = SYSTEM.replace("  push:", "  own: {kind: python, file: own.py}\n  push:")
    (tmp_path / "own.py").write_text(SEA, "utf-8")
    warned = []
    for stated in ("start_up: 0.02\n", "start_up: 0.06\n"):
        text = STUDY.replace("start_up: 0\n", stated).replace("[30]", "[30, 40]")
        study = written_study(tmp_path, text, system=system)
        warned.append(run_study(study, build_directory=tmp_path / "build", executor=Here()))
    first, second = (
        {line: n for line, n in outcome.warnings.items() if "start_up" in line}
        for outcome in warned
    )
    assert not second
    assert first == {
        "start_up of 0.02 s ends within the ramp of the sea, of up to 0.05 s: statistics count "
        "waves that still grow; state more, or leave it out": 2
    }
