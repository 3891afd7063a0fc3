"""FMUs with undeclared static variables."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus

from m4e_fmi.cosim import Component, CouplingErrorReport, FmuFile, Simulation, System, load, run

VERSIONS = ["", "1:", "3:"]


@pytest.mark.verifies(
    "integrals of components that share one file with static variables",
    analytic="exact solution",
    tolerance="identical",
)
@pytest.mark.parametrize("version", VERSIONS)
def test_two_components_of_one_file(c_fmu: Fmus, tmp_path: Path, version: str) -> None:
    parts = tuple(
        Component(f"c{k}", FmuFile(c_fmu(f"{version}keeper")), {"u": float(k)}) for k in range(4)
    )
    run(System("s", parts, (), Simulation(1.0, 0.125)), results=tmp_path / "r.nc", certify=False)
    found = load(tmp_path / "r.nc")
    for k in range(4):
        np.testing.assert_array_equal(found[f"c{k}.y"].values, k * found.time)


@pytest.mark.verifies(
    "results beside a second set of instances of such a file",
    analytic="sum of the steps by Jacobi",
    tolerance="1e-13",
)
@pytest.mark.parametrize("version", VERSIONS)
def test_the_second_set_of_the_certificate(c_fmu: Fmus, tmp_path: Path, version: str) -> None:
    """None of these can go back, so that a second set of instances goes beside the run."""
    keeper = FmuFile(c_fmu(f"{version}keeper"))
    parts = (Component("a", keeper, {"u": 1.0}), Component("b", keeper))
    system = System("s", parts, ("a.y -> b.u",), Simulation(1.0, 0.125, "jacobi"))
    outcome = run(system, results=tmp_path / "r.nc")
    found = load(tmp_path / "r.nc")
    t = found.time
    np.testing.assert_array_equal(found["a.y"].values, t)
    np.testing.assert_allclose(found["b.y"].values, t * (t - 0.125) / 2, rtol=1e-13)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    # b.y is of first order: half the step would leave half of t H/2, of a range of 7/16
    assert outcome.certificate.errors[0].error == pytest.approx(0.0625 / 1.0, rel=0.5)


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("version", ["", "1:", "3:"])
@pytest.mark.parametrize("process", ["here", "own"])
def test_a_way_to_round_that_an_fmu_leaves_behind_changes_nothing(
    c_fmu: Fmus, tmp_path: Path, process: str, version: str
) -> None:
    """It rounds upward from its first step on; the equations are chaotic."""
    found = []
    for option in ("", "+rounds"):
        x, yz = (f"{version}roessler_{part}+inputs{option}" for part in ("x", "yz"))
        if version == "3:":
            x, yz = (name.replace("+inputs", "") for name in (x, yz))
        parts = (
            Component("yz", FmuFile(c_fmu(yz)), {"y": 1.0, "z": 0.5}, process=process),
            Component("x", FmuFile(c_fmu(x)), {"x": 2.0}, process=process),
        )
        links = ("yz.y -> x.y", "yz.z -> x.z", "x.x -> yz.x")
        system = System("s", parts, links, Simulation(10.0, 0.05))
        run(system, results=tmp_path / "r.nc", certify=False)
        rows = load(tmp_path / "r.nc")
        found.append(np.column_stack([rows[name].values for name in ("yz.y", "yz.z", "x.x")]))
    np.testing.assert_array_equal(found[0], found[1])
    assert 1.0 + 1e-17 == 1.0  # rounded upward, it is more
