"""Floating bodies that do not float where they were said to: told with both numbers.

A buoy of 100 t displacement and 50 m2 of waterplane, in water without waves or radiation.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.calm_water import calm

from m4e_adapters.hydrodynamics import Coefficients, hydrodynamics_program
from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Outcome,
    Simulation,
    System,
    load_system,
    prepare,
    run,
    save_system,
)
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program

MODEL = """\
name: buoy
gravity: 9.81
parameters: {m: {value: 100, unit: t}}
bodies: {float: {mass: m, inertia: 1e6, added_mass: true}}
joints: {sea: {type: floating, child: float, initial: {z: -1.0}}}
"""
CONNECTIONS = ("buoy.float <-> hydro.float", "hydro.added_mass -> buoy.added_mass")


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("fmus")
    model = folder / "buoy.model.yaml"
    model.write_text(MODEL)
    return {
        "buoy": build_fmu(model_program(load_model(model)), folder / "buoy.fmu", native=True),
        "hydro": water(folder / "hydro.fmu", calm(("float",))),
        "deep": water(folder / "deep.fmu", calm(("float",), area=0.0)),
    }


def water(path: Path, coefficients: Coefficients) -> Path:
    """The FMU of the water around bodies."""
    return build_fmu(hydrodynamics_program(coefficients, name="hydro"), path, native=True)


def floated(
    fmus: dict[str, Path],
    folder: Path,
    *connections: str,
    water: str = "hydro",
    **start: float | str,
) -> Outcome:
    """A run of the buoy in this water, beside the waters of other names."""
    paths = {name: path for name, path in fmus.items() if name not in ("deep", water)}
    paths["hydro"] = fmus[water]
    system = System(
        name="float",
        components=tuple(Component(name, FmuFile(path)) for name, path in paths.items()),
        connections=(*CONNECTIONS, *connections),
        simulation=Simulation(8.0, 0.05),
    )
    names = {
        "m": "buoy.m",
        "x": "buoy.body.float.x",
        "z": "buoy.body.float.z",
        "theta": "buoy.body.float.theta",
    }
    changed = system.changed(start={names[key]: value for key, value in start.items()})
    return run(changed, results=folder / "r.nc")


def test_a_body_in_balance_is_not_told_of(fmus: dict[str, Path], tmp_path: Path) -> None:
    assert floated(fmus, tmp_path).warnings == ()
    assert floated(fmus, tmp_path, m="100.9 t").warnings == ()


def test_weight_and_buoyancy_that_differ_are_told(fmus: dict[str, Path], tmp_path: Path) -> None:
    """Added mass moves with the body, and is no weight; the start may be anywhere."""
    for z in (-1.0, -0.99):
        (told,) = floated(fmus, tmp_path, m="90 t", z=z).warnings
        assert told.startswith(
            "buoy.body.float: weight and connected forces are 882.9 kN at the start, the still "
            "water carries 981 kN"
        )
        assert "it rises by 0.2 m from there" in told  # 10 t over 1 t/m3 over 50 m2
        assert "say 'mass: neutral' in its model: hydro.float.neutral_mass (100000 kg)" in told


def test_a_moment_out_of_balance_is_told_as_trim(fmus: dict[str, Path], tmp_path: Path) -> None:
    """The centre of gravity 0.2 m right of the centre of buoyancy: 200 kN.m, against 1962 kN.m/rad.

    Added mass couples heave and pitch: the moment accelerates heave, and is no weight.
    """
    aside = water(tmp_path / "aside.fmu", calm(("float",), lever=0.2))
    (told,) = floated({**fmus, "aside": aside}, tmp_path, water="aside").warnings
    assert told.startswith("buoy.body.float: a moment of 196.2 kN.m about its centre of gravity")
    assert "the trim is 5.73 deg; put center_of_gravity above the centre of buoyancy" in told
    little = water(tmp_path / "little.fmu", calm(("float",), lever=0.03))  # 0.86 deg
    assert floated({**fmus, "aside": little}, tmp_path, water="aside").warnings == ()


def test_a_body_that_capsizes_is_told(fmus: dict[str, Path], tmp_path: Path) -> None:
    """-30 m4 of waterplane and weight, over 100 m3."""
    top_heavy = water(tmp_path / "top.fmu", calm(("float",), pitch=-30.0))
    (told,) = floated({**fmus, "top": top_heavy}, tmp_path, water="top").warnings
    assert told.startswith("buoy.body.float: it is unstable in pitch, with a stiffness of -2.943e+")
    assert "(GM = -0.3 m)" in told
    assert "lower center_of_gravity" in told


def test_the_mass_that_balances_is_told_at_once(fmus: dict[str, Path], tmp_path: Path) -> None:
    """A load of 98.1 kN on a buoy of 100 t: 90 t are right, whatever is there now."""
    pulled = {**fmus, "buoy": pulled_buoy(tmp_path, MODEL, -98.1e3)}
    for mass in ("100 t", "110 t"):
        (told,) = floated(pulled, tmp_path, m=mass).warnings
        assert "its mass is 90000 kg (now 1" in told
        assert f"'hydro.float.neutral_mass - 10000 -> buoy.{MASS}'" in told
    assert floated(pulled, tmp_path, m="90 t").warnings == ()


def test_no_mass_is_told_where_none_balances(
    fmus: dict[str, Path], neutral: dict[str, Path], tmp_path: Path
) -> None:
    """Loads of 1100 kN on a body that displaces 981 kN."""
    for text, others in ((MODEL, fmus), (NEUTRAL, neutral)):
        pulled = {**others, "buoy": pulled_buoy(tmp_path, text, -1.1e6)}
        told, *_ = floated(pulled, tmp_path).warnings
        assert "no mass balances that, because the other forces alone exceed the" in told
        assert "->" not in told


RAFT = """\
name: raft
gravity: 9.81
parameters: {m: {value: 100, unit: t}}
bodies:
  fore: {mass: m, inertia: 1e6, added_mass: true}
  aft: {mass: neutral, inertia: 1e6, added_mass: true}
joints:
  sea: {type: floating, child: fore, initial: {x: -5, z: -1}}
  hinge: {type: revolute, parent: fore, child: aft, parent_to_joint: [5, 1],
    joint_to_child: [5, -1]}
"""


def raft(folder: Path, text: str) -> System:
    """The raft of a model in still water."""
    (folder / "raft.model.yaml").write_text(text)
    program = model_program(load_model(folder / "raft.model.yaml"))
    hulls = calm(("fore", "aft"), places=(-5.0, 5.0))
    return System(
        name="raft",
        components=(
            Component("raft", FmuFile(build_fmu(program, folder / "raft.fmu", native=True))),
            Component("hydro", FmuFile(water(folder / "hydro.fmu", hulls))),
        ),
        connections=(
            "raft.fore <-> hydro.fore",
            "raft.aft <-> hydro.aft",
            "hydro.added_mass -> raft.added_mass",
        ),
        simulation=Simulation(0.1, 0.05),
    )


def test_joined_bodies_are_judged_as_one(tmp_path: Path) -> None:
    """A fore body of 140 t, not 100: 40 t too much, a moment of 40 t at 5 m; none is aft's."""
    system = raft(tmp_path, RAFT)
    assert run(system, results=tmp_path / "r.nc").warnings == ()
    heavy = system.changed(start={"raft.m": "140 t"})
    weight, trim = run(heavy, results=tmp_path / "r.nc").warnings
    assert weight.startswith("raft.body.fore and body.aft: weight and connected forces are 2354.4")
    assert "they sink by 0.4 m" in weight
    assert "give them 40000 kg less (together now 240000 kg)" in weight
    assert trim.startswith("raft.body.fore and body.aft: a moment of -1962 kN.m about the middle")


def test_joined_bodies_that_capsize_are_told(tmp_path: Path) -> None:
    """Two hulls with 981 kN/m at 5 m aside and 1962 kN.m/rad each carry 10 t, 600 m up."""
    text = (
        RAFT.replace("mass: m,", "mass: 90e3,")
        .replace(
            "bodies:",
            """bodies:
  mast: {mass: 10e3, inertia: 1e5}""",
        )
        .replace("parameters: {m: {value: 100, unit: t}}\n", "")
    )
    text += "  foot: {type: fixed, parent: fore, child: mast, joint_to_child: [0, 600]}\n"
    told, *_ = run(raft(tmp_path, text), results=tmp_path / "r.nc").warnings
    # 2 (490.5 · 25 + 1962) kN.m, less 98.1 kN at 600 m
    assert told.startswith(
        "raft.body.fore and body.aft: with mast they are unstable in pitch, with a stiffness of "
        "-3.041e+07 N.m/rad"
    )


def test_a_carried_body_that_the_ground_holds_does_not_count(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    """A mast that slides along a rail on the ground, hinged to the buoy, cannot turn with it."""
    text = MODEL.replace("bodies: {", "bodies: {mast: {mass: 10e3, inertia: 1e5}, ").replace(
        "sea: {type: floating, child: float, initial: {z: -1.0}}",
        "rail: {type: prismatic, child: mast, direction: [0, 1], initial: {q: -1.0}}, "
        "hinge: {type: revolute, parent: mast, child: float, parent_to_joint: [0, 0]}",
    )
    (tmp_path / "held.model.yaml").write_text(text)
    program = model_program(load_model(tmp_path / "held.model.yaml"))
    held = build_fmu(program, tmp_path / "held.fmu", native=True)
    (told,) = floated({**fmus, "buoy": held}, tmp_path).warnings
    assert "are 1079.1 kN at the start, the still water carries 981 kN" in told
    assert "unstable" not in told


def test_the_neutral_mass_can_be_connected(fmus: dict[str, Path], tmp_path: Path) -> None:
    outcome = floated(fmus, tmp_path, "hydro.float.neutral_mass -> buoy.m")
    assert outcome.warnings == ()
    z = outcome.results()["buoy.body.float.z"].values
    assert z == pytest.approx(np.full(len(z), -1.0), abs=1e-9)


def test_another_start_than_the_reference_pose_is_told(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    warnings: list[str] = []
    system = floated(fmus, tmp_path, z=-0.5).prepared
    run(system, warn=warnings.append)
    assert warnings == [
        "warning: hydro.float.z starts at -0.5 m, coefficients are for -1 m: right for a release, "
        "else make start and center_of_gravity agree"
    ]
    assert floated(fmus, tmp_path, x=0.4).warnings == ()
    (told,) = floated(fmus, tmp_path, x=0.5).warnings  # of a side of the cube of 4.64 m
    assert told.startswith("hydro.float.x starts at 0.5 m, coefficients are for 0 m: make start")
    (told,) = floated(fmus, tmp_path, theta="5 deg").warnings
    assert "hydro.float.theta starts at 0.08727 rad" in told


def test_a_submerged_body_that_starts_elsewhere_is_told_too(
    fmus: dict[str, Path], tmp_path: Path
) -> None:
    """It has no draft: a hundredth of its size, the side of a cube of 100 m3, is told."""
    assert floated(fmus, tmp_path, water="deep", z=-1.04).warnings == ()
    (told,) = floated(fmus, tmp_path, water="deep", z=-1.06).warnings
    assert told.startswith("hydro.float.z starts at -1.06 m, coefficients are for -1 m")


def test_motions_that_are_not_small_are_told_once(fmus: dict[str, Path], tmp_path: Path) -> None:
    """Half the mean draft of 2 m is left at once from 1.1 m below, 15 deg by a turn of 16; a body
    that is too heavy leaves it later: the first time is told."""
    outcome = floated(fmus, tmp_path, z=-2.1)
    start, sinks = outcome.warnings
    told = outcome.results().attributes["notes"].splitlines()  # from where a report takes them
    assert {f"warning: {start}", f"warning: {sinks}"} <= set(told)
    assert "starts at -2.1 m" in start
    assert sinks.startswith("hydro.float.heave is -1.1 m at t = 0 s, outside -1 to 1 m")
    assert "within 0.5 of the mean draft" in sinks
    start, turns = floated(fmus, tmp_path, theta="16 deg").warnings
    assert "hydro.float.pitch is 0.2793 rad at t = 0 s, outside -0.2618 to 0.2618 rad" in turns
    heavy = floated(fmus, tmp_path, m="156 t").warnings  # sinks by up to 2.24 m
    (left,) = (line for line in heavy if "heave" in line)
    outcome = floated(fmus, tmp_path, m="156 t").results()
    heave = outcome["hydro.float.heave"].values
    first = int(np.argmax(np.abs(heave) > 1.0))
    assert f"is {heave[first]:.4g} m at t = {outcome.time[first]:.9g} s" in left


def test_a_hinge_carries_the_weight(fmus: dict[str, Path], tmp_path: Path) -> None:
    """A body that stands on a hinge need not be in balance by itself."""
    text = MODEL.replace(
        "sea: {type: floating, child: float, initial: {z: -1.0}}",
        "hinge: {type: revolute, child: float, parent_to_joint: [0, -5], joint_to_child: [0, 4], "
        "initial: {q: 0.01}}",
    )
    (tmp_path / "flap.model.yaml").write_text(text)
    program = model_program(load_model(tmp_path / "flap.model.yaml"))
    flap = build_fmu(program, tmp_path / "flap.fmu", native=True)
    told = floated({**fmus, "buoy": flap}, tmp_path, m="300 t").warnings
    assert not any("still water carries" in text for text in told)


NEUTRAL = MODEL.replace("mass: m,", "mass: neutral,").replace("parameters:", "# parameters:")
MASS = "body.float.neutral_mass"


@pytest.fixture(scope="module")
def neutral(fmus: dict[str, Path]) -> dict[str, Path]:
    """The buoy with `mass: neutral`."""
    model = fmus["buoy"].with_name("neutral.model.yaml")
    model.write_text(NEUTRAL)
    fmu = build_fmu(model_program(load_model(model)), model.with_name("neutral.fmu"), native=True)
    return {**fmus, "buoy": fmu}


def pulled_buoy(folder: Path, model: str, force: float) -> Path:
    """The FMU of a buoy with a vertical force [N]."""
    (folder / "moored.model.yaml").write_text(
        model + f"loads: {{lines: {{type: body_force, body: float, force: [0, {force}]}}}}"
    )
    program = model_program(load_model(folder / "moored.model.yaml"))
    return build_fmu(program, folder / "moored.fmu", native=True)


def loaded(fmus: dict[str, Path], folder: Path, *connections: str) -> Outcome:
    """The neutral buoy with a force of -98.1 kN."""
    return floated({**fmus, "buoy": pulled_buoy(folder, NEUTRAL, -98.1e3)}, folder, *connections)


def heave(outcome: Outcome) -> np.ndarray:
    return outcome.results()["buoy.body.float.z"].values


def test_a_neutral_mass_comes_with_the_connection_of_the_bodies(
    fmus: dict[str, Path], neutral: dict[str, Path], tmp_path: Path
) -> None:
    """To the bits of the mass that is connected by hand; also from an SSP package."""
    wanted = heave(floated(fmus, tmp_path, "hydro.float.neutral_mass -> buoy.m"))
    outcome = floated(neutral, tmp_path)
    assert outcome.warnings == ()
    assert np.array_equal(heave(outcome), wanted)
    assert "hydro.float.neutral_mass: transferred once" in str(outcome.prepared)
    package = save_system(outcome.prepared.system, tmp_path / "float.ssp", build_directory=tmp_path)
    again = run(load_system(package), results=tmp_path / "again.nc", build_directory=tmp_path)
    assert np.array_equal(heave(again), wanted)


def test_a_python_fmu_has_its_neutral_mass_before_it_tells_anything(
    neutral: dict[str, Path], tmp_path: Path
) -> None:
    """It computes all its outputs when one is asked for."""
    program = model_program(load_model(neutral["buoy"].with_suffix(".model.yaml")))
    buoy = build_fmu(program, tmp_path / "buoy.fmu")
    assert heave(floated({**neutral, "buoy": buoy}, tmp_path)) == pytest.approx(-1.0, abs=1e-9)


def test_a_given_mass_wins_over_the_neutral_one(neutral: dict[str, Path], tmp_path: Path) -> None:
    """As a start value, and by a connection with an offset: moorings carry 10 t."""
    system = floated(neutral, tmp_path).prepared.system
    lighter = system.changed(start={f"buoy.{MASS}": "90 t"})
    moored = replace(
        system, connections=(*CONNECTIONS, f"hydro.float.neutral_mass - 1e4 -> buoy.{MASS}")
    )
    for changed in (lighter, moored):
        (told,) = run(changed, results=tmp_path / "r.nc").warnings
        assert "are 882.9 kN at the start, the still water carries 981 kN" in told


def test_a_neutral_mass_leaves_out_other_forces(neutral: dict[str, Path], tmp_path: Path) -> None:
    """Lines pull down with 98.1 kN, the weight of 10 t: the connection that is told is right."""
    (told,) = loaded(neutral, tmp_path).warnings
    assert "are 1079.1 kN at the start, the still water carries 981 kN" in told
    offset = f"hydro.float.neutral_mass - 10000 -> buoy.{MASS}"
    assert f"'{offset}' includes them" in told
    assert loaded(neutral, tmp_path, offset).warnings == ()


def test_a_neutral_mass_needs_a_body_in_water(neutral: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "system.yaml"
    text = f"""\
name: alone
components:
  buoy: {{fmu: {neutral["buoy"]}}}
  hydro: {{fmu: {neutral["hydro"]}}}
connections: []
simulation: {{stop_time: 1, step_size: 0.05}}
"""
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        prepare(path)
    (problem,) = caught.value.problems
    assert (problem.file, problem.line) == (str(path), 3)
    assert f"buoy.{MASS} has no value" in problem.message
    assert "'buoy.float <-> hydro.float'" in problem.remedy
    assert f"'hydro.float.neutral_mass -> buoy.{MASS}'" in problem.remedy
    assert f"start: {{{MASS}: 120 t}}" in problem.remedy
    for zero in (0, "0 t"):
        with pytest.raises(InputError, match=f"buoy.{MASS} has no value"):
            prepare(load_system(path).changed(start={f"buoy.{MASS}": zero}))
    with pytest.raises(InputError) as caught:
        prepare(load_system(path).changed(start={f"buoy.{MASS}": "-3 t"}))
    assert [p.message for p in caught.value.problems] == [
        f"start value '-3 t' of buoy.{MASS} is wrong"
    ]
    path.write_text(text.replace("  hydro", "  # hydro"))
    with pytest.raises(InputError, match="kind hydrodynamics"):
        prepare(path)


def test_a_neutral_mass_takes_one_body_in_water(neutral: dict[str, Path], tmp_path: Path) -> None:
    two = {**neutral, "water": neutral["hydro"]}
    with pytest.raises(InputError) as caught:
        floated(two, tmp_path, "buoy.float <-> water.float")
    assert any(
        f"buoy.{MASS} has two sources: hydro.float.neutral_mass and water.float.neutral_mass"
        in problem.message
        for problem in caught.value.problems
    )


def test_bodies_of_one_hinge_have_their_own_neutral_masses(tmp_path: Path) -> None:
    """In one component of two bodies, whichever way the names are."""
    model = tmp_path / "raft.model.yaml"
    model.write_text("""\
name: raft
bodies:
  fore: {mass: neutral, inertia: 1e6, added_mass: true}
  aft: {mass: neutral, inertia: 1e6, added_mass: true}
joints:
  sea: {type: floating, child: fore}
  hinge: {type: revolute, parent: fore, child: aft, parent_to_joint: [5, 0], joint_to_child: [5, 0]}
""")
    water = hydrodynamics_program(calm(bodies=("bow", "stern")), name="hydro")
    raft = build_fmu(model_program(load_model(model)), tmp_path / "raft.fmu", native=True)
    hydro = build_fmu(water, tmp_path / "hydro.fmu", native=True)
    system = System(
        name="raft",
        components=(Component("raft", FmuFile(raft)), Component("hydro", FmuFile(hydro))),
        connections=(
            "hydro.stern <-> raft.aft",
            "raft.fore <-> hydro.bow",
            "hydro.added_mass -> raft.added_mass",
        ),
        simulation=Simulation(1.0, 0.05),
    )
    found = [str(link) for link in prepare(system).wiring.initial_links if "neutral" in str(link)]
    assert sorted(found) == [
        "hydro.bow.neutral_mass -> raft.body.fore.neutral_mass",
        "hydro.stern.neutral_mass -> raft.body.aft.neutral_mass",
    ]
