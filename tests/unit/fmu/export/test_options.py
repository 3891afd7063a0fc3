"""Options of `build_fmu`, and which outputs and names an FMU has by them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support.driven import driven

from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import ModelDescription, PythonSource, build_fmu
from m4e_fmi.fmu.export.description import with_rates
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.program import Program

SOURCE = PythonSource(ModelDescription("p", "p", ()), "slave:Slave", {}, {})


def names(program: Program) -> list[str]:
    return [v.name for v in program.outputs]


@pytest.mark.parametrize(
    ("source", "options", "message"),
    [
        (driven(), {"fmi": "4", "native": True}, "there is no FMI version '4'"),
        (driven(), {"sources": True}, "C sources are for native"),
        (driven(), {"stop_time": float("inf")}, "the stop time must be positive, got inf"),
        (driven(), {"step_size": float("nan")}, "the step size must be positive"),
        (driven(), {"documentation": {"resources/model.m4e": b""}}, "not a place for doc"),
        (SOURCE, {"native": True}, "cannot be a native FMU"),
        (SOURCE, {"outputs": ["*"]}, "is Python code"),
        (SOURCE, {"method": "rk45"}, "is Python code"),
    ],
)
def test_options_that_are_refused(
    tmp_path: Path, source: Any, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        build_fmu(source, tmp_path / "p.fmu", **options)
    with pytest.raises(InputError) as caught:
        build_fmu(driven(), tmp_path / "p.fmu", method="euler", step_size=0.0)
    assert len(caught.value.problems) == 2
    assert not list(tmp_path.iterdir())


def test_without_a_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path))
    monkeypatch.setattr("m4e_fmi.runtime.compiler.compiler", lambda: None)
    monkeypatch.setattr("m4e_fmi.runtime.platforms.FOLDER", tmp_path / "none")
    with pytest.raises(RunError, match="no library for native FMUs"):
        build_fmu(driven(), tmp_path / "p.fmu", native=True)


class TestOutputs:
    def test_no_link_to_one_that_is_gone(self) -> None:
        """`a` is the rate of the state v; without it the FMU shows der(v)."""
        assert "der(v)" not in names(with_rates(driven()))
        assert "der(v)" in names(with_rates(with_outputs(driven(), ["height"])))
