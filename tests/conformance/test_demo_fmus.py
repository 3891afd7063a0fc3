"""The four FMUs of the demo, and the demo itself: valid, reproducible, alone and together.

Native where they are programs (`files`), and all of Python (`python_files`).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    fmu_files,
    load,
    load_system,
    run,
)
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.cosim.connections.missing.loose_ends import loose_ends
from m4e_fmi.cosim.connections.missing.unconnected_parameters import unconnected_parameters
from m4e_fmi.fmu import read_description, validate_fmu

EXAMPLE = Path(__file__).parents[2] / "examples" / "moored_buoy" / "system.yaml"
NAMES = ("buoy", "hydro", "mooring", "generator")
SEEN = (
    "buoy.body.float.x",
    "buoy.body.float.theta",
    "hydro.float.force_z",
    "mooring.line_1.fairlead_tension",
    "generator.power",
)


@pytest.fixture(scope="module")
def system() -> System:
    return load_system(EXAMPLE)


@pytest.fixture(scope="module")
def files(system: System, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return fmu_files(system, tmp_path_factory.mktemp("build"), native=True)


@pytest.fixture(scope="module")
def python_files(system: System, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return fmu_files(system, tmp_path_factory.mktemp("python"), native=False)


@pytest.mark.parametrize("name", NAMES)
def test_no_finding(files: dict[str, Path], python_files: dict[str, Path], name: str):
    # each start of MoorDyn looks for its rest first: all groups would take a minute
    only = ("description", "start") if name == "mooring" else ()
    for fmu in {files[name], python_files[name]}:
        assert validate_fmu(fmu, only=only).of_severity("error", "warning") == ()


def test_same_bytes_when_built_again(
    system: System, files: dict[str, Path], python_files: dict[str, Path], tmp_path: Path
):
    for native, before in ((True, files), (False, python_files)):
        again = fmu_files(system, tmp_path / str(native), native=native)
        for name in NAMES:
            assert again[name].read_bytes() == before[name].read_bytes()
    assert files["mooring"].read_bytes() == python_files["mooring"].read_bytes()
    assert files["hydro"].stat().st_size < python_files["hydro"].stat().st_size


@pytest.mark.parametrize("name", NAMES)
def test_plain_fmpy_twice_in_one_process(
    files: dict[str, Path], python_files: dict[str, Path], name: str
):
    """Both times the same bits, which the Python FMU gives, too."""
    first, *others = (
        fmpy.simulate_fmu(str(fmu), stop_time=1.0, step_size=0.05)
        for fmu in (files[name], files[name], python_files[name])
    )
    assert first["time"][-1] == pytest.approx(1.0)
    assert len(first.dtype.names or ()) > 1
    for column in first.dtype.names or ():
        assert np.isfinite(first[column]).all()
        for other in others:
            assert np.array_equal(first[column], other[column])


def test_native_components_change_no_bit(
    system: System, files: dict[str, Path], python_files: dict[str, Path]
):
    """With inputs held, both kinds of FMU get the same calls and give the same numbers."""
    shorter = system.changed(stop_time=5.0, algorithm="gauss_seidel")
    seen: list[dict[str, list[float]]] = []
    for found in (files, python_files):
        fixed = replace(
            shorter,
            components=tuple(Component(name, FmuFile(found[name])) for name in NAMES),
        )
        series: dict[str, list[float]] = {name: [] for name in SEEN}

        def observe(_: float, network: Network, into: dict[str, list[float]] = series) -> None:
            for name, values in into.items():
                values.append(network.read(name))

        run(fixed, observers=[observe])
        seen.append(series)
    assert seen[0] == seen[1]
    assert len(seen[0]["generator.power"]) == 201


@pytest.fixture(scope="module")
def outcome(system: System, files: dict[str, Path], tmp_path_factory: pytest.TempPathFactory):
    """A minute of the demo, in a sea that is fully there after ten seconds."""
    folder = tmp_path_factory.mktemp("run")
    del files  # built already; the stamps say so
    shorter = replace(system, simulation=replace(system.simulation, stop_time=60.0))
    return run(shorter, results=folder / "buoy.nc", build_directory=folder)


def test_results_have_units_and_names(outcome):
    results = load(outcome.path)
    assert set(results.components) == set(NAMES)
    assert results.time[-1] == pytest.approx(60.0)
    for component in results.components.values():
        assert component
        for series in component.values():
            assert series.unit
            assert series.long_name
            assert np.isfinite(series.values).all()


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
