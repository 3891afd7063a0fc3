"""Floating bodies that do not float where they were said to: told with both numbers.

A buoy of 100 t displacement and 50 m2 of waterplane, in water without waves or radiation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML
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

GIVEN: dict[str, Any] = YAML(typ="safe").load(Path(__file__).with_name("floating.yaml"))["plane"]
MODEL, NEUTRAL = GIVEN["buoys"]["buoy"], GIVEN["buoys"]["neutral"]
MASS = "body.float.neutral_mass"
INCLUDED = f"hydro.float.neutral_mass - 10000 -> buoy.{MASS}"
Fmus = Callable[[str], Path]
CONNECTIONS = ("buoy.float <-> hydro.float", "hydro.added_mass -> buoy.added_mass")
BUOYS = dict(GIVEN["buoys"])
for name, (model, force) in GIVEN["pulled"].items():
    load = f"loads: {{lines: {{type: body_force, body: float, force: [0, {force}]}}}}\n"
    BUOYS[name] = BUOYS[model] + load


def built(folder: Path, name: str, text: str, *, native: bool = True) -> Path:
    """The FMU of a model."""
    model = folder / f"{name}.model.yaml"
    model.write_text(text)
    return build_fmu(model_program(load_model(model)), folder / f"{name}.fmu", native=native)


def water(path: Path, coefficients: Coefficients) -> Path:
    """The FMU of the water around bodies."""
    return build_fmu(hydrodynamics_program(coefficients, name="hydro"), path, native=True)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """`fmus(name)` is the FMU of a water or a buoy."""
    folder = tmp_path_factory.mktemp("fmus")

    @cache
    def made(name: str) -> Path:
        if name in GIVEN["waters"]:
            return water(folder / f"{name}.fmu", calm(("float",), **GIVEN["waters"][name]))
        return built(folder, name, BUOYS[name])

    return made


def floated(
    fmus: Fmus,
    folder: Path,
    *connections: str,
    buoy: str = "buoy",
    water: str = "hydro",
    **start: float | str,
) -> Outcome:
    """A run of a buoy in a water."""
    parts = {"buoy": buoy, "hydro": water}
    system = System(
        name="float",
        components=tuple(Component(name, FmuFile(fmus(fmu))) for name, fmu in parts.items()),
        connections=(*CONNECTIONS, *connections),
        simulation=Simulation(8.0, 0.05),
    )
    names = {"m": "buoy.m"} | {key: f"buoy.body.float.{key}" for key in ("x", "z", "theta")}
    changed = system.changed(start={names[key]: value for key, value in start.items()})
    return run(changed, results=folder / "r.nc")


@pytest.mark.parametrize("case", GIVEN["starts"], ids=lambda case: str(case["given"]))
def test_the_warning_of_a_start(fmus: Fmus, tmp_path: Path, case: dict[str, Any]) -> None:
    lines, texts = floated(fmus, tmp_path, **case["given"]).warnings, case.get("told", ())
    assert bool(lines) == bool(texts)
    assert all(text in lines[0] for text in texts)
    assert len(lines) == bool(texts) or case.get("more")


def test_a_hinge_carries_the_weight(fmus: Fmus, tmp_path: Path) -> None:
    """A body that stands on a hinge need not be in balance by itself."""
    told = floated(fmus, tmp_path, buoy="flap").warnings
    assert not any("still water carries" in text for text in told)


def test_motions_that_are_not_small_are_told_once(fmus: Fmus, tmp_path: Path) -> None:
    """Half the mean draft of 2 m is left at once from 1.1 m below, 15 deg by a turn of 16; a body
    that is too heavy leaves it later: the first time is told."""
    outcome = floated(fmus, tmp_path, z=-2.1)
    start, sinks = outcome.warnings
    told = outcome.results().attributes["notes"].splitlines()  # from where a report takes them
    assert {f"warning: {start}", f"warning: {sinks}"} <= set(told)
    assert sinks.startswith("hydro.float.heave is -1.1 m at t = 0 s, outside -1 to 1 m")
    assert "within 0.5 of the mean draft" in sinks
    _, turns = floated(fmus, tmp_path, theta="16 deg").warnings
    assert "hydro.float.pitch is 0.2793 rad at t = 0 s, outside -0.2618 to 0.2618 rad" in turns
    outcome = floated(fmus, tmp_path, m="156 t")  # sinks by up to 2.24 m
    (left,) = (line for line in outcome.warnings if "heave" in line)
    results = outcome.results()
    heave = results["hydro.float.heave"].values
    first = int(np.argmax(np.abs(heave) > 1.0))
    assert f"is {heave[first]:.4g} m at t = {results.time[first]:.9g} s" in left


def heave(outcome: Outcome) -> np.ndarray:
    return outcome.results()["buoy.body.float.z"].values


def test_a_neutral_mass_comes_with_the_connection_of_the_bodies(fmus: Fmus, tmp_path: Path) -> None:
    """To the bits of the mass that is connected by hand; also from an SSP package."""
    by_hand = floated(fmus, tmp_path, "hydro.float.neutral_mass -> buoy.m")
    wanted = heave(by_hand)
    outcome = floated(fmus, tmp_path, buoy="neutral")
    assert by_hand.warnings == outcome.warnings == ()
    assert wanted == pytest.approx(-1.0, abs=1e-9)
    assert np.array_equal(heave(outcome), wanted)
    assert "hydro.float.neutral_mass: transferred once" in str(outcome.prepared)
    package = save_system(outcome.prepared.system, tmp_path / "float.ssp", build_directory=tmp_path)
    again = run(load_system(package), results=tmp_path / "again.nc", build_directory=tmp_path)
    assert np.array_equal(heave(again), wanted)
    # the connection that is told where lines pull is right
    assert floated(fmus, tmp_path, INCLUDED, buoy="neutral, pulled").warnings == ()


def test_a_python_fmu_has_its_neutral_mass_before_it_tells_anything(
    fmus: Fmus, tmp_path: Path
) -> None:
    """It computes all its outputs when one is asked for."""
    buoy = built(tmp_path, "buoy", NEUTRAL, native=False)
    system = floated(fmus, tmp_path, buoy="neutral").prepared.system
    parts = (replace(system.components[0], source=FmuFile(buoy)), system.components[1])
    outcome = run(replace(system, components=parts), results=tmp_path / "r.nc")
    assert heave(outcome) == pytest.approx(-1.0, abs=1e-9)


def test_a_given_mass_wins_over_the_neutral_one(fmus: Fmus, tmp_path: Path) -> None:
    """As a start value, and by a connection with an offset: moorings carry 10 t."""
    system = floated(fmus, tmp_path, buoy="neutral").prepared.system
    lighter = system.changed(start={f"buoy.{MASS}": "90 t"})
    moored = replace(system, connections=(*CONNECTIONS, INCLUDED))
    for changed in (lighter, moored):
        (told,) = run(changed, results=tmp_path / "r.nc").warnings
        assert "are 882.9 kN at the start, the still water carries 981 kN" in told


def test_a_neutral_mass_needs_a_body_in_water(fmus: Fmus) -> None:
    parts = {"buoy": "neutral", "hydro": "hydro", "water": "hydro"}
    alone, *_ = components = tuple(Component(n, FmuFile(fmus(fmu))) for n, fmu in parts.items())
    system = System("alone", components, (), Simulation(1.0, 0.05))
    with pytest.raises(InputError, match=f"buoy.{MASS} has no value") as caught:
        prepare(system)
    remedy = caught.value.problems[0].remedy
    assert "'buoy.float <-> hydro.float'" in remedy
    for wrong in (0, "0 t", "-3 t"):
        with pytest.raises(InputError, match=f"buoy.{MASS}"):
            prepare(system.changed(start={f"buoy.{MASS}": wrong}))
    with pytest.raises(InputError, match="kind hydrodynamics"):
        prepare(replace(system, components=(alone,)))
    two = replace(system, connections=(*CONNECTIONS, "buoy.float <-> water.float"))
    sources = "two sources: hydro.float.neutral_mass and water.float.neutral_mass"
    with pytest.raises(InputError, match=sources):
        prepare(two)


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
    hulls = calm(("fore", "aft"), places=(-5.0, 5.0))
    return System(
        name="raft",
        components=(
            Component("raft", FmuFile(built(folder, "raft", text))),
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
    assert "to float there, 40000 kg less" in weight
    assert trim.startswith("raft.body.fore and body.aft: a moment of -1962 kN.m about the middle")


def test_bodies_of_one_hinge_have_their_own_neutral_masses(tmp_path: Path) -> None:
    """In one component of two bodies, whichever way the names are."""
    system = raft(tmp_path, RAFT.replace("mass: m,", "mass: neutral,").replace("para", "# para"))
    hulls = water(tmp_path / "hulls.fmu", calm(("bow", "stern"), places=(-5.0, 5.0)))
    parts = (system.components[0], replace(system.components[1], source=FmuFile(hulls)))
    links = ("hydro.stern <-> raft.aft", "raft.fore <-> hydro.bow", system.connections[-1])
    prepared = prepare(replace(system, components=parts, connections=links))
    found = [str(link) for link in prepared.wiring.initial_links if "neutral" in str(link)]
    assert sorted(found) == [
        "hydro.bow.neutral_mass -> raft.body.fore.neutral_mass",
        "hydro.stern.neutral_mass -> raft.body.aft.neutral_mass",
    ]
