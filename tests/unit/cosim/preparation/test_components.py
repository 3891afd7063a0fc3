"""FMUs of components: the code and configuration that they are known by, and their form."""

from __future__ import annotations

import os
import shutil
import sys
import zipfile
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi import code_hash as code_module
from m4e_fmi.code_hash import code_hash, package_hash
from m4e_fmi.cosim import Component, FmuFile, Kind, Simulation, System, prepare, run, start
from m4e_fmi.cosim.preparation import components
from m4e_fmi.cosim.system import component as component_module
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.export import native_fmu as native_module
from m4e_fmi.runtime import compiler

KIND_CODE = """\
from typing import Any
from m4e_fmi.files.document import Section
from m4e_fmi.files.files_read import read_text
from m4e_fmi.fmu import FmuKind
from m4e_fmi.program import Recorder, Variable
import gauge_tools

class Config(Section):
    limit: float = 1.0
    anything: Any = None
    curves: dict[str, list[str]] = {{}}

def build(config, *, name, folder, progress):
    progress("warning: not calibrated")
    for path in (path for paths in config.curves.values() for path in paths):
        named = (folder / path).read_text()  # as by a library, of which m4e_fmi knows nothing
        if named:
            read_text(folder / named)
    r = Recorder(name, "a constant")
    r.output(Variable("y", "1", "the constant"), r.time * 0.0 + {factor})
    return r.program()

KIND = FmuKind(Config, build)
"""
AGAIN = ["a: warning: not calibrated"]
"""Lines of a component that is there already."""
Brought = Callable[..., list[str]]


@pytest.fixture
def brought(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Brought]:
    """`brought(kind)` builds a component of a kind from a package of somebody else."""
    site = tmp_path / "site"
    for name, text in {
        "gauge_kind/__init__.py": "",
        "gauge_kind/one.py": KIND_CODE.format(factor=1),
        "gauge_kind/two.py": KIND_CODE.format(factor=2),
        "gauge_kind/zero.json": "0.0",
        "gauge_tools.py": "import gauge_basis\n",
        "gauge_basis.py": "",
    }.items():
        (site / name).parent.mkdir(parents=True, exist_ok=True)
        (site / name).write_text(text)
    monkeypatch.syspath_prepend(str(site))
    found = {
        k: EntryPoint(k, f"gauge_kind.{k}:KIND", component_module.KIND_GROUP)
        for k in ("one", "two")
    }
    for place in (component_module, components):
        monkeypatch.setattr(place, "kinds", lambda: found)
    ours = {name: package_hash(name) for name in code_module.OWN}  # they do not change meanwhile
    anew = package_hash.__wrapped__
    monkeypatch.setattr(code_module, "package_hash", lambda name: ours.get(name) or anew(name))

    def build(kind: str, *, native: bool | None = None, **config: object) -> list[str]:
        code_hash.cache_clear()
        made = component_module.kind_of(kind).config(**config)
        parts = (Component("a", Kind(kind, made)),)
        told: list[str] = []
        system = System("s", parts, (), Simulation(1.0, 0.5), folder=tmp_path)
        components.fmu_files(system, tmp_path / "build", native=native, tell=told.append)
        return told

    yield build
    for name in [n for n in sys.modules if n.startswith("gauge_")]:
        del sys.modules[name]


def test_all_code_of_a_kind_counts(brought: Brought, tmp_path: Path) -> None:
    """Its package with its data, what it imports from elsewhere, and which kind it is."""
    assert any("building" in line for line in brought("one"))
    assert brought("one") == AGAIN
    assert any("building" in line for line in brought("two"))
    for name in ("gauge_kind/__init__.py", "gauge_kind/zero.json", "gauge_tools.py",
                 "gauge_basis.py"):  # fmt: skip
        with (tmp_path / "site" / name).open("a") as file:
            file.write("\n")
        assert any("building" in line for line in brought("two")), name
    assert brought("two") == AGAIN


def test_files_that_a_kind_reads_by_its_own_means(brought: Brought, tmp_path: Path) -> None:
    """Those that its configuration names are known, and those that it reads with `read_text`."""
    outside = tmp_path / "outside.csv"
    curves = {"up": ["curve.csv"], "down": [str(outside)]}
    changes = [("curve.csv", "further.csv"), (outside, ""), ("further.csv", "1")]
    for path, text in changes:
        (tmp_path / path).write_text(text)
    brought("one", curves=curves)
    for path, text in (("further.csv", "2"), (outside, "further.csv"), ("curve.csv", "")):
        (tmp_path / path).write_text(text)
        assert any("building" in line for line in brought("one", curves=curves)), path
        assert brought("one", curves=curves) == AGAIN


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ({"limit": float("inf")}, {"limit": float("-inf")}),
        ({"limit": 0.1}, {"limit": 0.1 + 2**-55}),
        ({"anything": np.arange(5000.0)}, {"anything": np.arange(5000.0) + (np.arange(5000) == 9)}),
    ],
)
def test_every_bit_of_a_configuration_counts(
    brought: Brought, one: dict[str, Any], two: dict[str, Any]
) -> None:
    brought("one", **one)
    assert brought("one", **one) == AGAIN
    assert any("building" in line for line in brought("one", **two))


def test_native_where_it_can_be(
    brought: Brought, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def is_native() -> bool:
        with zipfile.ZipFile(tmp_path / "build/s/a.fmu") as archive:
            return "resources/fmu.txt" in archive.namelist()

    brought("one")
    assert is_native()
    assert brought("one", native=True) == AGAIN
    brought("one", native=False)
    assert not is_native()
    # a machine without compiler, and a wheel without library
    monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(compiler, "compiler", lambda: None)
    monkeypatch.setattr(native_module, "packaged_platforms", list)
    told = "\n".join(brought("one"))
    assert "Python FMUs instead of native ones: there is no library" in told
    assert not is_native()
    with pytest.raises(RunError, match="build without --native"):
        brought("one", native=True)


def test_code_that_changed_after_the_process_began_is_not_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may not be what runs here: another process does not take what is built from it."""
    module = tmp_path / "late_kind.py"
    module.write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    os.utime(module, (1e9, 1e9))

    def hash_in_another_process() -> str:
        monkeypatch.setattr(code_module, "_PROCESS", os.urandom(16))
        package_hash.cache_clear()
        return package_hash("late_kind")

    assert hash_in_another_process() == hash_in_another_process()
    os.utime(module)
    assert hash_in_another_process() != hash_in_another_process()


def test_an_fmu_that_is_replaced_after_it_was_read_is_not_used(c_fmu, tmp_path: Path) -> None:
    fmu = tmp_path / "a.fmu"
    shutil.copy(c_fmu("mass"), fmu)
    system = System("s", (Component("a", FmuFile(fmu)),), (), Simulation(1.0, 0.5))
    prepared = prepare(system)
    shutil.copy(c_fmu("spring"), fmu)
    for use in (lambda: run(prepared), lambda: start(prepared).__enter__()):
        with pytest.raises(RunError, match="was replaced by another FMU meanwhile"):
            use()
    run(system)
