"""RM3 from WAMIT files with all six motions of both bodies: the float released 1 m above its rest.

The memories of surge, sway, roll and pitch take a minute to fit: the data of these motions scatter.
"""

from __future__ import annotations

from pathlib import Path

from support.coefficient_files import check_heave_only, rm3_system

from m4e_fmi.cosim import load_system, system_program
from m4e_fmi.simulate import simulate


def test_only_heave_moves(tmp_path: Path) -> None:
    program = system_program(load_system(rm3_system(tmp_path)))
    found = simulate(program, stop_time=100.0, output_interval=0.1, tolerance=1e-9)
    check_heave_only(found)
