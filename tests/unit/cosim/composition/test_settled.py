"""Components that are no equations, by what they give at rest: FMUs in C, and MoorDyn's lines."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.cosim import (
    System,
    at_equilibrium,
    load_system,
    run,
    system_program,
)
from m4e_fmi.cosim.composition import parts
from m4e_fmi.errors import RunError
from m4e_fmi.program import Program

Fmus = Callable[[str], Path]
CART = """\
name: cart
gravity: 0
bodies: {cart: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: cart, direction: [1, 0], initial: {q: 0.2}}}
loads: {spring: {type: joint_effort, joint: rail, effort: 20 - 50*joint.rail.q}}
"""
MOTION = """\
connections:
  - cart.body.cart.x -> line.end.x
  - cart.body.cart.vx -> line.end.vx
  - line.end.force_x -> cart.body.cart.force_x
"""
SIGNAL = """\
connections:
  - cart.body.cart.x -> line.u, units ignored
  - line.{y} * -30 -> cart.body.cart.force_x, units ignored
"""
HANGING = """\
name: hanging
components:
  mass: {model: mass.model.yaml}
  line:
    kind: mooring
    water: {density: 0, depth: 50}
    line_types: {t: {diameter: 0.1, mass_per_length: 1, axial_stiffness: 1e5, axial_damping: 100,
      drag_coefficient: 0, added_mass_coefficient: 0}}
    anchors: {top: [0, 0]}
    fairleads: [tip]
    lines: {l: {type: t, from: top, to: tip, unstretched_length: 2, segments: 2}}
connections: [mass.tip <-> line.tip]
simulation: {stop_time: 1, step_size: 0.001}
"""
MASS = """\
name: mass
gravity: 9.80665
bodies: {mass: {mass: 10, inertia: 1}}
joints: {free: {type: floating, child: mass, initial: {x: 0.1, z: -2.1}}}
points: {tip: {body: mass, at: [0, 0]}}
"""
G = 9.80665


def system(folder: Path, fmu: Path, text: str, start: str = "") -> Path:
    (folder / "cart.model.yaml").write_text(CART, encoding="utf-8")
    line = f"{{fmu: {fmu}, start: {{{start}}}}}"
    parts = f"  cart: {{model: cart.model.yaml}}\n  line: {line}\n"
    text = f"name: held\ncomponents:\n{parts}{text}simulation: {{stop_time: 1, step_size: 0.1}}\n"
    path = folder / "system.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def settled(folder: Path, fmu: Path, text: str, start: str = "") -> tuple[Program, list[str]]:
    told: list[str] = []
    given = load_system(system(folder, fmu, text, start))
    return system_program(given, settled=["line"], build_directory=folder, tell=told.append), told


@pytest.mark.parametrize(
    ("model", "start", "step"),
    [
        ("spring", "stiffness: 30, damping: 7", "0.05 m"),
        ("1:spring", "stiffness: 30", "0.05 m"),
        ("3:spring", "stiffness: 30", "0.05 m"),
        ("mm_spring", "stiffness: 0.03", "0.1 mm"),
    ],
)
def test_a_spring_that_is_at_rest_at_once(
    c_fmu: Fmus, tmp_path: Path, model: str, start: str, step: str
) -> None:
    program, told = settled(tmp_path, c_fmu(model), MOTION, start)
    point = equilibrium(program)
    assert point["cart.joint.rail.q"] == pytest.approx(20 / 80, rel=1e-9)
    linear = linearize(program, at=point)
    assert linear.A[1] == pytest.approx([-80 / 2, 0.0], abs=1e-7)
    (line,) = (line for line in told if line.startswith("note: settled"))
    assert line == (
        "note: settled: line: at rest from its start, and about that y0 + K (u - u0), K by central "
        f"differences of {step} (error {line.partition('error ')[2].split()[0]} of its "
        "entries); velocities have no effect, its damping and inertia are left out: resonances "
        "come out too high, and at other periods"
    )


@pytest.mark.parametrize("model", ["lag", "3:lag", "1:lag"])
def test_what_has_to_settle(c_fmu: Fmus, tmp_path: Path, model: str) -> None:
    """y' = u − y: at rest y = u, and the slope at once would be 0."""
    program, told = settled(tmp_path, c_fmu(model), SIGNAL.format(y="y"))
    point = equilibrium(program)
    assert point["cart.joint.rail.q"] == pytest.approx(20 / 80, rel=1e-4)
    assert linearize(program, at=point).A[1, 0] == pytest.approx(-80 / 2, rel=1e-3)
    assert any("settled in 25.6 s with its inputs held" in line for line in told)


@pytest.mark.parametrize(
    ("model", "text", "start", "told", "remedy"),
    [
        (
            "van_der_pol",
            SIGNAL.format(y="x"),
            "x: 1",
            ["does not settle while its inputs are held", "16384 steps (1638.4 s) still change"],
            "keep it open (--open line)",
        ),
        (
            "fuse",
            MOTION,
            "limit: 0.25",
            [
                "while line was brought to rest, its inputs held: line",
                "the fuse has blown",
                "its static law needs end.x at 0.3 m",
            ],
            "; or keep it open (--open line)",
        ),
    ],
)
def test_what_cannot_be_brought_to_rest(
    c_fmu: Fmus, tmp_path: Path, model: str, text: str, start: str, told: list[str], remedy: str
) -> None:
    with pytest.raises(RunError) as caught:
        settled(tmp_path, c_fmu(model), text, start)
    assert all(one in caught.value.message for one in told)
    assert caught.value.remedy.endswith(remedy)


def hanging_system(folder: Path) -> System:
    """A mass of 10 kg on MoorDyn's line of 2 kg."""
    (folder / "mass.model.yaml").write_text(MASS, encoding="utf-8")
    path = folder / "system.yaml"
    path.write_text(HANGING, encoding="utf-8")
    return load_system(path)


def test_a_mass_on_a_mooring_line(tmp_path: Path) -> None:
    """Two segments of 1 m and 1 kg, halves of which weigh at their ends."""
    hanging = system_program(hanging_system(tmp_path), settled=["line"], build_directory=tmp_path)
    pulls = 10.5 * G, 11.5 * G
    lengths = [1.0 + pull / 1e5 for pull in pulls]
    point = equilibrium(hanging)
    assert point["mass.body.mass.z"] == pytest.approx(-sum(lengths), abs=1e-7)
    assert point["mass.body.mass.x"] == pytest.approx(0.0, abs=1e-7)
    sideways = 1.0 / sum(length / pull for length, pull in zip(lengths, pulls, strict=True))
    found = sorted(abs(modes(linearize(hanging, at=point)).eigenvalues))[-2:]
    expected = [math.sqrt(k / 10.0) for k in (sideways, 1e5 / 2)]
    assert found == pytest.approx(expected, rel=1e-3)


def test_a_run_that_starts_at_rest_stays_there(tmp_path: Path) -> None:
    """From its start values the mass moves by decimetres; from rest by less than 1 µm."""
    given = hanging_system(tmp_path)
    rest = at_equilibrium(given, build_directory=tmp_path)
    for system, least, most in ((given, 0.05, 1.0), (rest, 0.0, 1e-6)):
        outcome = run(system, results=tmp_path / "r.nc", build_directory=tmp_path)
        assert least <= np.ptp(np.asarray(outcome.results()["mass.body.mass.z"])) <= most


def test_a_start_at_rest_of_what_settles_later(c_fmu: Fmus, tmp_path: Path) -> None:
    """Steps of components and delays mean nothing at rest."""
    text = SIGNAL.format(y="y").replace("line.u, units ignored", "line.u, units ignored, delayed")
    path, told = system(tmp_path, c_fmu("lag"), text), list[str]()
    path.write_text(path.read_text().replace("cart.model.yaml}", "cart.model.yaml, step_size: 1}"))
    found = at_equilibrium(load_system(path), build_directory=tmp_path, tell=told.append)
    cart, _ = found.components
    assert cart.start["joint.rail.q"] == pytest.approx(20 / 80, rel=1e-4)
    assert cart.start["joint.rail.u"] == 0.0
    assert any("warning: line is not at rest at its start" in line for line in told)


def test_angles_of_the_start_give_way(tmp_path: Path) -> None:
    model = "name: bob\ndimensions: 3\nbodies: {bob: {mass: 1, inertia: [1, 1, 1]}}\n"
    model += "joints: {pin: {type: spherical, child: bob, joint_to_child: [0, 0, -1]}}\n"
    (tmp_path / "bob.model.yaml").write_text(model, encoding="utf-8")
    path = tmp_path / "system.yaml"
    parts = "components:\n  bob: {model: bob.model.yaml, start: {joint.pin.phi: 20 deg}}\n"
    rest = "connections: []\nsimulation: {stop_time: 1, step_size: 0.1}\n"
    path.write_text(f"name: one\n{parts}{rest}", encoding="utf-8")
    found = at_equilibrium(load_system(path), build_directory=tmp_path)
    outcome = run(found, results=tmp_path / "r.nc", build_directory=tmp_path)
    assert np.ptp(np.asarray(outcome.results()["bob.body.bob.z"])) < 1e-12


MOORED = """\
name: moored
components:
  lines:
    kind: mooring
    water: {density: 1025, depth: 50}
    line_types: {t: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1e8,
      axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1,
      breaking_strength: 2e6}}
    anchors: {west: [-300, -50], east: [300, -50]}
    fairleads: {left: [-5, -4], right: [5, -4]}
    lines:
      a: {type: t, from: west, to: left, unstretched_length: 310, segments: 12}
      b: {type: t, from: east, to: right, unstretched_length: 310, segments: 12}
connections: []
inputs: {left: [lines.left.x], right: [lines.right.x], down: [lines.left.z]}
simulation: {stop_time: 1, step_size: 0.05}
"""


BUOY = """\
    points: {buoy: {position: [-20, -10], mass: 500, volume: 5}}
    fairleads:"""


@pytest.mark.parametrize("variant", ["", "a buoy", "a winch"])
def test_statics_of_a_kind_are_those_of_its_fmu(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, variant: str
) -> None:
    """The FMU is settled to 1e-5 of the largest force, its differences are accurate to 1e-3."""
    path, text = tmp_path / "system.yaml", MOORED
    if variant == "a winch":
        text = text.replace("segments: 12}\nconn", "segments: 12, winch: true}\nconn")
        text = text.replace("  lines:\n    kind", "  lines:\n    start: {b.length: 309}\n    kind")
    if variant == "a buoy":
        text = text.replace("    fairleads:", BUOY).replace("west, to: left", "west, to: buoy")
        more = "      c: {type: t, from: buoy, to: left, unstretched_length: 20, segments: 3}\n"
        text = text.replace(
            "length: 310, segments: 12}\nconn", "length: 310, segments: 12}\n" + more + "conn"
        )
    path.write_text(text, encoding="utf-8")
    found, told = [], list[str]()
    for statics in (parts._statics, lambda *_: lambda _: None):
        monkeypatch.setattr(parts, "_statics", statics)
        program = system_program(
            load_system(path), settled=["lines"], build_directory=tmp_path, tell=told.append
        )
        found.append({v.name: v.start for v in program.parameters})
    exact, settled = found
    assert ["static equilibrium" in line for line in told if "note" in line] == [True, False]
    assert exact.keys() == settled.keys()
    assert abs(exact["lines.at_rest.left.force_x"]) > 5e3
    groups = {"force": 1e-5, "tension": 1e-5, "node": 1e-5, "slope": 1e-3}
    groups |= {"safety_factor": 1e-5, "touchdown": 1e-3, "uplift": 1e-3}
    for unit, error in groups.items():
        names = [name for name in exact if unit in name]
        size = max(abs(exact[name]) for name in names)
        assert [exact[n] for n in names] == pytest.approx(
            [settled[n] for n in names], abs=error * size
        )
