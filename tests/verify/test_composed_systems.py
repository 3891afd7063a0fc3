"""Stated errors of 75 more random systems against the same equations as one program."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.cart_systems import cart_system

from m4e_fmi.cosim import reference, run, system_program


@pytest.mark.verify
@pytest.mark.parametrize("seed", range(25, 100))
def test_stated_errors_of_random_systems(seed: int, tmp_path: Path) -> None:
    system = cart_system(tmp_path, seed)
    outcome = run(system, build_directory=tmp_path / "build", results=tmp_path / "results.nc")
    found = reference(outcome, system_program(system))
    worst = max(found.errors, key=lambda error: error.actual / (error.stated + 1e-8))
    print(f"seed {seed}, {system.simulation.algorithm}: {worst}")
    assert all(error.actual <= 3 * error.stated + 1e-8 for error in found.errors)
