"""Loads of the pressure on whole hulls: volumes, dry and sunk hulls, incident waves."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from support.hull_pressures import RHO, G, hull_load

from m4e_adapters.hydrodynamics.pressure.config import HullPressureConfig
from m4e_adapters.hydrodynamics.pressure.hull_load import BLOCK, HullOutputs, IncidentWaves
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components, flow, wavenumber
from m4e_fmi.files.document import Document
from m4e_fmus import hull_pressure

GOOD = """\
water: {density: 1025, depth: 50}
bodies:
  float:
    shape: {cylinder: {radius: 4.0, draft: 3.0, freeboard: 2.0}}
    center_of_gravity: [0, -1.2]
waves: {spectrum: regular, height: 2.0, period: 7.0}
"""
BALL = {"shape": {"sphere": {"radius": 2.0, "center_z": 0.5}}, "center_of_gravity": [0.0, -0.5]}


def test_a_hull_out_of_the_water_has_no_load_and_one_below_it_floats_with_all_of_it() -> None:
    load = hull_load(BALL)
    above = load.at((1.0, 0.0, 9.0), (0.1, 0.2, 0.3), 0.0)
    assert not above.hydrostatic.any()
    assert above.wetted_volume == 0.0
    below = load.at((1.0, 0.0, -9.0), (0.0, 0.2, 0.0), 0.0)
    weight = RHO * G * 32 / 3 * math.pi
    assert below.hydrostatic[2] == pytest.approx(weight, rel=1e-9)
    # the centre of the ball is 1 m above that of gravity; of the panels to 2e-3
    assert below.hydrostatic[4] == pytest.approx(-weight * math.sin(0.2), rel=5e-3)


@pytest.mark.filterwarnings("error")
def test_outputs_of_the_fmu_and_what_is_told(tmp_path: Path) -> None:
    text = GOOD.replace("depth: 50", "depth: 5") + "dimensions: 2\n"
    source = hull_pressure.KIND.build(
        Document.parse(text).validate(HullPressureConfig),
        name="hull",
        folder=tmp_path,
        progress=lambda _: None,
    )
    outputs = HullOutputs(json.loads(source.data["hulls.json"]))
    pose = {"float.x": 0.0, "float.z": -1.2, "float.theta": 0.0}
    found = outputs.at(pose, 30.0)
    named = [v for v in source.description.variables if v.causality != "input"]
    assert sorted(found) == sorted(v.name for v in named)
    for force in ("force_x", "force_z", "moment_y"):
        whole = found[f"float.hydrostatic_{force}"] + found[f"float.froude_krylov_{force}"]
        assert found[f"float.{force}"] == whole
    assert found["float.neutral_mass"] == pytest.approx(1025 * 48 * math.pi, rel=1e-9)
    assert [*outputs.doubts(30.0)] == []
    assert outputs.at({**pose, "float.z": 9.0}, 31.0)["float.force_z"] == 0.0
    (dry,) = outputs.doubts(31.0)
    assert dry == "float is wholly out of the water (t = 31 s): no force on it"
    outputs.at({**pose, "float.z": -4.0}, 32.0)
    (aground,) = outputs.doubts(32.0)
    assert "float reaches down to z = -5.8 m (t = 32 s), below the sea bed at z = -5 m" in aground
    assert [*outputs.doubts(33.0)] == []
    deep, abyss = (outputs.at({**pose, "float.z": z}, 33.0) for z in (-9.0, -1e6))
    for name in ("float.hydrostatic_force_z", "float.wetted_volume"):
        assert abyss[name] == pytest.approx(deep[name], rel=1e-8)
    with pytest.raises(ValueError, match="no finite pressure"):
        outputs.at({**pose, "float.z": math.nan}, 34.0)


@pytest.mark.parametrize("depth", [20.0, math.inf])
def test_heads_of_many_points_are_those_of_the_kinematics(depth: float) -> None:
    """Points in several blocks, of many components, with Wheeler's stretching."""
    rng, count = np.random.default_rng(3), 200
    omega, amplitude = np.linspace(0.4, 3.0, count), rng.uniform(0.0, 0.05, count)
    phase, direction = rng.uniform(0.0, 6.0, (2, count))
    data = {
        "omega": omega, "wavenumber": wavenumber(omega, depth=depth, gravity=9.81),
        "amplitude": amplitude, "phase": phase, "direction": direction,
        "ramp_time": np.zeros(count),
    }  # fmt: skip
    waves = IncidentWaves({k: v.tolist() for k, v in data.items()} | {"depth": depth})
    points = rng.uniform((-30, -30, -10), (30, 30, 1), (BLOCK // count * 2 + 7, 3))
    head, level = waves.head(points, 77.7)
    known = Components(omega, amplitude, phase, direction, depth=depth)
    water = flow(known, 77.7, points, stretching="wheeler")
    assert level == pytest.approx(water.elevation, abs=1e-12)
    wet = points[:, 2] < level
    assert head[wet] == pytest.approx((water.head - points[:, 2])[wet], abs=1e-12)
    assert head[~wet] == pytest.approx((level - points[:, 2])[~wet], abs=1e-12)
