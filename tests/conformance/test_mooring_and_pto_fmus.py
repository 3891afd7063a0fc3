"""The mooring and linear_pto FMUs as files: valid, and the same numbers as what is inside.

In still water and in waves; the same bits after going back.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fmpy.validation import validate_fmu
from support.fmu_instances import Instance
from support.lines_in_waves import line_system

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu
from m4e_fmus import linear_pto, mooring

STEP = 0.1
WAVES = """\
waves:
  - {spectrum: jonswap, significant_height: 3, peak_period: 7, seed: 2, ramp_time: 1,
     components: 20}
  - {spectrum: regular, height: 0.5, period: 11, ramp_time: 0}
"""
STILL = """\
water: {density: 1025, depth: 60}
line_types:
  chain: {diameter: 0.1, mass_per_length: 50, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
anchors: {left: [-150, -60]}
fairleads: {f1: [-5, -3]}
solver: {time_step: 0.002}
lines:
  l1: {type: chain, from: left, to: f1, unstretched_length: 165, segments: 6}
"""
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
PTO = "point: p\nanchor: [0, -50]\ndamping: 1.0e+5\nrest_length: 47\n"
TEXTS = {"still": STILL, "waves": WAVES + STILL, "rope": ROPE, "pto": PTO}
Load = Callable[..., Instance]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder, built = tmp_path_factory.mktemp("fmus"), {}
    for name, text in TEXTS.items():
        kind: Any = linear_pto if name == "pto" else mooring
        config = Document.parse(text).validate(kind.KIND.config)
        source = kind.KIND.build(config, name=name, folder=folder, progress=lambda _: None)
        built[name] = build_fmu(source, folder / f"{name}.fmu")
    return built


@pytest.mark.parametrize("name", TEXTS)
def test_fmpy_finds_nothing_wrong(files: dict[str, Path], name: str) -> None:
    assert validate_fmu(str(files[name])) == []


def moved(fmu: Instance, k: int) -> tuple[float, ...]:
    """Forces and tensions after step `k`, in which the fairlead goes to and fro."""
    fmu.set({"f1.x": -5 + math.sin(k * STEP), "f1.vx": math.cos(k * STEP)})
    fmu.step(k * STEP, STEP)
    names = ("f1.force_x", "f1.force_z", "l1.fairlead_tension", "l1.anchor_tension")
    return tuple(fmu.get(names))


@pytest.mark.parametrize("name", ["still", "waves"])
def test_the_mooring_fmu_computes_what_the_line_system_computes(
    files: dict[str, Path], load: Load, name: str
) -> None:
    """A step that was tried and withdrawn leaves nothing behind, in the water either."""
    lines = line_system(TEXTS[name])
    lines.start([(-5.0, -2.5)], [(0.1, 0.0)])
    fmu, other = load("python", files[name]), load("python", files[name])
    fmu.enter()
    fmu.set({"f1.z": -2.5, "f1.vx": 0.1})
    assert tuple(fmu.get(["f1.force_x", "f1.force_z"])) == lines.force[0]
    fmu.fmu.exitInitializationMode()
    expected, content = [], b""
    for k in range(20):
        place, speed = (-5 + math.sin(k * STEP), -2.5), (math.cos(k * STEP), 0.0)
        lines.advance(k * STEP, STEP, [place], [speed])
        before = fmu.save()
        if k == 10:
            content = fmu.pack(before)
        fmu.set({"f1.x": place[0] + 0.3, "f1.vx": -speed[0]})
        fmu.step(k * STEP, 0.7 * STEP)  # withdrawn
        fmu.restore(before)
        expected.append(moved(fmu, k))
        tensions = lines.tensions()[0][0], lines.tensions()[0][1]
        assert expected[-1] == (*lines.force[0], *tensions)
    other.initialise()
    for again in (fmu, other):
        again.restore(again.unpack(content))
        assert [moved(again, k) for k in range(10, 20)] == expected[10:]
    lines.close()


def test_waves_are_parameters(files: dict[str, Path], load: Load) -> None:
    """Without height the water stands still, but for rounding at the start."""
    heights = {"wave[1].significant_height": 0.0, "wave[2].height": 0.0}
    calm = load("python", files["waves"]).initialise(heights)
    still = load("python", files["still"]).initialise()
    for k in range(10):
        assert moved(calm, k) == pytest.approx(moved(still, k), rel=1e-12)


def test_internal_steps_follow_the_current(files: dict[str, Path], load: Load) -> None:
    """Of a light rope whose step is bounded by its drag: it comes to rest in either current."""
    fmu = load("python", files["rope"]).initialise({"current.speed": 1.2})
    pulls = []
    for k in range(1000):
        if k == 200:
            fmu.set({"current.speed": 5.0})
        fmu.step(k * STEP, STEP)
        pulls.append(fmu.get(["l1.fairlead_tension"])[0])
    assert pulls[190:200] == pytest.approx([pulls[199]] * 10, rel=1e-3)
    assert pulls[990:] == pytest.approx([pulls[-1]] * 10, rel=1e-3)
    assert pulls[-1] > 5 * pulls[199]


def test_a_line_that_a_run_stretches_far_beyond_its_length_is_told(
    files: dict[str, Path], c_fmu: Callable[[str], Path]
) -> None:
    """The fairlead leaves at 50 m/s: 1.2 x 165 m are between the ends after some 0.4 s."""
    parts = (
        Component("winch", FmuFile(c_fmu("integrator")), {"u": 50.0, "y": 0.0}),
        Component("line", FmuFile(files["still"]), {"f1.vx": 50.0}),
    )
    way = ("winch.y + 30 -> line.f1.x, units ignored",)
    outcome = run(System("s", parts, way, Simulation(1.0, 0.05, "gauss_seidel")))
    start, message = outcome.messages
    assert "14.4 % beyond its unstretched length of 165 m" in start.text
    assert start.first == 0.0
    assert (message.component, message.status, message.count) == ("line", "warning", 1)
    assert "% beyond its unstretched length of 165 m, and it pulls " in message.text
    distance = float(message.text.split(" are ")[1].split(" m ")[0])
    assert 1.2 * 165 < distance < 1.2 * 165 + 50 * 0.05
    assert math.hypot(180 + 50 * message.first, 57) < 1.2 * 165 + 1e-9


def test_the_folder_of_moordyn_is_in_that_of_its_fmu(
    files: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So what removes the one after a kill removes the other."""
    seen, folder = [], tempfile.TemporaryDirectory

    def noted(**options: Any) -> object:
        if options["prefix"] == "m4e_mooring_":
            seen.append(Path(options["dir"]).relative_to(tmp_path))
        return folder(**options)

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(tempfile, "TemporaryDirectory", noted)
    part = Component("line", FmuFile(files["still"]))
    run(System("s", (part,), (), Simulation(0.1, 0.05, "gauss_seidel")))
    assert seen
    assert all(path.parts[0].startswith("m4e_fmi_") for path in seen)
    assert list(tmp_path.glob("*/*")) == []


def test_places_of_nodes_are_those_of_the_state_whenever_they_are_read(
    files: dict[str, Path], load: Load
) -> None:
    """Ends included; after a step back, and after the end."""
    fmu = load("python", files["still"])

    def nodes() -> list[list[float]]:
        return [fmu.get([f"l1.node_{axis}[{k}]" for axis in "xyz"]) for k in range(1, 8)]

    fmu.enter()
    start = nodes()
    assert start[0] == [-150.0, 0.0, -60.0]
    assert start[-1] == pytest.approx([-5.0, 0.0, -3.0])
    assert start[1][2] == pytest.approx(-60.0, abs=0.01)  # on the bed: MoorDyn's is a spring
    fmu.fmu.exitInitializationMode()
    saved, seen = fmu.save(), []
    for _ in range(2):
        fmu.restore(saved)
        assert nodes() == start
        fmu.set({"f1.x": -5.0, "f1.vx": 2.0})
        fmu.step(0.0, 0.1)
        seen.append(nodes())
    assert seen[0][-1] == pytest.approx([-4.8, 0.0, -3.0])
    assert seen[0][-2] != start[-2]
    fmu.fmu.terminate()
    assert seen == [nodes()] * 2
