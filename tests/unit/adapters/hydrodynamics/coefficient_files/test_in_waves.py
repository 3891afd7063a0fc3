"""Coefficients of files in seas of several systems, with drift, and with loads switched off."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.coefficient_files import FLAP, SPHERE
from support.drift_files import RHO, G, write_mean
from support.hulls import configured
from support.programs import Evaluated

from m4e_adapters.hydrodynamics import coefficients_from_config
from m4e_adapters.hydrodynamics.build import program_from_config, program_in_waves
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program

FLAP_IN_SPACE = """\
dimensions: 3
coefficients: flap.nc
heading: 10
bodies: {oswec_flap: {center_of_gravity: [0, 0, -3.9]}}
loads: {radiation: none}
"""
BALL = "coefficients: ball.h5\nloads: {radiation: none}\nbodies: {ball: {drift: {file: ball.8}}}\n"
PLACE = 30  # of a frequency of the flap's file


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(SPHERE, tmp_path / "ball.h5")
    shutil.copy(FLAP, tmp_path / "flap.nc")
    return tmp_path


def program(text: str, folder: Path) -> Program:
    config = configured(text)
    return program_from_config(config, name="hydro", folder=folder, progress=lambda _: None)


def at(found: Program, time: float, part: str) -> dict[str, float]:
    """Outputs with `part` in their names."""
    values = Evaluated(found).outputs({}, t=time)
    return {name: value for name, value in values.items() if part in name}


def wave(period: float, direction: float, **keys: object) -> str:
    more = "".join(f", {key}: {value}" for key, value in keys.items())
    sea = f"spectrum: regular, height: 2, period: {period!r}, direction: {direction:g}"
    return f"{{{sea}, ramp_time: 0{more}}}"


def test_systems_take_the_excitation_of_their_directions(folder: Path) -> None:
    """Two waves at 20 and 60 deg from the hulls' axis; forces are those of the file, turned."""
    known = coefficients_from_config(
        configured(FLAP_IN_SPACE), folder=folder, progress=lambda _: None
    )
    omega = float(known.omega[PLACE])
    period = 2.0 * math.pi / omega
    waves = f"waves: [{wave(period, 30)}, {wave(period, 70, phase=0.5)}]\n"
    found = program(FLAP_IN_SPACE + waves, folder)
    time, expected = 3.0, np.zeros(6)
    for beta, phase in ((20.0, 0.0), (60.0, 0.5)):
        place = int(np.argmin(np.abs(known.directions - beta)))
        x = known.by_direction[PLACE, place]
        expected += np.real(x * np.exp(-1j * (omega * time + phase)))
    c, s = math.cos(math.radians(10.0)), math.sin(math.radians(10.0))
    for k in (0, 3):
        expected[k : k + 2] = np.array([[c, -s], [s, c]]) @ expected[k : k + 2]
    forces = at(found, time, "excitation_")
    names = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
    values = [forces[f"oswec_flap.excitation_{name}"] for name in names]
    assert values == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
    limits = {v.name: (v.minimum, v.maximum) for v in found.parameters}
    for name, angle in (("wave[1].direction", 30), ("wave[2].direction", 70), ("heading", 10)):
        assert limits[name] == pytest.approx((math.radians(angle),) * 2)


def test_response_in_several_directions(folder: Path) -> None:
    """Waves asked for, each to a direction of its own that the file has."""
    config = configured(FLAP_IN_SPACE)
    _, waves = program_in_waves(
        config, name="hydro", folder=folder, highest=1.0, progress=lambda _: None
    )
    known = waves.coefficients
    omega = known.omega[[PLACE, PLACE + 3, PLACE + 5]]
    angles, values = np.radians([30.0, 10.0, 30.0]), {"heading": math.radians(10.0)}
    found = waves.per_amplitude(omega, angles, values)[:, 1:]
    expected = np.stack([known.by_direction[PLACE + k, b] for k, b in ((0, 2), (3, 0), (5, 2))])
    assert known.directions[[0, 2]].tolist() == [0.0, 20.0]
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
    with pytest.raises(InputError, match=r"at 0, 10, 20, .* not at 25 deg"):
        waves.per_amplitude(omega[:1], np.radians([35.0]), values)


def test_drift_has_centre_and_water_of_the_file(folder: Path) -> None:
    """WAMIT's drift is over ρ g, that of the file; moments are about its centre of gravity."""
    write_mean(
        folder / "ball.8", lambda _, beta, __: 1e4 * math.cos(math.radians(beta)),
        omega=(0.2, 1.0, 2.0), directions=(0.0, 180.0), modes=(1,),
    )  # fmt: skip
    text = BALL + f"waves: {wave(7, 0)}\n"
    drift = at(program(text, folder), 50.0, "drift_force_x")["ball.drift_force_x"]
    assert drift == pytest.approx(1e4 * 1000.0 * 9.81 / (RHO * G), rel=1e-6)
