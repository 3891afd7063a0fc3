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
from m4e_adapters.hydrodynamics.config.contradictions import keys_without_effect
from m4e_adapters.hydrodynamics.config.shapes import (
    Box,
    Cylinder,
    HorizontalCylinder,
    Revolved,
    Shape,
    Sphere,
    Torus,
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
    "Frequencies",
    "HorizontalCylinder",
    "HydrodynamicsConfig",
    "Jonswap",
    "PiersonMoskowitz",
    "Radiation",
    "Regular",
    "Revolved",
    "Shape",
    "Sphere",
    "Still",
    "Torus",
    "Water",
    "Waves",
    "keys_without_effect",
]
