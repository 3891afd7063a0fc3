"""Starts that `m4e-fmi new` writes: each of them runs, and its code passes ruff and pyrefly."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.command_line import refused

from m4e_fmi.cli import main
from m4e_fmi.cli.new import KINDS, TEMPLATES
from m4e_fmi.cosim import load_system
from m4e_fmi.files.document import Document
from m4e_fmi.results.results_file import load

BIN = Path(sys.executable).parent


def changed(path: Path, *changes: tuple[str, str]) -> None:
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def mean_of(path: str, name: str) -> float:
    loaded = load(path)
    return float(np.trapezoid(loaded[name].values, loaded.time) / loaded.time[-1])


@pytest.mark.usefixtures("here")
def test_a_model_swings_and_its_energy_balances(capsys):
    assert main(["new", "model", "arm"]) == 0
    out = capsys.readouterr().out
    assert "wrote arm.model.yaml" in out
    assert "  m4e-fmi simulate arm.model.yaml --animate" in out
    assert main(["simulate", "arm.model.yaml", "--stop-time", "1", "--no-plot", "--animate"]) == 0
    assert "energy balance closes" in capsys.readouterr().out
    assert Path("build", "arm.html").is_file()
    assert load("build/arm.nc")["arm.joint.hinge.q"][0] == pytest.approx(np.pi / 9)


@pytest.mark.usefixtures("here")
def test_a_system_takes_power_from_the_waves():
    assert main(["new", "system", "wec"]) == 0
    coarse = ("panels: 700", "panels: 60")
    few = ("    waves:", "    frequencies: {maximum: 2.3, count: 12}\n    waves:")
    changed(Path("wec.system.yaml"), coarse, few)
    assert main(["run", "wec.system.yaml", "--stop-time", "30"]) == 0
    assert mean_of("build/wec.nc", "pto.power") > 1e3


@pytest.mark.usefixtures("here")
def test_a_controller_takes_the_power_that_leaves_the_float():
    """Held force times speed: what the controller tells differs by the speed's change in a step."""
    assert main(["new", "controller", "my_ctl", "--folder", "a b/c"]) == 0
    os.chdir("a b/c")
    assert "class MyCtl:" in Path("my_ctl.py").read_text("utf-8")
    assert main(["run", "my_ctl.system.yaml"]) == 0
    taken = mean_of("build/my_ctl.nc", "controller.power")
    assert taken > 1e4
    assert taken == pytest.approx(-mean_of("build/my_ctl.nc", "float.inputs.power"), rel=0.02)
    force = load("build/my_ctl.nc")["controller.rod.force_z"].values
    assert np.abs(force).max() == 5e4  # its limit


def test_an_adapter_runs_once_it_is_installed(here):
    """The package's own test, the doctor and a run; entry points are found in another process."""
    pytest.importorskip("hatchling", reason="pip builds the package with it")
    assert main(["new", "adapter", "my_stop"]) == 0
    source, site = shutil.copytree("my_stop", here / "source"), here / "site"
    flags = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--target")
    command = [sys.executable, "-m", "pip", "install", *flags, site, source]
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    environment = {**os.environ, "PYTHONPATH": str(site)}
    for words in (
        ["m4e_fmi", "run", "my_stop.system.yaml"],
        ["pytest", "-q", "-p", "no:cacheprovider", "tests"],
    ):
        called = [sys.executable, "-m", *words]
        subprocess.run(called, check=True, cwd=here / "my_stop", env=environment, timeout=120)
    results = here / "my_stop" / "build" / "my_stop_try.nc"
    given = -mean_of(str(results), "float.inputs.power")
    stops = load(results)["float.body.float.z"].max()
    assert stops > 1.2  # the end stop is reached
    assert mean_of(str(results), "damper.power") == pytest.approx(given, rel=0.01)


def test_code_that_is_written_passes_the_checks(here):
    for kind in ("controller", "adapter"):
        assert main(["new", kind, f"my_{kind}"]) == 0
    subprocess.run([BIN / "ruff", "check", "--isolated", here], check=True)
    format_ = [BIN / "ruff", "format", "--isolated", "--line-length", "100", "--check", here]
    subprocess.run(format_, check=True)
    how = ("--preset", "default", "--python-interpreter-path", sys.executable)
    types = [BIN / "pyrefly", "check", *how, "my_controller.py", "my_adapter"]
    subprocess.run(types, check=True)


def test_a_study_is_written_beside_its_system(here, capsys):
    """With the system unless that is there, which is then left as it is."""
    assert main(["new", "study", "wec"]) == 0
    assert "  m4e-fmi study wec.study.yaml" in capsys.readouterr().out
    names = {"wec.study.yaml", "wec.system.yaml", "wec_float.model.yaml"}
    assert {path.name for path in here.iterdir()} == names
    study = Document.load(Path("wec.study.yaml")).data
    assert study["system"] == "wec.system.yaml"
    system = load_system("wec.system.yaml")
    named = [*study["vary"], *(wanted["variable"] for wanted in study["wanted"].values())]
    components = {component.name for component in system.components}
    assert {name.partition(".")[0] for name in named} <= components
    (here / "my.system.yaml").write_text("mine")
    assert main(["new", "study", "my"]) == 0
    assert (here / "my.system.yaml").read_text() == "mine"
    assert (here / "my.study.yaml").is_file()
    assert not (here / "my_float.model.yaml").exists()
    assert "is there already" in refused(capsys, "new", "study", "my")


def test_every_template_is_used():
    used = {name for kind in KINDS.values() for name in (*kind.files, *kind.beside)}
    there = {p.relative_to(TEMPLATES).as_posix() for p in TEMPLATES.rglob("*") if p.is_file()}
    assert used == there
