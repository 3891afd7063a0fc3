"""Keys of a `kind: hydrodynamics` component of a system file.

Lengths in m, angles in degrees where said, everything else SI. The reference pose of a body is the
one it floats in at rest: world frame, z = 0 the still-water level. Start reading in `component`.
"""

from m4e_adapters.hydrodynamics.config.component import (
    Body,
    Drag,
    Frequencies,
    HydrodynamicsConfig,
    Radiation,
    Water,
)
from m4e_adapters.hydrodynamics.config.drift import Drift
from m4e_adapters.hydrodynamics.config.shapes import (
    Box,
    Cylinder,
    Revolved,
    Shape,
    Sphere,
)
from m4e_adapters.hydrodynamics.config.waves import (
    PEAK_ENHANCEMENT,
    Jonswap,
    PiersonMoskowitz,
    Regular,
    Still,
    Waves,
)

__all__ = [
    "PEAK_ENHANCEMENT",
    "Body",
    "Box",
    "Cylinder",
    "Drag",
    "Drift",
    "Frequencies",
    "HydrodynamicsConfig",
    "Jonswap",
    "PiersonMoskowitz",
    "Radiation",
    "Regular",
    "Revolved",
    "Shape",
    "Sphere",
    "Still",
    "Water",
    "Waves",
]
