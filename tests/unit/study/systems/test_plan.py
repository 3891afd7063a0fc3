"""Keys of kept runs: what is other than in a kept run is never taken for it."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.small_study import SYSTEM, Here, written_study

from m4e_fmi.code_hash import package_hash
from m4e_fmi.study import run_study

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
    outputs = {"y": "1"}

    def step(self, t, h, v):
        return {"y": helper_of_own.value()}
"""
HELPER = "import second_of_own\n\n\ndef value():\n    return second_of_own.VALUE\n"


def test_modules_that_python_code_leads_to_are_part_of_the_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They do not travel in the FMU, whose content stays as it is."""
    modules = tmp_path / "modules"
    modules.mkdir()
    monkeypatch.syspath_prepend(modules)
    system = SYSTEM.replace("  push:", "  own: {kind: python, file: own.py}\n  push:")
    study = written_study(tmp_path, STUDY, system=system)
    (tmp_path / "own.py").write_text(OWN, "utf-8")
    (modules / "helper_of_own.py").write_text(HELPER, "utf-8")
    kept = []
    for value in (1, 25, 25):
        (modules / "second_of_own.py").write_text(f"VALUE = {value}\n", "utf-8")
        package_hash.cache_clear()  # as another process would find it
        outcome = run_study(study, build_directory=tmp_path / "build", executor=Here())
        assert not outcome.failures
        kept.append(outcome.kept)
    package_hash.cache_clear()
    assert kept == [0, 0, 1]
