"""The mooring FMU in waves: the lines' own numbers, the same bits after going back, parameters."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from support.fmu_instance import Instance
from support.lines_in_waves import line_system
from support.running_fmu import Running

from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu
from m4e_fmus import mooring

STEP = 0.1
CHAIN = """\
water: {density: 1025, depth: 60}
waves:
  - {spectrum: jonswap, significant_height: 3, peak_period: 7, seed: 2, ramp_time: 1,
     components: 20}
  - {spectrum: regular, height: 0.5, period: 11, ramp_time: 0}
line_types:
  chain: {diameter: 0.1, mass_per_length: 50, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {left: [-150, -60]}
fairleads: {f1: [-5, -3]}
solver: {time_step: 0.002}
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmu")
    config = Document.parse(CHAIN).validate(mooring.Config)
    source = mooring.make(config, name="mooring", folder=folder, progress=lambda _: None)
    return build_fmu(source, folder / "mooring.fmu")


def step(fmu: Running, k: int) -> float:
    fmu.set(f1__x=-5 + math.sin(k * STEP), f1__vx=math.cos(k * STEP))
    fmu.slave.doStep(k * STEP, STEP)
    return fmu.get("f1.force_x")


def test_fmpy_finds_nothing_wrong(file: Path) -> None:
    assert validate_fmu(str(file)) == []


def test_steps_repeat_to_the_bit_after_going_back(file: Path, tmp_path: Path) -> None:
    """A step that was tried and withdrawn leaves nothing behind, in the water either."""
    lines = line_system(CHAIN)
    lines.start([(-5.0, -3.0)], [(0.0, 0.0)])
    fmu, other = Running(file, tmp_path / "mooring"), Running(file, tmp_path / "other")
    fmu.slave.exitInitializationMode()
    assert fmu.get("f1.force_x") == lines.force[0][0]
    expected, saved = [], b""
    for k in range(20):
        place, speed = (-5 + math.sin(k * STEP), -3.0), (math.cos(k * STEP), 0.0)
        lines.advance(k * STEP, STEP, [place], [speed])
        before = fmu.slave.getFMUState()
        if k == 10:
            saved = fmu.slave.serializeFMUState(before)
        fmu.set(f1__x=place[0] + 0.3, f1__vx=-speed[0])
        fmu.slave.doStep(k * STEP, 0.7 * STEP)  # withdrawn
        fmu.slave.setFMUState(before)
        expected.append(step(fmu, k))
        assert expected[-1] == lines.force[0][0]
    for again in (fmu, other):
        again.slave.setFMUState(again.slave.deserializeFMUState(saved))
        assert [step(again, k) for k in range(10, 20)] == expected[10:]
        again.close()
    lines.close()


ROPE = """\
water: {density: 1025, depth: 60}
current: {speed: 1}
seabed: {stiffness: 100, damping: 0}
line_types:
  rope: {diameter: 0.1, mass_per_length: 10, axial_stiffness: 1.0e+5, axial_damping_ratio: 0.1,
         drag_coefficient: 2, added_mass_coefficient: 1}
anchors: {left: [-150, -60]}
fairleads: {f1: [-5, -3]}
lines:
  l1: {type: rope, from: left, to: f1, unstretched_length: 156, segments: 6}
"""


def test_a_current_beyond_the_internal_step_ends_the_run(tmp_path: Path) -> None:
    """Of a light rope whose step is bounded by its drag; the margin of the step may be used."""
    config = Document.parse(ROPE).validate(mooring.Config)
    source = mooring.make(config, name="mooring", folder=tmp_path, progress=lambda _: None)
    with Instance(build_fmu(source, tmp_path / "mooring.fmu"), tmp_path / "run") as fmu:
        fmu.initialise({"current.speed": 1.2})
        fmu.set({"current.speed": 1.5})
        fmu.step(0.0, STEP)
        fmu.set({"current.speed": 4.0})
        with pytest.raises(FMICallException):
            fmu.step(STEP, STEP)
        assert "waves and current reach 4 m/s" in fmu.last_error


def test_waves_are_parameters(file: Path, tmp_path: Path) -> None:
    """Without height the water stands still."""
    calm, still = (
        Running(file, tmp_path / "calm"),
        line_system(CHAIN[: CHAIN.index("waves:")] + CHAIN[CHAIN.index("line_types") :]),
    )
    calm.slave.setReal([calm.references["wave[1].significant_height"]], [0.0])
    calm.slave.setReal([calm.references["wave[2].height"]], [0.0])
    calm.slave.exitInitializationMode()
    still.start([(-5.0, -3.0)], [(0.0, 0.0)])
    for k in range(10):
        still.advance(k * STEP, STEP, [(-5 + math.sin(k * STEP), -3.0)], [(math.cos(k * STEP), 0)])
        assert step(calm, k) == still.force[0][0]
    still.close()
    calm.close()
