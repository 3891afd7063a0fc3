"""What the user says: bodies, joints, points, loads and parameters of a planar multibody system.

The same elements from Python (`Model(...)`) and from YAML (`load_model`). Imports `document`,
`errors`, `units` and `program`. Start with `elements`, then `checks`.
"""

from m4e_fmi.model.elements import (
    GROUND,
    Body,
    BodyForce,
    Joint,
    Parameter,
    Point,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.model import Model
from m4e_fmi.model.yaml import load_model

__all__ = [
    "GROUND",
    "Body",
    "BodyForce",
    "Joint",
    "Model",
    "Parameter",
    "Point",
    "PointForce",
    "TensionDamper",
    "TensionSpring",
    "TorsionDamper",
    "TorsionSpring",
    "load_model",
]
