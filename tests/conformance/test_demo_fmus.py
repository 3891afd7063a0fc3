"""The four FMUs of the demo, and the demo itself: valid, reproducible, alone and together.

Native where they are programs; the mooring is of Python.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Network,
    Simulation,
    System,
    fmu_files,
    load,
    load_system,
    run,
)
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.missing import loose_ends, unconnected_parameters
from m4e_fmi.fmu import read_description, validate_fmu

EXAMPLE = Path(__file__).parents[2] / "examples" / "moored_buoy" / "system.yaml"
NAMES = ("buoy", "hydro", "mooring", "generator")


@pytest.fixture(scope="module")
def system() -> System:
    return load_system(EXAMPLE)


@pytest.fixture(scope="module")
def files(system: System, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return fmu_files(system, tmp_path_factory.mktemp("build"), native=True)


@pytest.mark.parametrize("name", NAMES)
def test_no_finding(files: dict[str, Path], name: str):
    # each start of MoorDyn looks for its rest first: all groups would take a minute
    only = ("description", "start") if name == "mooring" else ()
    assert validate_fmu(files[name], only=only).of_severity("error", "warning") == ()


def test_same_bytes_when_built_again(system: System, files: dict[str, Path], tmp_path: Path):
    again = fmu_files(system, tmp_path, native=True)
    for name in NAMES:
        assert again[name].read_bytes() == files[name].read_bytes()


@pytest.fixture(scope="module")
def outcome(system: System, files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory):
    """The demo, in a sea that is fully there after ten seconds."""
    folder = tmp_path_factory.mktemp("run")
    del files  # built already; the stamps say so
    return run(system, results=folder / "buoy.nc", build_directory=folder)


def test_the_readme_has_its_numbers(outcome):
    """Each number to its last digit."""
    readme = (EXAMPLE.parents[2] / "README.md").read_text(encoding="utf-8")
    results = load(outcome.path)
    power = results["generator.energy"].values[-1] / results.time[-1] / 1e3
    tension = results["mooring.line_1.fairlead_tension"].values.max() / 1e3
    surge = np.abs(results["buoy.body.float.x"].values).max()
    shown = f"{power:.1f} kW mean power, {tension:.0f} kN peak line tension, {surge:.1f} m largest"
    assert shown in " ".join(readme.split())


def test_floats_where_it_should(outcome):
    results = load(outcome.path)
    # the mass balances buoyancy and lines: within a centimetre of the reference pose at rest,
    # and the waves of Hs = 2 m move it by less than 2 m
    assert results["buoy.body.float.z"].values[0] == pytest.approx(-1.2, abs=1e-12)
    assert np.abs(results["buoy.body.float.z"].values + 1.2).max() < 2.0
    assert np.abs(results["buoy.body.float.theta"].values).max() < np.radians(20)
    assert results["generator.power"].values.min() >= 0
    assert results["generator.energy"].values[-1] > 0


def test_added_mass_is_in_the_mass_matrix(system: System, files: dict[str, Path]):
    """A force at t = 0 accelerates dry mass and added mass; the sea is symmetric, heave alone."""
    loose = replace(
        system,
        connections=tuple(c for c in system.connections if "generator" not in c),
        simulation=Simulation(stop_time=0.05, step_size=0.05),
    )
    folder = files["buoy"].parents[1]
    force = 1.0e6  # N
    seen: list[dict[str, float]] = []

    def observe(t: float, network: Network) -> None:
        if t == 0.0:
            names = ("buoy.body.float.az", "hydro.added_mass[2,2]")
            seen.append({name: network.read(name) for name in names})

    for upward in (0.0, force):
        changed = loose.changed(start={"buoy.point.pto.force_z": upward})
        run(changed, build_directory=folder, observers=[observe])
    rise = seen[1]["buoy.body.float.az"] - seen[0]["buoy.body.float.az"]
    added_mass = seen[0]["hydro.added_mass[2,2]"]
    assert added_mass > 50e3
    # couplings of heave with surge and pitch vanish by symmetry, but for the mesh's roundness
    assert force / rise == pytest.approx(143.2e3 + added_mass, rel=1e-6)


def test_each_connection_that_is_left_out_is_told(system: System, files: dict[str, Path]):
    found = {name: read_description(file) for name, file in files.items()}

    def told(connections: tuple[str, ...]) -> list[str]:
        part = replace(system, connections=connections)
        wiring = connect(part, found)
        return [*unconnected_parameters(part, found, wiring), *loose_ends(part, found, wiring)]

    wiring = connect(system, found)
    single = tuple(f"{k.source} -> {k.target}" for k in (*wiring.links, *wiring.initial_links))
    assert len(single) == 36
    for connections in (system.connections, single):
        assert told(connections) == []
        for left_out in connections:
            assert len(told(tuple(c for c in connections if c != left_out))) == 1, left_out


def test_energy_balances_over_every_connection(outcome):
    assert len(outcome.energy) == 4
    for bond in outcome.energy:
        # second order: (ωH)²/12 with H = 0.025 s and the fastest motion that matters, ω = 4 rad/s
        assert abs(bond.relative) < 0.00084
