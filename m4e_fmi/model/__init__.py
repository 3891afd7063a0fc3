"""What the user says: bodies, joints, points, loads and parameters of a planar multibody system.

The same elements from Python (`Model(...)`), from files (`load_model`) and from the lists of the
paper (`model_from_lists`). Imports `document`, `errors`, `units` and `program`. Start with
`elements`, then `checks`.
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
from m4e_fmi.model.load import load_model
from m4e_fmi.model.m4e import model_from_lists, normalize_prismatic
from m4e_fmi.model.model import Model

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
    "model_from_lists",
    "normalize_prismatic",
]
