"""What a study takes from the outcome of a run."""

from __future__ import annotations

import math

from m4e_fmi.cosim.connections.links import Port
from m4e_fmi.cosim.error_estimate.report import CouplingError, CouplingErrorReport
from m4e_fmi.study.systems.task import coupling_error_of


def test_the_coupling_error_is_the_one_that_a_single_run_tells() -> None:
    """What switches a step earlier is off by its whole jump, and says nothing of the others."""
    switch = CouplingError("a -> b", Port("a", "y"), 1.0, 0.5, 20.0, switched=True)
    motion = CouplingError("b -> a", Port("b", "x"), 0.02, 0.01, 1.0)
    report = CouplingErrorReport((switch, motion))
    assert str(report).startswith("largest coupling error 2.0e-02")
    assert coupling_error_of(report) == (0.02, "b.x")
    assert math.isnan(coupling_error_of("not known")[0])
