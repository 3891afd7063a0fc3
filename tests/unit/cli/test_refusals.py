"""What is refused leaves no trace; what is said is in tests/corpus/commands.yaml."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.command_line import FLEXIBLE, PENDULUM, refused

from m4e_fmi.cli import main
from m4e_fmi.fmu import read_description

SYSTEM = FLEXIBLE / "system.yaml"
WRONG = (
    ("simulate", PENDULUM, "--output-file", "keep.png"),
    ("run", SYSTEM, "--output-file", "keep.png"),
    ("draw", PENDULUM, "--output-file", "d.bmp"),
    ("info", SYSTEM, "--output-file", "d.bmp"),
    ("build", PENDULUM, "--rename", "m=J"),
    ("build", PENDULUM, "--step-size", "20"),
    ("run", SYSTEM, "--variables", "bdy.*", "--algorithm", "gauss"),
    ("run", SYSTEM, "--start-value", "body.N", "1"),
    ("run", SYSTEM, "--resume", "no.nc.checkpoint"),
    ("simulate", PENDULUM, "--variables", "foo"),
    ("new", "system", "NUL"),
    ("new", "adapter", "numpy"),
    ("new", "study", "mine"),
)


@pytest.mark.parametrize("command", WRONG, ids=lambda c: " ".join(map(str, (c[0], *c[2:]))))
def test_nothing_is_built_or_written(
    here: Path, capsys: pytest.CaptureFixture[str], command: tuple[object, ...]
) -> None:
    (here / "keep.png").write_text("mine")
    (here / "mine.study.yaml").write_text("mine")
    refused(capsys, *command)
    files = [path for path in here.rglob("*") if path.is_file()]
    assert {path.name: path.read_text() for path in files} == {
        "keep.png": "mine", "mine.study.yaml": "mine"
    }  # fmt: skip


def test_build_with_options(here: Path) -> None:
    options = ["--native", "--no-documentation", "--inputs", "point.*", "--outputs", "body.upper.*"]
    options += ["--inputs", "*.elbow.effort", "--outputs", "energy.*"]
    options += ["--rename", "m=mass", "--rename", "body.upper.*=boom.*", "--stop-time", "3"]
    assert main(["build", str(PENDULUM), *options]) == 0
    description = read_description(here / "build" / "double_pendulum.fmu")
    inputs = {v.name for v in description.of_causality("input")}
    outputs = {v.name for v in description.of_causality("output")}
    assert inputs == {"point.tip.force_x", "point.tip.force_z", "joint.elbow.effort"}
    assert {name.split(".")[0] for name in outputs} == {"boom", "energy"}
    assert "mass" in description.variables
