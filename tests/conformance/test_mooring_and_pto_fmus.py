"""The mooring and linear_pto FMUs as files: valid, and the same numbers as what is inside."""

import math
import tempfile
from pathlib import Path

import moordyn
import pytest
from fmpy.validation import validate_fmu
from support.running_fmu import Running

from m4e_adapters.moordyn.line_system import LineSystem
from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu
from m4e_fmus import linear_pto, mooring

CHAIN = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {left: [-150, -60]}
fairleads: {f1: [-5, -3]}
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
"""
PTO = "point: p\nanchor: [0, -50]\ndamping: 1.0e+5\nrest_length: 47\n"


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmus")
    built = {}
    for kind, text in ((mooring, CHAIN), (linear_pto, PTO)):
        name = kind.__name__.split(".")[-1]
        config = Document.parse(text).validate(kind.Config)
        source = kind.make(config, name=name, folder=folder, progress=lambda _: None)
        built[name] = build_fmu(source, folder / f"{name}.fmu")
    return built


@pytest.mark.parametrize("name", ["mooring", "linear_pto"])
def test_fmpy_finds_nothing_wrong(files, name):
    assert validate_fmu(str(files[name])) == []


def test_the_mooring_fmu_computes_what_the_line_system_computes(files, tmp_path):
    made = mooring.moordyn.mooring(Document.parse(CHAIN).validate(mooring.Config))
    lines = LineSystem(
        made.text, fairleads=[0.0], lines=made.lines, time_step=made.time_step, net=made.net
    )
    lines.start([(-5.0, -2.5)], [(0.1, 0.0)])
    fmu = Running(files["mooring"], tmp_path / "mooring")
    fmu.set(f1__z=-2.5, f1__vx=0.1)
    assert (fmu.get("f1.force_x"), fmu.get("f1.force_z")) == lines.force[0]
    fmu.slave.exitInitializationMode()
    saved = None
    for k in range(20):
        velocity = math.cos(k / 10)
        position = -5 + math.sin(k / 10)
        lines.advance(k * 0.1, 0.1, [(position, -2.5)], [(velocity, 0.0)])
        if k == 10:
            saved = fmu.slave.serializeFMUState(fmu.slave.getFMUState())
        fmu.set(f1__x=position, f1__vx=velocity)
        fmu.slave.doStep(k * 0.1, 0.1)
        assert (fmu.get("f1.force_x"), fmu.get("f1.force_z")) == lines.force[0]
        assert fmu.get("l1.fairlead_tension") == lines.fairlead_tension[0]
        assert fmu.get("l1.anchor_tension") == lines.anchor_tension[0]
    last = fmu.get("f1.force_x")
    other = Running(files["mooring"], tmp_path / "other")
    for again in (fmu, other):
        again.slave.setFMUState(again.slave.deserializeFMUState(saved))
        for k in range(10, 20):
            again.set(f1__x=-5 + math.sin(k / 10), f1__vx=math.cos(k / 10))
            again.slave.doStep(k * 0.1, 0.1)
        assert again.get("f1.force_x") == last
        again.close()
    lines.close()


def test_the_pto_fmu_integrates_the_power(files, tmp_path):
    fmu = Running(files["linear_pto"], tmp_path / "linear_pto")
    fmu.slave.exitInitializationMode()
    for k in range(10):
        fmu.set(p__vz=0.5)
        fmu.slave.doStep(k * 0.1, 0.1)
    assert fmu.get("power") == pytest.approx(1e5 * 0.25)
    # a constant power for one second; the integrator's tolerance is 1e-8
    assert fmu.get("energy") == pytest.approx(1e5 * 0.25, rel=1e-7)
    fmu.set(damping=2e5)
    assert fmu.get("p.force_z") == pytest.approx(-2e5 * 0.5)
    fmu.close()


def test_a_line_that_a_run_stretches_far_beyond_its_length_is_told(files, c_fmu):
    # the fairlead leaves at 50 m/s: 1.2 x 165 m are between the ends after some 0.4 s
    parts = (
        Component("winch", FmuFile(c_fmu("integrator")), {"u": 50.0, "y": 0.0}),
        Component("line", FmuFile(files["mooring"]), {"f1.vx": 50.0}),
    )
    way = ("winch.y + 30 -> line.f1.x, units ignored",)
    outcome = run(System("s", parts, way, Simulation(1.0, 0.05, "gauss_seidel")))
    start, message = outcome.messages
    assert "14.4 % beyond its unstretched length of 165 m" in start.text
    assert start.first == 0.0
    assert (message.component, message.status, message.count) == ("line", "warning", 1)
    assert message.text.startswith("the ends of l1 are ")
    assert "% beyond its unstretched length of 165 m, and it pulls " in message.text
    distance = float(message.text.split(" are ")[1].split(" m ")[0])
    assert 1.2 * 165 < distance < 1.2 * 165 + 50 * 0.05
    assert math.hypot(180 + 50 * message.first, 57) < 1.2 * 165 + 1e-9


def test_the_folder_of_moordyn_is_in_that_of_its_fmu(files, tmp_path, monkeypatch):
    """So what removes the one after a kill removes the other."""
    seen, init = [], moordyn.Init_NoIC

    def noted(*arguments):
        seen.extend(path.relative_to(tmp_path) for path in tmp_path.rglob("m4e_mooring_*"))
        return init(*arguments)

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(moordyn, "Init_NoIC", noted)
    part = Component("line", FmuFile(files["mooring"]))
    run(System("s", (part,), (), Simulation(0.1, 0.05, "gauss_seidel")))
    assert seen
    assert all(path.parts[0].startswith("m4e_fmi_") for path in seen)
    assert list(tmp_path.iterdir()) == []


def test_places_of_nodes_are_those_of_the_state_whenever_they_are_read(files, tmp_path):
    """Ends included; after a step back, and after the end."""
    fmu = Running(files["mooring"], tmp_path / "nodes")
    names = [[f"l1.node_{axis}[{k}]" for axis in "xyz"] for k in range(1, 8)]

    def nodes() -> list[list[float]]:
        return [[fmu.get(name) for name in node] for node in names]

    start = nodes()
    assert start[0] == [-150.0, 0.0, -60.0]
    assert start[-1] == pytest.approx([-5.0, 0.0, -3.0])
    assert start[1][2] == pytest.approx(-60.0, abs=0.01)  # on the bed: MoorDyn's is a spring
    fmu.slave.exitInitializationMode()
    saved = fmu.slave.getFMUState()
    fmu.set(f1__x=-5.0, f1__vx=2.0)
    fmu.slave.doStep(0.0, 0.1)
    moved = nodes()
    assert moved[-1] == pytest.approx([-4.8, 0.0, -3.0])
    assert moved[-2] != start[-2]
    fmu.slave.setFMUState(saved)
    assert nodes() == start
    fmu.set(f1__x=-5.0, f1__vx=2.0)
    fmu.slave.doStep(0.0, 0.1)
    fmu.slave.terminate()
    assert nodes() == moved
    fmu.slave.freeInstance()
