"""Stated errors of 75 more random systems, and of slow examples, against one program."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.cart_systems import ALGORITHMS, cart_system
from support.example_systems import example_system
from support.whole_solution import Reference, reference

from m4e_fmi.cosim import System, run, system_program


@pytest.mark.parametrize("seed", range(25, 100))
def test_stated_errors_of_random_systems(seed: int, tmp_path: Path) -> None:
    check(cart_system(tmp_path, seed), tmp_path)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize(("name", "stop_time"), [("moored_barge", 3.0), ("oc3_hywind", 6.0)])
def test_stated_errors_of_examples(
    name: str, stop_time: float, algorithm: str, tmp_path: Path
) -> None:
    """Without their lines, which are no equations."""
    system = example_system(f"{name}/system.yaml", without="mooring")
    check(system.changed(stop_time=stop_time, algorithm=algorithm), tmp_path)


def check(system: System, folder: Path) -> None:
    outcome = run(system, build_directory=folder / "build", results=folder / "results.nc")
    found: Reference = reference(outcome, system_program(system))
    worst = max(found.errors, key=lambda error: error.actual / (error.stated + 1e-8))
    print(f"{system.name}, {system.simulation.algorithm}: {worst}")
    assert all(error.actual <= 3 * error.stated + 1e-8 for error in found.errors)
