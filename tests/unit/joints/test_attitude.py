"""Roll, pitch and yaw of rotations, and the rotations of these."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

from m4e_fmi.joints import attitude, quaternion_of
from m4e_fmi.space import Rotation

RIGHT = math.pi / 2


@pytest.mark.parametrize("pitch", [0.0, 1.2, -1.5, RIGHT, -RIGHT, RIGHT - 1e-9, 1e-7 - RIGHT])
def test_angles_are_those_of_the_rotation(pitch: float) -> None:
    """Also at a pitch of a right angle, where yaw is any."""
    random = np.random.default_rng(4)
    for roll, yaw in random.uniform(-3, 3, (50, 2)):
        rotation = Rotation.of_quaternion(quaternion_of(roll, pitch, yaw))
        rows = np.array(rotation.rows, float)
        phi, theta, psi = attitude(rotation)
        again = Turn.from_euler("ZYX", [psi, theta, phi]).as_matrix()
        assert np.abs(again - rows).max() < 3e-15
        direct = Turn.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
        assert np.abs(rows - direct).max() < 3e-15
        if abs(pitch) < RIGHT - 1e-3:
            assert [phi, theta, psi] == pytest.approx([roll, pitch, yaw], abs=1e-13)
