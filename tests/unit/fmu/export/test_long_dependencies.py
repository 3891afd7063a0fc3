"""Dependencies of FMUs with hundreds of variables: lists of all are left out, and read as such."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZipFile

from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.model_description import LONG, XML
from m4e_fmi.fmu.importer.reading import read_description
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program

COUNT = 30


def test_lists_of_all_are_left_out_and_mean_all(tmp_path: Path) -> None:
    """A chain of ball joints: every acceleration depends on all states and forces; places on few.

    The description of 30 bodies has 1.0 MB instead of 5.6.
    """
    bodies = {f"b{k}": Body(1.0, (0.1, 0.2, 0.25)) for k in range(COUNT)}
    joints = {
        f"j{k}": Joint("spherical", f"b{k}", f"b{k - 1}" if k else "ground", (0, 0, 1), (1, 0, 0))
        for k in range(COUNT)
    }
    model = Model(name="chain", bodies=bodies, joints=joints, dimensions=3)
    program = model_program(model)
    assert len(program.states) + len(program.inputs) > LONG
    path = build_fmu(program, tmp_path / "chain.fmu", native=True)
    with ZipFile(path) as archive:
        assert archive.getinfo(XML).file_size < 1.2e6
    read = read_description(path)
    inputs = {v.name for v in read.of_causality("input")}
    assert read.dependencies["body.b7.ax"] == inputs
    assert read.dependencies["body.b7.x"] == frozenset()
    assert not read.undeclared
    # the place of a body depends at the start on the attitudes between it and the ground
    needs = read.initial_dependencies["body.b7.x"]
    assert needs == {f"joint.j{k}.e{part}" for k in range(8) for part in range(4)}
    assert inputs <= read.initial_dependencies["body.b7.ax"]
