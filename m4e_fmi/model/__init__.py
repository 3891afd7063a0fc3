"""A planar multibody system as its author gives it: bodies, joints, points, loads, parameters.

The same elements from Python (`Model(...)`), from files (`load_model`) and from the lists of the
paper (`model_from_lists`). Imports `files`, `units`, `program` and `joints`. Start with
`elements` and `loads`, then `groups` and `checks`.
"""

from m4e_fmi.model.elements import GROUND, Body, Joint, Parameter, Point
from m4e_fmi.model.load import as_model, load_model
from m4e_fmi.model.loads import (
    BodyDrag,
    BodyForce,
    Bushing,
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
from m4e_fmi.model.m4e import model_from_lists, normalize_prismatic
from m4e_fmi.model.model import Model
from m4e_fmi.model.shapes import Box, Cylinder, Mesh, Sphere
from m4e_fmi.model.table import Table

__all__ = [
    "GROUND",
    "Body",
    "BodyDrag",
    "BodyForce",
    "Box",
    "Bushing",
    "Cylinder",
    "Joint",
    "JointEffort",
    "JointFriction",
    "JointStop",
    "Mesh",
    "Model",
    "Parameter",
    "Point",
    "PointDrag",
    "PointForce",
    "Sphere",
    "Table",
    "TensionDamper",
    "TensionSpring",
    "TensionStop",
    "TorsionDamper",
    "TorsionSpring",
    "as_model",
    "load_model",
    "model_from_lists",
    "normalize_prismatic",
]
