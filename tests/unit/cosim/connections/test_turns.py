"""Roll and yaw of bodies in space jump by a turn; what the run states of its error does not."""

from __future__ import annotations

from pathlib import Path

from support.small_systems import Fmus

from m4e_fmi.cosim import Component, CouplingErrorReport, FmuFile, Simulation, System, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Body, Joint, Model
from m4e_fmi.multibody import model_program


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
