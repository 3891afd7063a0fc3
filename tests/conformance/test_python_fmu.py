"""Python FMUs, as far as these differ: names, files, errors that stop them, what they leave."""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.fmu_instances import Instance, discarded
from support.fmu_programs import algebraic, tunable

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Recorder, Variable

Load = Callable[..., Instance]
Fmu = Callable[..., Path]


class TestBuilding:
    def test_the_file_is_replaced_as_a_whole_and_readable_by_others(self, tmp_path: Path) -> None:
        path = tmp_path / "a.fmu"
        path.write_bytes(b"old")
        mask = os.umask(0o022)
        try:
            build_fmu(algebraic(), path)
        finally:
            os.umask(mask)
        assert {file.name for file in tmp_path.iterdir()} == {"a.fmu", "a.build.json"}
        assert stat.S_IMODE(path.stat().st_mode) == 0o644

    @pytest.mark.parametrize("name", ["lambda", "M4eSlave", "None", "a b-c", "json"])
    def test_any_name_that_starts_with_a_letter(
        self, load: Load, tmp_path: Path, name: str
    ) -> None:
        path = build_fmu(tunable(name), tmp_path / "named.fmu")
        assert validate_fmu(str(path)) == []
        instance = load("python", path).initialise()
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(1 - math.exp(-2.0), abs=1e-7)

    @pytest.mark.parametrize(
        ("name", "output", "unit", "message"),
        [
            *((name, "y", "m", "cannot name an FMU") for name in ("", "2d", "été", "_a")),
            ("a", "last_error", "m", "every FMU has a variable 'last_error'"),
            ("a", "y", "furlong", "'furlong' is not a unit"),
        ],
    )
    def test_other_names_are_refused(
        self, tmp_path: Path, name: str, output: str, unit: str, message: str
    ) -> None:
        r = Recorder(name, "")
        r.output(Variable(output, unit, ""), 1.0)
        with pytest.raises((InputError, ValueError), match=message):
            build_fmu(r.program(), tmp_path / "named.fmu")
        assert not list(tmp_path.iterdir())

    def test_characters_that_xml_cannot_hold_are_replaced(self, tmp_path: Path) -> None:
        program = replace(tunable(), description="a\x07b\x01c\ufffe")
        path = build_fmu(program, tmp_path / "bell.fmu")
        description: Any = fmpy.read_model_description(str(path))
        assert description.description == "a\ufffdb\ufffdc\ufffd"


class TestErrors:
    """A failure is discard, a log message and a text; never fatal, never a crash."""

    def test_outputs_that_fail_stop_the_next_step(self, load: Load) -> None:
        instance = load("python", "fragile").initialise({"x": 3.0})
        instance.step(0.0, 0.125)
        instance.set({"rate": -1.0})
        assert math.isnan(instance["der(x)"])
        first = instance.last_error
        assert "der(x) is nan (t = 0.125 s)" in first
        instance.set({"rate": math.nan})  # as it comes back through other components
        assert instance.last_error == first
        for _ in range(3):
            discarded(lambda: instance.step(0.125, 0.5))
        errors = [text for status, text in instance.heard() if status == 3]
        assert len(errors) == 1
        assert any("Traceback" in text for status, text in instance.heard() if status == 0)
