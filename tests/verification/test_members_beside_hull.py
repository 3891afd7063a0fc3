"""Components that load one body together: sums of wrenches and of added masses."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.calm_water import calm

from m4e_adapters.hydrodynamics import hydrodynamics_program
from m4e_fmi.cosim import (
    Outcome,
    System,
    load_system,
    prepare,
    run,
    save_system,
    start,
    system_program,
)
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.simulate import simulate

HEAVE = (
    "{type: prismatic, child: float, direction: [0, 1], parent_to_joint: [0, -1], "
    "initial: {q: 0.4}}"
)
FREE = "{type: floating, child: float, initial: {x: 0.4, z: -1.0, theta: 0.2}}"
MODEL = """\
name: buoy
gravity: 9.81
bodies: {{float: {{mass: 100e3, inertia: 1e6, added_mass: true}}}}
joints: {{sea: {joint}}}
"""
MEMBERS = """\
    kind: morison
    water: {{density: 1000, depth: 60, gravity: 9.81}}
    waves: {waves}
    bodies: {{float: {{center_of_gravity: [0, -1]}}}}
    members:
"""
LEGS = """\
      plate:
        {{ends: [[-4, -6], [4, -6]], diameter: 1.5, drag: {drag}, added_mass: {added},
          buoyancy: false, body: float}}
      leg:
        {{ends: [[1, -6], [1, -1.5]], diameter: 0.9, drag: {drag}, added_mass: {added},
          buoyancy: false, body: float}}
"""
STILL = "{spectrum: still}"
WAVES = "{spectrum: regular, height: 1, period: 6}"


def written(
    folder: Path, parts: dict[str, str], joint: str = HEAVE, algorithm: str = "corrector"
) -> System:
    """A system of the buoy, moved by `parts`, which all have the connectors of its body."""
    folder.mkdir(exist_ok=True)
    (folder / "buoy.model.yaml").write_text(MODEL.format(joint=joint), "utf-8")
    lines = ["name: buoy", "components:", "  buoy: {model: buoy.model.yaml}"]
    lines += [f"  {name}:\n{text}" for name, text in parts.items()]
    lines += ["connections:", *(f"  - buoy.float <-> {name}.float" for name in parts)]
    lines += [f"  - {name}.added_mass -> buoy.added_mass" for name in parts]
    lines.append(f"simulation: {{stop_time: 6, step_size: 0.02, algorithm: {algorithm}}}")
    (folder / "system.yaml").write_text("\n".join([*lines, ""]), "utf-8")
    return load_system(folder / "system.yaml")


def members(added: float, drag: float, waves: str = STILL) -> str:
    """A component of two members."""
    return (MEMBERS + LEGS).format(added=added, drag=drag, waves=waves)


def hull(folder: Path, added_mass: float) -> str:
    """A component of a hull with this added mass in heave [kg]."""
    folder.mkdir(exist_ok=True)
    coefficients = calm(("float",))
    inf = np.diag([0.0, added_mass, 0.0])
    coefficients = replace(coefficients, added_mass_inf=inf)
    path = folder / "hull.fmu"
    build_fmu(hydrodynamics_program(coefficients, name="hull"), path, native=True)
    return "    {fmu: hull.fmu}"


def coupled(system: System, folder: Path) -> Outcome:
    """A run."""
    return run(prepare(system, build_directory=folder / "build"), results=folder / "r.nc")


def composed(system: System) -> np.ndarray:
    """Height of the body [m] in a run of the composed program."""
    result = simulate(system_program(system), stop_time=6.0, output_interval=0.1, tolerance=1e-12)
    return np.asarray(result["buoy.body.float.z"])


@pytest.mark.verifies(
    "a hull and members beside it move one body as a hull whose coefficients contain both: added "
    "masses add up, coupled and composed",
    analytic="equality",
    tolerance="1e-12",
)
def test_hull_and_members_are_as_one_hull_of_both(tmp_path: Path) -> None:
    """In heave, the member's added mass is ρ π D²/4 C_A times its length across."""
    across = 1000 * math.pi / 4 * 1.5**2 * 0.8 * 8.0
    one, two = tmp_path / "one", tmp_path / "two"
    alone = written(one, {"hull": hull(one, 30e3 + across)})
    both = written(two, {"hull": hull(two, 30e3), "members": members(0.8, 0.0)})
    assert composed(both) == pytest.approx(composed(alone), abs=1e-12)
    outcomes = coupled(alone, one), coupled(both, two)
    heights = [np.asarray(o.results()["buoy.body.float.z"].values) for o in outcomes]
    assert np.ptp(heights[0]) > 0.5
    assert heights[1] == pytest.approx(heights[0], abs=1e-12)
    with start(both, build_directory=two / "build") as stepped:
        for _ in itertools.islice(stepped, 3):
            assert stepped["buoy.added_mass[2,2]"] == pytest.approx(30e3 + across)


@pytest.mark.verifies(
    "drag, inertia and added mass of members split between two components move a body as together",
    analytic="equality",
    tolerance="3e-10 of the range",
)
def test_split_coefficients_are_as_the_whole(tmp_path: Path) -> None:
    """C_M is 1 + C_A; the split parts have the inertia 1.5 and 0.9 of 2.4 in all.

    Rounding chooses the adaptive steps: 300 of them, each off by up to its tolerance of 1e-12.
    """
    whole = members(1.4, 1.1, WAVES)
    first, second = members(0.5, 0.3, WAVES), members(0.9, 0.8, WAVES)
    second = second.replace("added_mass: 0.9", "added_mass: 0.9, inertia: 0.9")
    systems = [
        written(tmp_path / name, parts, FREE)
        for name, parts in (("one", {"all": whole}), ("two", {"a": first, "b": second}))
    ]
    one, two = (composed(s) for s in systems)
    assert np.ptp(one) > 0.5
    assert two == pytest.approx(one, abs=3e-10 * np.abs(one).max())
    outcomes = [coupled(s, tmp_path / n) for s, n in zip(systems, ("one", "two"), strict=True)]
    heights = [np.asarray(o.results()["buoy.body.float.z"].values) for o in outcomes]
    assert heights[1] == pytest.approx(heights[0], abs=1e-9)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_energies_of_connections_add_up(tmp_path: Path, algorithm: str) -> None:
    """Each connection has its own balance; together they are that of one component of both."""
    whole = {"all": members(1.5, 1.0, WAVES)}
    second = members(0.5, 0.6, WAVES).replace("added_mass: 0.5", "added_mass: 0.5, inertia: 0.5")
    split = {"a": members(1.0, 0.4, WAVES), "b": second}
    found = [
        coupled(written(tmp_path / name, parts, HEAVE, algorithm), tmp_path / name).energy
        for name, parts in (("one", whole), ("two", split))
    ]
    (one,), two = found
    assert [bond.connection for bond in two] == [f"buoy.float <-> {n}.float" for n in "ab"]
    assert sum(bond.given for bond in two) == pytest.approx(one.given, rel=1e-6)
    assert sum(bond.received for bond in two) == pytest.approx(one.received, rel=1e-6)
    assert all(bond.adds == () for bond in two)


def test_sums_travel_in_packages_and_fmus(tmp_path: Path) -> None:
    parts = {"a": members(1.0, 0.4), "b": members(0.5, 0.6)}
    system = written(tmp_path, parts)
    package = save_system(system, tmp_path / "buoy.ssp", build_directory=tmp_path / "build")
    again = load_system(package)
    assert {c.name for c in again.components} >= {"buoy_body_float_sum", "buoy_added_mass_sum"}
    one = coupled(system, tmp_path)
    two = run(prepare(again, build_directory=tmp_path / "again"), results=tmp_path / "again.nc")
    heights = [np.asarray(o.results()["buoy.body.float.z"].values) for o in (one, two)]
    assert heights[1] == pytest.approx(heights[0], abs=1e-12)
    program = system_program(system)
    assert build_fmu(program, tmp_path / "whole.fmu", native=True).is_file()
    assert any("takes the sum of a.float, b.float" in n for n in prepare(system).notes)


def test_motions_do_not_add_up(tmp_path: Path) -> None:
    system = written(tmp_path, {"a": members(1.0, 0.4), "b": members(0.5, 0.6)})
    wrong = replace(system, connections=(*system.connections, "b.wave.elevation -> a.float.z"))
    with pytest.raises(InputError, match=r"a\.float\.z has two sources"):
        prepare(wrong, build_directory=tmp_path / "build")
