"""Write flaps.nc, a dataset in Capytaine's layout, from the shapes in shapes.yaml: some minutes.

The potential flow is that of `kind: hydrodynamics`, for seven directions of the waves.
"""

from pathlib import Path

import numpy as np
import xarray

from m4e_adapters.hydrodynamics import (
    Coefficients,
    HydrodynamicsConfig,
    coefficients_from_config,
)
from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.system.component import Kind

FOLDER = Path(__file__).parent
DIRECTIONS = np.arange(0.0, 91.0, 15.0)  # deg
MOTIONS = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")


def of_shapes() -> Coefficients:
    """The coefficients of both flaps beside the base, in space."""
    sources = [component.source for component in load_system(FOLDER / "shapes.yaml").components]
    (config,) = (source.config for source in sources if isinstance(source, Kind))
    assert isinstance(config, HydrodynamicsConfig)
    return coefficients_from_config(config, folder=FOLDER)


def excitation(found: Coefficients, direction: float) -> np.ndarray:
    """Force (nω, 12) [N/m, N.m/m], complex, of waves that travel to `direction` [deg]."""
    most = found.harmonics.shape[1] // 2
    turns = np.exp(1j * np.arange(-most, most + 1) * np.radians(direction))
    return np.einsum("wjn,j->wn", found.harmonics, turns) * found.way(found.omega, direction)


def dataset(found: Coefficients) -> xarray.Dataset:
    """The same as Capytaine writes them, the row at infinite frequency last."""
    dofs = [f"{body}__{motion}" for body in found.bodies for motion in MOTIONS]
    pairs = ("omega", "radiating_dof", "influenced_dof")
    inf = found.added_mass_inf[None]
    force = np.stack([excitation(found, direction) for direction in DIRECTIONS], axis=1)
    force = np.concatenate([force, np.zeros((1, *force.shape[1:]))])
    lift = found.buoyancy.reshape(len(found.bodies), len(MOTIONS))[:, 2]
    values = {
        "added_mass": (pairs, np.concatenate([found.added_mass, inf]).swapaxes(1, 2)),
        "radiation_damping": (
            pairs,
            np.concatenate([found.radiation_damping, 0 * inf]).swapaxes(1, 2),
        ),
        "excitation_force": (
            ("complex", "omega", "wave_direction", "influenced_dof"),
            np.stack([force.real, force.imag]),
        ),
        "hydrostatic_stiffness": (
            ("influenced_dof", "radiating_dof"),
            found.hydrostatic_stiffness,
        ),
        "center_of_mass": (("body", "xyz"), found.centers),
        "rotation_center": (("body", "xyz"), found.centers),
        "disp_mass": (("body",), lift / found.gravity),
        "rho": ((), found.density),
        "g": ((), found.gravity),
        "water_depth": ((), found.depth),
    }
    places = {
        "omega": [*found.omega, np.inf],
        "radiating_dof": dofs,
        "influenced_dof": dofs,
        "wave_direction": np.radians(DIRECTIONS),
        "complex": ["re", "im"],
    }
    return xarray.Dataset(values, coords=places)


if __name__ == "__main__":
    found = dataset(of_shapes())
    large = ("added_mass", "radiation_damping", "excitation_force")
    packed = {name: {"zlib": True, "dtype": "float32", "shuffle": True} for name in large}
    found.to_netcdf(FOLDER / "flaps.nc", encoding=packed)
