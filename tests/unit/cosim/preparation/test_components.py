"""Building what is missing: once, and again only when what it is made from changes."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import Field

from m4e_fmi.cosim import Component, Kind, ModelFile, Simulation, System, prepare, run
from m4e_fmi.cosim.preparation import components
from m4e_fmi.cosim.system import component as component_module
from m4e_fmi.errors import RunError
from m4e_fmi.files.document import Section
from m4e_fmi.files.files_read import read_bytes, read_text
from m4e_fmi.fmu import read_description
from m4e_fmi.fmu.export import native as native_module
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.runtime import compiler

MASS = "a mass of 1 kg on a spring of the given stiffness, driven by a force"


class CoilConfig(Section):
    stiffness: float
    table: str = ""
    curves: dict[str, list[str]] = Field(default_factory=dict)


def coil(
    config: CoilConfig, *, name: str, folder: Path, progress: Callable[[str], None]
) -> Program:
    if config.table:
        read_bytes(folder / config.table)
    for path in (path for paths in config.curves.values() for path in paths):
        named = (folder / path).read_text()  # as by a library, of which m4e_fmi knows nothing
        if named:
            read_text(folder / named)
    progress("winding")
    r = Recorder(name, "a spring")
    x = r.input(Variable("end.x", "m", "position"))
    r.input(Variable("end.vx", "m/s", "velocity"))
    r.output(Variable("end.force_x", "N", "force on what holds the end"), -config.stiffness * x)
    return r.program()


def mass(model: SimpleNamespace) -> Program:
    path = model.path
    r = Recorder(path.stem, MASS)
    m = r.parameter(Variable("mass", "kg", "mass", start=float(read_text(path))))
    force = r.input(Variable("body.m.force_x", "N", "force"))
    x = r.state(Variable("body.m.x", "m", "position", start=1.0))
    v = r.state(Variable("body.m.vx", "m/s", "velocity", derivative_of="body.m.x"))
    r.rate("body.m.x", v)
    r.rate("body.m.vx", force / m)
    acceleration = Variable("body.m.ax", "m/s2", "acceleration", derivative_of="body.m.vx")
    r.output(acceleration, force / m)
    del x
    return r.program()


@pytest.fixture
def pair(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., System]:
    """`pair(stiffness)` is a system of a model and a kind, both made here."""
    module = ModuleType("coil_kind")
    module.__dict__.update(Config=CoilConfig, make=coil, __spec__=ModuleSpec("coil_kind", None))
    monkeypatch.setitem(sys.modules, "coil_kind", module)

    class Point:
        value = "coil_kind"

    for place in (component_module, components):
        monkeypatch.setattr(place, "kinds", lambda: {"coil": Point()})
    monkeypatch.setattr("m4e_fmi.multibody.model_program", mass)
    monkeypatch.setattr(
        "m4e_fmi.model.load_model", lambda path: SimpleNamespace(path=path, warnings=())
    )
    (tmp_path / "mass.model.yaml").write_text("1.0")
    (tmp_path / "table.csv").write_text("1")

    def make(stiffness: float = 1.0, **more: Any) -> System:
        config = CoilConfig(stiffness=stiffness, table="table.csv", **more)
        parts = (
            Component("body", ModelFile(tmp_path / "mass.model.yaml")),
            Component("coil", Kind("coil", config)),
        )
        settings = Simulation(1.0, 0.01)
        return System("pair", parts, ("body.m <-> coil.end",), settings, folder=tmp_path)

    return make


def test_only_what_changed_is_built_again(pair: Callable[..., System], tmp_path: Path) -> None:
    def built(system: System) -> list[str]:
        told: list[str] = []
        files = components.fmu_files(system, tmp_path / "build", tell=told.append)
        assert files == {n: tmp_path / "build" / "pair" / f"{n}.fmu" for n in ("body", "coil")}
        assert all(path.is_file() for path in files.values())
        return sorted(line.partition(":")[0] for line in told if "building" in line)

    assert built(pair()) == ["body", "coil"]
    assert built(pair()) == []
    assert built(pair(stiffness=2.0)) == ["coil"]
    (tmp_path / "table.csv").write_text("2")
    assert built(pair(stiffness=2.0)) == ["coil"]
    (tmp_path / "mass.model.yaml").write_text("2.0")
    assert built(pair(stiffness=2.0)) == ["body"]
    assert {p.suffix for p in (tmp_path / "build" / "pair").iterdir()} == {".fmu", ".json"}


def test_files_that_a_kind_reads_by_its_own_means(
    pair: Callable[..., System], tmp_path: Path
) -> None:
    """Those that its configuration names are known, and those that it reads with `read_text`."""
    outside = tmp_path / "outside.csv"
    for path, text in (("curve.csv", "further.csv"), (outside, ""), ("further.csv", "1")):
        (tmp_path / path).write_text(text)

    def built() -> bool:
        told: list[str] = []
        system = pair(curves={"up": ["curve.csv"], "down": [str(outside)]})
        components.fmu_files(system, tmp_path / "build", tell=told.append)
        return any(line.startswith("coil: building") for line in told)

    assert [built(), built()] == [True, False]
    for path, text in (("further.csv", "2"), (outside, "further.csv"), ("curve.csv", "")):
        (tmp_path / path).write_text(text)
        assert [built(), built()] == [True, False]


def test_native_where_it_can_be(
    pair: Callable[..., System], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def backends(native: bool | None) -> set[str]:
        files = components.fmu_files(pair(), tmp_path / "build", native=native, tell=told.append)
        inside = [zipfile.ZipFile(path).namelist() for path in files.values()]
        return {"native" if "resources/fmu.txt" in names else "python" for names in inside}

    told: list[str] = []
    assert backends(None) == backends(True) == {"native"}
    assert len(told) == 3  # both built, once, and the coil's own line
    assert backends(False) == {"python"}
    # a machine without compiler, and a wheel without library
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(compiler, "compiler", lambda: None)
    monkeypatch.setattr(native_module, "packaged_platforms", list)
    assert backends(None) == {"python"}
    assert "Python FMUs instead of native ones: there is no library" in told[-1]
    with pytest.raises(RunError, match="build without --native"):
        backends(True)


def test_built_fmus_run_together(pair: Callable[..., System], tmp_path: Path) -> None:
    told: list[str] = []
    prepared = prepare(pair(), build_directory=tmp_path / "build", tell=told.append)
    assert "coil: winding" in told
    assert prepared.structure.execution_order == ("coil", "body")
    body = read_description(prepared.descriptions["body"].path)
    assert body.dependencies["body.m.x"] == frozenset()
    results = run(prepared, results=tmp_path / "r.nc").results()
    x = results["body.body.m.x"]
    assert x.long_name == "position"
    # second order, as for the same pair in C: H²/12 displacement, phase t H²/24
    np.testing.assert_allclose(x.values, np.cos(results.time), atol=2e-5)


def test_a_warning_of_several_components_is_told_once_unless_it_names_a_part() -> None:
    told: list[str] = []
    tell = components._once(told.append)
    for name in ("sea", "buoy"):
        for text in ("warning: the sea is too steep", "warning: body 'a' is heavy", "building"):
            tell(f"{name}: {text}")
    assert told == [
        "sea: warning: the sea is too steep",
        *(f"{name}: {text}" for name, text in (
            ("sea", "warning: body 'a' is heavy"), ("sea", "building"),
            ("buoy", "warning: body 'a' is heavy"), ("buoy", "building"),
        )),
    ]  # fmt: skip
