"""Mean drift in the far field against closed forms and the balance of momentum and energy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.cylinder_drift import cylinder_drift, standing_cylinder
from support.drifting import series
from support.floating_hemisphere import RHO, G, free_motions, hemisphere
from support.momentum import momentum_through_cylinder

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, program_from_config
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.drift.far_field import far_field_drift, write_csv
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency


@pytest.mark.verifies(
    "mean drift of a cylinder on the bottom, ka 0.3 to 1.5, kh 0.6 to 3",
    analytic="MacCamy and Fuchs; pressure on the hull",
    tolerance="0.01",
)
def test_a_standing_cylinder() -> None:
    """The error falls with the size of the 280 panels: 0.7 % at most here, 0.4 % with 560."""
    numbers = np.array([0.3, 0.6, 1.0, 1.5])
    hull = standing_cylinder(radius=1.0, depth=2.0, around=28, down=10)
    water = Water(density=RHO, depth=2.0, gravity=G)
    omega = angular_frequency(numbers, depth=2.0, gravity=G)
    found = far_field_drift(
        hull, water=water, omega=omega.tolist(), directions=[0.0, 30.0], progress=lambda _: None
    )
    expected = [cylinder_drift(k, radius=1.0, depth=2.0, density=RHO, g=G) for k in numbers]
    surge, sway, yaw = np.moveaxis(found.values, 2, 0)
    assert surge[:, 0] == pytest.approx(expected, rel=0.01)
    assert surge[:, 1] == pytest.approx(surge[:, 0] * math.cos(math.radians(30.0)), rel=1e-3)
    assert sway[:, 1] == pytest.approx(surge[:, 0] * math.sin(math.radians(30.0)), rel=1e-3)
    assert np.abs(yaw).max() < 1e-6 * surge.max()


@pytest.mark.verifies(
    "mean drift of a floating hemisphere, free in surge and heave, ka 0.8 and 1",
    analytic="balance of momentum on a cylinder of twice its radius",
    tolerance="0.03",
)
def test_a_free_hemisphere() -> None:
    """The balance has potentials and velocities in the water, by sources on the hull, whose error
    falls with the first power of the panels' size: 0.6 and 1.7 % here, 0.4 and 1.1 % with 600."""
    hull, config = hemisphere(panels=300)
    numbers = np.array([0.8, 1.0])
    omega = np.sqrt(G * numbers)
    motions = free_motions(hull, config, omega)
    found = far_field_drift(
        hull,
        water=config.water,
        omega=omega.tolist(),
        directions=[0.0],
        motions=motions,
        progress=lambda _: None,
    )
    expected = [
        momentum_through_cylinder(hull, k, motion[0], radius=2.0, density=RHO, g=G)
        for k, motion in zip(numbers.tolist(), motions, strict=True)
    ]
    assert found.values[:, 0, 0] == pytest.approx(expected, rel=0.03)


def test_from_a_hull_to_its_force(tmp_path: Path) -> None:
    """Mean drift computed, written, and read by the component: a² D of the held hull."""
    hull, config = hemisphere(panels=300)
    omega = [2.0, 2.5, 3.0, 3.5]
    table = far_field_drift(
        hull, water=config.water, omega=omega, directions=[0.0], progress=lambda _: None
    )
    write_csv(table, tmp_path / "ball.csv")
    wave = {"spectrum": "regular", "height": 0.2, "period": 2.0 * math.pi / 2.5, "ramp_time": 0}
    data = config.model_dump(exclude_unset=True)
    data["waves"], data["frequencies"] = wave, {"count": 12}
    data["bodies"]["ball"]["drift"] = {"file": "ball.csv"}
    program = program_from_config(
        HydrodynamicsConfig.model_validate(data),
        name="water",
        folder=tmp_path,
        progress=lambda _: None,
    )
    found = series(program, np.linspace(0.0, 5.0, 11))
    expected = 0.1**2 * table.values[1, 0, 0]
    assert found["ball.drift_force_x"] == pytest.approx(expected, rel=1e-6)
    total = found["ball.excitation_force_x"] + found["ball.drift_force_x"]
    assert found["ball.force_x"] == pytest.approx(total)
