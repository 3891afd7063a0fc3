"""Keys of a `kind: hydrodynamics` component of a system file.

Lengths in m, angles in degrees where said, everything else SI. The reference pose of a body is the
one it floats in at rest: world frame, z = 0 the still-water level. Start reading in `component`.
"""

from m4e_adapters.hydrodynamics.config.component import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.config.sections import (
    Body,
    Drag,
    Drift,
    Frequencies,
    Loads,
    Radiation,
    Water,
)
from m4e_adapters.hydrodynamics.config.shapes import (
    Box,
    Cylinder,
    HorizontalCylinder,
    Revolved,
    Shape,
    Sphere,
)
from m4e_adapters.hydrodynamics.config.waves import (
    PEAK_ENHANCEMENT,
    AnyWaves,
    Component,
    ComponentWaves,
    Current,
    Jonswap,
    PiersonMoskowitz,
    Record,
    Regular,
    SpectrumTable,
    Spreading,
    Still,
    Waves,
    WaveSection,
    current_problems,
    wave_sections,
)

__all__ = [
    "PEAK_ENHANCEMENT",
    "AnyWaves",
    "Body",
    "Box",
    "Component",
    "ComponentWaves",
    "Current",
    "Cylinder",
    "Drag",
    "Drift",
    "Frequencies",
    "HorizontalCylinder",
    "HydrodynamicsConfig",
    "Jonswap",
    "Loads",
    "PiersonMoskowitz",
    "Radiation",
    "Record",
    "Regular",
    "Revolved",
    "Shape",
    "SpectrumTable",
    "Sphere",
    "Spreading",
    "Still",
    "Water",
    "WaveSection",
    "Waves",
    "current_problems",
    "wave_sections",
]
