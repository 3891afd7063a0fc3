"""A system is looked at before anything is built.

Messages are in tests/corpus/problems_at_once.yaml.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.moordyn import MooringConfig
from m4e_fmi.cli import main
from m4e_fmi.cosim import prepare
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu, read_description
from m4e_fmi.fmu.export.description import expected_description
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmus import hydrodynamics, mooring

CORPUS = Path(__file__).parents[2] / "corpus" / "problems_at_once.yaml"
FILES = YAML(typ="safe").load(CORPUS.read_text("utf-8"))["files"]
SOUND, MODEL = FILES["s.system.yaml"], FILES["buoy.model.yaml"]


@pytest.fixture
def files(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, "utf-8")
    return tmp_path


def told(folder: Path, system: str) -> list[str]:
    """Messages of what is wrong with a system; nothing is built."""
    (folder / "s.system.yaml").write_text(system)
    lines: list[str] = []
    with pytest.raises(InputError) as caught:
        prepare(folder / "s.system.yaml", build_directory=folder / "build", tell=lines.append)
    assert not any("building" in line for line in lines)
    assert not (folder / "build").exists()
    return [problem.message for problem in caught.value.problems]


def test_expected_descriptions_are_those_of_the_fmus(files: Path) -> None:
    system = Document.parse(SOUND)
    drop = ("kind",)
    lines = system.validate(MooringConfig, at=("components", "lines"), drop=drop)
    water = system.validate(HydrodynamicsConfig, at=("components", "hydro"), drop=drop)
    for source in (
        model_program(load_model(files / "buoy.model.yaml")),
        mooring.KIND.build(lines, name="lines", folder=files, progress=lambda _: None),
        hydrodynamics.KIND.outline(water, folder=files),
    ):
        expected = expected_description(source, files / "a.fmu")
        built = read_description(build_fmu(source, files / "a.fmu"))
        assert expected.variables == built.variables
        assert expected.input_derivatives == built.input_derivatives


def test_a_kind_may_fail_on_what_is_left_of_a_wrong_configuration(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its failure does not hide the problems that are known."""

    def fail(*_: object, **__: object) -> None:
        raise AttributeError("'NoneType' object has no attribute 'high'")

    monkeypatch.setattr(mooring, "KIND", replace(mooring.KIND, build=fail))
    assert told(files, SOUND.replace("depth: 50", "depth: 50, densty: 1000")) == [
        "unknown key 'densty'"
    ]


@pytest.mark.parametrize("offers_check", [False, True])
def test_nothing_is_made_twice(
    offers_check: bool, files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By `info`, which asks first what takes long; and `check` is for kinds that take long."""
    calls = []
    build = mooring.KIND.build

    def counted(*given: Any, **named: Any) -> Any:
        calls.append("make")
        return build(*given, **named)

    monkeypatch.setattr(mooring, "KIND", replace(mooring.KIND, build=counted))
    if offers_check:
        monkeypatch.setattr(mooring, "check", lambda *_, **__: calls.append("check"), raising=False)
    assert main(["info", str(files / "s.system.yaml")]) == 0
    assert calls == ["make"]
