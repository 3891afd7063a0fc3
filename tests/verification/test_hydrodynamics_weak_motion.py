"""A motion that hardly radiates does not spoil the memory of a strong one that it is coupled to."""

from __future__ import annotations

import numpy as np
import pytest
from support.published_coefficients import DATA, transfer

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation

HEAVES = (1, 4)
MASS_INF = np.array([[71086.62843, -1560.58462], [-1564.12726, 351447.64327]])


def float_and_spar() -> Coefficients:
    """A float that slides on a spar, by Capytaine with 200 and 720 panels, heave only.

    The largest damping of the spar is 839 N.s/m for the float's 42,700; its added mass is noisy by
    0.05 %, which is much more than its memory.
    """
    table = np.loadtxt(DATA / "float_and_spar_heave.csv", delimiter=",")
    count = len(table)
    mass, damping = np.zeros((2, count, 6, 6))
    mass[np.ix_(range(count), HEAVES, HEAVES)] = table[:, 1:5].reshape(-1, 2, 2)
    damping[np.ix_(range(count), HEAVES, HEAVES)] = table[:, 5:].reshape(-1, 2, 2)
    mass_inf, stiffness = np.zeros((2, 6, 6))
    mass_inf[np.ix_(HEAVES, HEAVES)] = MASS_INF
    stiffness[HEAVES, HEAVES] = 4.344e5, 7.108e4
    return Coefficients(
        bodies=("float", "spar"),
        centers=np.array([[0.0, -0.6], [0.0, -14.0]]),
        omega=table[:, 0],
        added_mass=mass,
        radiation_damping=damping,
        added_mass_inf=mass_inf,
        excitation=np.zeros((count, 6), dtype=complex),
        hydrostatic_stiffness=stiffness,
        buoyancy=1025 * 9.81 * np.array([0.0, 90.4779, 0.0, 0.0, 172.788, 0.0]),
        depth=60.0,
        resolved=(3.818, 3.415),
    )


@pytest.mark.verifies(
    "radiation memory of a float beside a spar that hardly radiates: damping of the float up to "
    "3 rad/s, over its largest",
    independent="Capytaine's coefficients",
    tolerance="1 %",
)
def test_a_weak_motion_does_not_spoil_a_strong_one() -> None:
    data = float_and_spar()
    told: list[str] = []
    memory = fit_radiation(data, progress=told.append)
    assert [group.motions for group in memory.groups] == [HEAVES]
    found = np.real(transfer(memory, data.omega))
    own = data.radiation_damping.diagonal(axis1=1, axis2=2)
    errors = np.abs(found.diagonal(axis1=1, axis2=2) - own).max(axis=0)
    assert errors[1] < 0.01 * own[:, 1].max()
    assert not [text for text in told if "beyond, it follows" in text]
