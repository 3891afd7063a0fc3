"""What the user says: bodies, joints, points, loads and parameters of a planar multibody system.

The same elements from Python (`Model(...)`) and from YAML (`load_model`). Imports `document`,
`errors`, `units` and `program`. Start with `elements` and `loads`, then `checks`.
"""

from m4e_fmi.model.elements import GROUND, Body, Joint, Parameter, Point
from m4e_fmi.model.loads import (
    BodyDrag,
    BodyForce,
    JointEffort,
    JointFriction,
    JointStop,
    PointDrag,
    PointForce,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.model import Model
from m4e_fmi.model.table import Table
from m4e_fmi.model.yaml import load_model

__all__ = [
    "GROUND",
    "Body",
    "BodyDrag",
    "BodyForce",
    "Joint",
    "JointEffort",
    "JointFriction",
    "JointStop",
    "Model",
    "Parameter",
    "Point",
    "PointDrag",
    "PointForce",
    "Table",
    "TensionDamper",
    "TensionSpring",
    "TensionStop",
    "TorsionDamper",
    "TorsionSpring",
    "load_model",
]
