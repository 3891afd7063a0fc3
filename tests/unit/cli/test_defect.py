"""Unexpected errors: whose code they come from."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from m4e_fmi.cli.shared.defect import defect_line
from m4e_fmi.cosim.system import component

CODE = """\
def make(work):
    return work(0)

def waves(x):
    raise NotImplementedError("no waves")
"""


def _line(work) -> str:
    try:
        work()
    except Exception as error:  # noqa: BLE001
        return defect_line(error, ["rao"])
    raise AssertionError("no error")


def test_an_error_in_the_code_of_a_kind_is_its_defect(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the innermost of ours and theirs; the libraries between are nobody's."""
    (tmp_path / "my_waves").mkdir()
    file = tmp_path / "my_waves" / "__init__.py"
    file.write_text(CODE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    import my_waves  # type: ignore[import-not-found]

    point = EntryPoint("waves", "my_waves", component.KIND_GROUP)
    monkeypatch.setattr(component, "kinds", lambda: {"waves": point})
    told = _line(lambda: my_waves.make(my_waves.waves))
    assert f"this is a defect of the kind 'waves' ({file}, line 5), not of your input" in told
    told = _line(lambda: my_waves.make(lambda _: component.kind_module("none")))
    assert "this is a defect of m4e_fmi, not of your input" in told
    told = _line(lambda: int("x"))
    assert "this is a defect of m4e_fmi, not of your input" in told
