"""Models in YAML files (``*.model.yaml``)."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictFloat

from m4e_fmi.document import Document, Section, rejected
from m4e_fmi.errors import InputError
from m4e_fmi.model.checks import Names, element_findings, whole_findings
from m4e_fmi.model.elements import (
    GROUND,
    LOAD_TYPES,
    AngleReference,
    Body,
    Joint,
    JointType,
    Parameter,
    Point,
)
from m4e_fmi.model.model import STANDARD_GRAVITY, Model


def _number_or_text(value: Any) -> float | str:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise rejected(f"expected a number or an expression, got {value!r}")
    return value


Quantity = Annotated[float | str, BeforeValidator(_number_or_text)]
Vector = tuple[Quantity, Quantity]


class ParameterSection(Section):
    value: StrictFloat
    unit: str
    description: str = ""


class BodySection(Section):
    mass: Quantity
    inertia: Quantity
    description: str = ""
    added_mass: bool = False


class JointSection(Section):
    type: JointType
    child: str
    parent: str = GROUND
    parent_to_joint: Vector = (0.0, 0.0)
    joint_to_child: Vector = (0.0, 0.0)
    direction: Vector | None = None
    coordinate: AngleReference = "absolute"
    initial: dict[str, Quantity] = Field(default_factory=dict)


class PointSection(Section):
    body: str
    at: Vector
    description: str = ""


class TensionSpringSection(Section):
    type: Literal["tension_spring"]
    points: tuple[str, str]
    stiffness: Quantity
    length: Quantity


class TensionDamperSection(Section):
    type: Literal["tension_damper"]
    points: tuple[str, str]
    damping: Quantity


class TorsionSpringSection(Section):
    type: Literal["torsion_spring"]
    bodies: tuple[str, str]
    stiffness: Quantity
    angle: Quantity = 0.0


class TorsionDamperSection(Section):
    type: Literal["torsion_damper"]
    bodies: tuple[str, str]
    damping: Quantity


class PointForceSection(Section):
    type: Literal["point_force"]
    point: str
    force: Vector


class BodyForceSection(Section):
    type: Literal["body_force"]
    body: str
    force: Vector = (0.0, 0.0)
    moment: Quantity = 0.0


LoadSection = Annotated[
    TensionSpringSection
    | TensionDamperSection
    | TorsionSpringSection
    | TorsionDamperSection
    | PointForceSection
    | BodyForceSection,
    Field(discriminator="type"),
]


class ModelSection(Section):
    """The whole file."""

    name: str
    description: str = ""
    gravity: Quantity = STANDARD_GRAVITY
    parameters: dict[str, ParameterSection] = Field(default_factory=dict)
    bodies: dict[str, BodySection] = Field(default_factory=dict)
    joints: dict[str, JointSection] = Field(default_factory=dict)
    points: dict[str, PointSection] = Field(default_factory=dict)
    loads: dict[str, LoadSection] = Field(default_factory=dict)


def load_model(path: str | Path) -> Model:
    """The model in the YAML file `path`; InputError with every problem of the file."""
    return model_of(Document.load(path))


def model_of(document: Document) -> Model:
    """The model in `document`; InputError with every problem found, placed in the file."""
    section, problems = document.validate_as_far_as_possible(
        ModelSection, required={"name": "unnamed"}
    )
    names = Names.of(document.data)
    if section is not None:
        groups = _elements(section)
        namespace = SimpleNamespace(gravity=section.gravity, **groups)
        found = list(element_findings(namespace, names))
        if not found and not problems:
            found = list(whole_findings(namespace))
        if not found and not problems:
            return Model(
                name=section.name,
                description=section.description,
                gravity=section.gravity,
                **groups,
            )
        problems += [document.problem(f.location, f.message, f.remedy) for f in found]
    raise InputError(problems)


def _elements(section: ModelSection) -> dict[str, Any]:
    def made(kind: Any, members: dict[str, Any]) -> dict[str, Any]:
        return {name: kind(**dict(member)) for name, member in members.items()}

    loads = {}
    for name, member in section.loads.items():
        fields = dict(member)
        loads[name] = LOAD_TYPES[fields.pop("type")](**fields)
    return {
        "parameters": made(Parameter, section.parameters),
        "bodies": made(Body, section.bodies),
        "joints": made(Joint, section.joints),
        "points": made(Point, section.points),
        "loads": loads,
    }
