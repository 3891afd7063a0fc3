"""Switches of the parts of the linear load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.hulls import configured, silent
from support.programs import Evaluated

from m4e_adapters.hydrodynamics import (
    coefficients_from_config,
)
from m4e_adapters.hydrodynamics.build import program_from_config
from m4e_fmi.program import Program

GOOD = """\
bodies:
  hull:
    shape: {box: {length: 8, width: 5, draft: 2, center_x: 1}}
    center_of_gravity: [1.2, -0.5]
    panels: 90
    drag: {heave: 1000}
frequencies: {count: 16}
waves: {spectrum: regular, height: 1, period: 6, direction: 180, ramp_time: 0}
"""
PARTS = ("hydrostatic", "radiation", "excitation", "drag")
INPUTS = {"hull.z": -0.3, "hull.phi": 0.05, "hull.vz": 0.4, "hull.x": 1.2}


def made(text: str) -> Program:
    return program_from_config(configured(text), name="water", folder=Path(), progress=silent)


def outputs(program: Program) -> dict[str, float]:
    states = {v.name: 0.1 for v in program.states}
    known = {v.name for v in program.inputs}
    inputs = {name: value for name, value in INPUTS.items() if name in known}
    return Evaluated(program).outputs({**states, **inputs}, t=1.7)


def wrench(values: dict[str, float], part: str = "") -> np.ndarray:
    """(6,) [N, N.m]; zero of a part that is not there."""
    prefix = f"{part}_" if part else ""
    names = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
    return np.array([values.get(f"hull.{prefix}{name}", 0.0) for name in names])


@pytest.fixture(scope="module")
def whole() -> dict[str, float]:
    return outputs(made(GOOD))


def test_all_parts_are_outputs_and_add_up(whole: dict[str, float]) -> None:
    parts = [wrench(whole, part) for part in PARTS]
    assert all(np.abs(part).max() > 1.0 for part in parts)
    np.testing.assert_allclose(sum(parts), wrench(whole), rtol=1e-12)


def test_parts_that_are_switched_off_are_not_there(whole: dict[str, float]) -> None:
    text = GOOD.replace("    drag: {heave: 1000}\n", "")
    program = made(text + "loads: {hydrostatics: none, radiation: none, drag: none}\n")
    left = outputs(program)
    np.testing.assert_allclose(wrench(left), wrench(whole, "excitation"), rtol=1e-9, atol=1e-6)
    assert not [key for key in left for part in ("hydrostatic", "radiation", "drag") if part in key]
    assert not program.calculated
    assert not program.states


@pytest.mark.parametrize("dimensions", [2, 3])
def test_froude_krylov_and_diffraction_are_the_excitation(dimensions: int) -> None:
    text = GOOD
    if dimensions == 3:
        text = "dimensions: 3\n" + GOOD.replace("direction: 180", "direction: 30")
        text = text.replace("[1.2, -0.5]", "[1.2, 0, -0.5]")
    text += "loads: {radiation: none%s}\n"
    whole, krylov, scattered, neither = (
        outputs(made(text % switched))
        for switched in (
            "",
            ", diffraction: none",
            ", froude_krylov: none",
            ", froude_krylov: none, diffraction: none",
        )
    )
    one, other = wrench(krylov, "froude_krylov"), wrench(scattered, "diffraction")
    excitation = wrench(whole, "excitation")
    assert min(np.linalg.norm(one), np.linalg.norm(other)) > 0.05 * np.linalg.norm(excitation)
    scale = np.abs(excitation).max()
    # in space, harmonics below 1e-7 of the largest are left out of each
    np.testing.assert_allclose(one + other, excitation, atol=1e-6 * scale)
    np.testing.assert_allclose(wrench(neither), wrench(whole) - excitation, atol=1e-10 * scale)
    assert neither["wave.elevation"] == whole["wave.elevation"] != 0.0


def test_long_waves_lift_by_froude_krylov_and_are_not_diffracted() -> None:
    """At ω = 0 the water just rises: X = K of heave, all of it Froude-Krylov's part."""
    for part, other in (("froude_krylov", "diffraction"), ("diffraction", "froude_krylov")):
        text = GOOD + f"loads: {{{other}: none}}\n"
        found = coefficients_from_config(configured(text), folder=Path(), progress=silent)
        assert found.excited_by == (part,)
        lift = found.excitation_at(np.array([1e-4]))[0, 1]
        stiffness = found.hydrostatic_stiffness[1, 1] if part == "froude_krylov" else 0.0
        assert lift == pytest.approx(stiffness, abs=1e-3 * found.hydrostatic_stiffness[1, 1])
