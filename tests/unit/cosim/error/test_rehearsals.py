"""Steps that are made again for the coupling error leave no trace in the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Simulation,
    System,
    run,
    start,
)
from m4e_fmi.cosim.error import estimator
from m4e_fmi.cosim.error.trajectory import Trajectory
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program

Fmus = Callable[[str], Path]


def pair(fmus: Fmus) -> System:
    a = Component("a", FmuFile(fmus("mass+state")), {"body.m.x": 1.0, "stiffness": 1.0})
    b = Component("b", FmuFile(fmus("partner+state")))
    return System("s", (a, b), ("a.m <-> b.end",), Simulation(4.0, 0.05))


def test_an_interrupted_rehearsal_leaves_the_run_where_it_is(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimator, "FIRST", 20)
    with start(pair(c_fmu)) as execution:
        straight = [point["a.body.m.x"] for point in execution]
    usual, calls = Trajectory.along, []

    def interrupted(self: Trajectory, *arguments: Any) -> np.ndarray:
        calls.append(1)
        found = usual(self, *arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return found

    monkeypatch.setattr(Trajectory, "along", interrupted)
    found = []
    with start(pair(c_fmu)) as execution:
        found.append(execution["a.body.m.x"])
        while not execution.done:
            try:
                execution.step()
            except KeyboardInterrupt:  # before the step, which can be made then
                assert len(calls) == 1
                continue
            found.append(execution["a.body.m.x"])
    assert calls
    assert found == straight
    assert str(execution.outcome.certificate) == str(run(pair(c_fmu)).certificate)


def test_a_spinning_body_is_no_coupling_error(c_fmu: Fmus, tmp_path: Path) -> None:
    """About Z at 20 rad/s, driven: its yaw jumps from 180 to -180 degrees in each of its turns."""
    top = Model(
        name="top",
        gravity=0.0,
        bodies={"top": Body(1.0, (0.4, 0.4, 0.4))},
        joints={"air": Joint("floating", "top", initial={"omega_z": 20.0})},
        dimensions=3,
    )
    path = build_fmu(model_program(top), tmp_path / "top.fmu", native=True)
    drive = Component("drive", FmuFile(c_fmu("mass+state")), {"stiffness": 9.0, "body.m.x": 1.0})
    parts = (drive, Component("top", FmuFile(path)))
    link = "drive.body.m.x * 4 -> top.body.top.moment_z, units ignored"
    system = System("s", parts, (link,), Simulation(4.0, 0.01, algorithm="jacobi"))
    outcome = run(system, results=tmp_path / "r.nc")
    yaw = outcome.results()["top.body.top.psi"].values
    assert (abs(yaw[1:] - yaw[:-1]) > 6.0).sum() > 10
    assert isinstance(outcome.certificate, CouplingErrorReport)
    # held moments are half a step late: 0.005 s * 10 rad/s2 * 4 s = 0.2 rad, half of it in e, of 2
    assert outcome.certificate.errors[0].error < 0.1
