"""Water without waves or radiation, around bodies of 100 t displacement."""

from __future__ import annotations

import numpy as np

from m4e_adapters.hydrodynamics import Coefficients

RHO, G, AREA, DISPLACED = 1000.0, 9.81, 50.0, 100e3


def calm(
    bodies: tuple[str, ...],
    area: float = AREA,
    *,
    lever: float = 0.0,
    pitch: float = 200.0,
    coupling: float = 0.0,
    places: tuple[float, ...] = (),
) -> Coefficients:
    """Bodies that do not feel each other, each with a waterplane [m2], in calm water.

    Their centres of gravity are at `places`, `lever` [m] right of the centres of buoyancy; `pitch`
    [m4] is the pitch stiffness over the weight of water, `coupling` [m3] that of heave and pitch.
    """
    n, omega = len(bodies), np.linspace(0.2, 3.0, 15)
    added = np.diag([2e4, 6e4, 3e5] * n)
    for k in range(n):
        added[3 * k + 1, 3 * k + 2] = added[3 * k + 2, 3 * k + 1] = 6e4 * lever
    return Coefficients(
        bodies=bodies,
        centers=np.array([[x, -1.0] for x in places or [0.0] * n]),
        omega=omega,
        added_mass=np.tile(added, (len(omega), 1, 1)),
        radiation_damping=np.zeros((len(omega), 3 * n, 3 * n)),
        added_mass_inf=added,
        excitation=np.zeros((len(omega), 3 * n), dtype=complex),
        hydrostatic_stiffness=RHO
        * G
        * np.kron(np.eye(n), [[0.0, 0.0, 0.0], [0.0, area, coupling], [0.0, coupling, pitch]]),
        buoyancy=DISPLACED * G * np.array([0.0, 1.0, lever] * n),
        density=RHO,
    )
