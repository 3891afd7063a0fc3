"""FMUs whose binary needs a library that is not on this computer."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from support.c_fmus.build import build

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.errors import RunError
from m4e_fmi.fmu import validate_fmu

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the loader of Linux")
REMEDY = "apt-file search libgone.so.3"


@pytest.fixture(scope="module")
def needy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU whose binary needs `libgone.so.3`."""
    folder = tmp_path_factory.mktemp("needy")
    gone = folder / "libgone.so.3"
    subprocess.run(["cc", "-shared", f"-Wl,-soname,{gone.name}", "-o", str(gone)], check=True)
    return build("mass", folder, ["-Wl,--no-as-needed", str(gone)])


def test_a_run_names_the_library_and_how_to_get_it(needy: Path) -> None:
    system = System("s", (Component("a", FmuFile(needy)),), (), Simulation(1.0, 0.1))
    with pytest.raises(RunError, match=r"libgone\.so\.3: cannot open shared object") as caught:
        run(system)
    assert REMEDY in caught.value.remedy
    assert "binary" not in caught.value.remedy


@pytest.mark.parametrize("process", [None, "here"])
def test_so_does_a_coupled_run_of_a_missing_symbol(tmp_path: Path, process: str | None) -> None:
    source = tmp_path / "unlinked.c"
    source.write_text("void not_there(void); void *kept = (void *)not_there;")
    unlinked, spring = build("mass", tmp_path, [str(source)]), build("spring", tmp_path)
    mass = Component("a", FmuFile(unlinked), process=process)
    connections = ("a.body.m.x -> b.end.x", "b.end.force_x -> a.body.m.force_x")
    system = System("s", (mass, Component("b", FmuFile(spring))), connections, Simulation(1.0, 0.1))
    with pytest.raises(RunError, match="undefined symbol: not_there") as caught:
        run(system)
    assert "none of the libraries that it needs has not_there" in caught.value.remedy


def test_validate_does_so_too(needy: Path) -> None:
    (finding,) = [f for f in validate_fmu(needy).of_severity("error") if f.id == "start.library"]
    assert REMEDY in finding.basis
