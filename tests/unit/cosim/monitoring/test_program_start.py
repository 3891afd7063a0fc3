"""A composed program tells of its start what a coupled run of its parts tells."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.example_systems import EXAMPLES, example_system

from m4e_fmi.analysis import equilibrium
from m4e_fmi.cosim import System, load_system, program_start_warnings, run, system_program
from m4e_fmi.simulate import started

FLOATING = {"body.body.sphere.z": -1.0, "body.body.sphere.theta": 0.2, "body.body.sphere.x": 5.0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("build")


def both(system: System, folder: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Warnings of the program, and those of the run but for its coupling error and its length."""
    outcome = run(system.changed(stop_time=0.1), build_directory=folder)
    other = "coupling error", "within the ramp"
    of_run = tuple(line for line in outcome.warnings if not any(word in line for word in other))
    return program_start_warnings(system, system_program(system)), of_run


@pytest.mark.parametrize(
    ("start", "count"), [({}, 1), ({"body.m": 2e5}, 2), (FLOATING, 3)], ids=["as is", "m", "pose"]
)
def test_the_warnings_of_a_run(start: dict[str, float], count: int, folder: Path) -> None:
    """Weight, and the pose in three coordinates, with the same numbers."""
    system = load_system(EXAMPLES / "sphere_decay" / "system.yaml").changed(start=start)
    told, of_run = both(system, folder)
    assert told == of_run
    assert len(told) == count


def test_connected_forces_count(folder: Path) -> None:
    """The pretension of the generator, whose force comes through a connection."""
    system = example_system("moored_buoy/system.yaml", without="mooring")
    told, of_run = both(system.changed(start={"generator.pretension": 1e6}), folder)
    assert told == of_run
    assert "connected forces" in told[0]


def test_what_is_balanced_where_it_starts_is_not_out_of_balance() -> None:
    """A sphere that is too light, at its start and where it is at rest: the pose is told then."""
    system = load_system(EXAMPLES / "sphere_decay" / "system.yaml")
    program = started(system_program(system), {"body.m": 2.4e5})
    weight, pose = "weight and connected forces are", "water.sphere.z starts at"
    z = "body.body.sphere.z"
    rest = equilibrium(program).values
    for place, count in ((-2.0, 1), (rest[z], 0), (rest[z] + 0.01, 1)):
        told = program_start_warnings(system, program.with_start({**rest, z: place}))
        assert sum(weight in line for line in told) == count
        assert any(pose in line for line in told) is (place != -2.0)
