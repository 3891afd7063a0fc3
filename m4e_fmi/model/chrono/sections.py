"""The form of Chrono's model and simulation files; what has no counterpart here is refused.

Source: data/yaml/schema/mbs_model.schema.yaml and src/chrono_parsers/yaml of Project Chrono 9–10.
Words of enumerations may be in any case, as there.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, field_validator

from m4e_fmi.files.document import Section, rejected

Number = Annotated[float, Field(allow_inf_nan=False)]
Vector3 = tuple[Number, Number, Number]
Ignored = object
JointWord = Literal["REVOLUTE", "PRISMATIC", "SPHERICAL", "UNIVERSAL", "LOCK"]
UPPER = BeforeValidator(lambda value: value.upper() if isinstance(value, str) else value)


def _orientation(value: list[float]) -> list[float]:
    if len(value) not in (3, 4):
        message = f"expected three angles or a quaternion, got {len(value)} entries"
        raise rejected(message, "write [yaw, pitch, roll] or [e0, e1, e2, e3]")
    if len(value) == 4 and not any(value):
        message = "a quaternion of length zero is not an orientation"
        raise rejected(message, "no turn is [1, 0, 0, 0]")
    return value


def _direction(value: tuple[float, ...]) -> tuple[float, ...]:
    if not any(value):
        raise rejected("the axis has no length", "give a vector")
    return value


Orientation = Annotated[list[Number], AfterValidator(_orientation)]
Direction = Annotated[Vector3, AfterValidator(_direction)]


def _refused(message: str, remedy: str) -> BeforeValidator:
    """Refuses a key of Chrono's that has no counterpart here."""

    def refuse(value: object) -> None:
        if value not in (None, []):
            raise rejected(message, remedy)

    return BeforeValidator(refuse)


Curve = Annotated[
    object,
    _refused(
        "nonlinear curves are not read from Chrono's files",
        "write the load with a 'law' in a model file, or give a coefficient here",
    ),
]
Limit = Annotated[
    object,
    _refused(
        "Chrono's bump stops have a curve of their own, which is not read",
        "remove the limits, or write a tension_stop in a model file",
    ),
]
Contact = Annotated[
    object,
    _refused(
        "contact between bodies cannot be represented",
        "remove it, or put stops (tension_stop, joint_stop) into a model file",
    ),
]
BushingData = Annotated[
    object,
    _refused(
        "bushings cannot be represented", "remove it, or write springs and dampers (tsdas, rsdas)"
    ),
]
Constraints = Annotated[
    object,
    _refused(
        "constraints close loops, which cannot be represented",
        "cut the loop: remove them, or put stiff springs and dampers in their place",
    ),
]
Controllers = Annotated[
    object,
    _refused(
        "loads of a controller come from outside",
        "remove them, and connect the controller to the FMU's inputs body.<name>.force_x, …",
    ),
]
Repeated = Annotated[
    object,
    _refused("repeated functions are not read", "write the periods out, as a table (type: DATA)"),
]


class InertiaSection(Section):
    """Moments and products of inertia [kg·m²] about the centre of mass."""

    moments: tuple[Number, Number, Number]
    products: Vector3 = (0.0, 0.0, 0.0)


class ComSection(Section):
    """Place [m] and axes of the centre of mass in the body's frame."""

    location: Vector3 = (0.0, 0.0, 0.0)
    orientation: Orientation = Field(default=[1.0, 0.0, 0.0, 0.0])


class BodySection(Section):
    """A body: its frame, mass [kg] and velocities at the start."""

    name: str
    location: Vector3
    orientation: Orientation = Field(default=[1.0, 0.0, 0.0, 0.0])
    fixed: bool = False
    mass: Number | None = None
    com: ComSection = ComSection()
    inertia: InertiaSection | None = None
    initial_linear_velocity: Vector3 | None = None
    initial_angular_velocity: Vector3 | None = None
    visualization: Ignored = None
    contact: Contact = None

    @field_validator("com", mode="before")
    @classmethod
    def _short_form(cls, value: object) -> object:
        return {"location": value} if isinstance(value, list) else value


class JointSection(Section):
    """A joint of two bodies; `axis` is its direction in world axes.

    A universal joint has axis1, fixed in body1, and axis2, fixed in body2.
    """

    name: str
    type: Annotated[JointWord, UPPER]
    body1: str
    body2: str
    location: Vector3
    axis: Direction | None = None
    axis1: Direction | None = None
    axis2: Direction | None = None
    bushing_data: BushingData = None


class TsdaSection(Section):
    """A translational spring-damper between two points [N/m, N·s/m, m, N]."""

    name: str
    type: Ignored = None
    body1: str
    body2: str
    point1: Vector3
    point2: Vector3
    spring_coefficient: Number | None = None
    damping_coefficient: Number | None = None
    free_length: Number | None = None
    preload: Number = 0.0
    visualization: Ignored = None
    spring_curve_data: Curve = None
    damping_curve_data: Curve = None
    deformation: Curve = None
    map_data: Curve = None
    degressivity_compression: Curve = None
    degressivity_expansion: Curve = None
    minimum_length: Limit = None
    maximum_length: Limit = None


class RsdaSection(Section):
    """A rotational spring-damper between two bodies [N·m/rad, N·m·s/rad, N·m]."""

    name: str
    type: Ignored = None
    body1: str
    body2: str
    axis: Direction
    location: Vector3 | None = None
    spring_coefficient: Number | None = None
    damping_coefficient: Number | None = None
    free_angle: Number | None = None
    preload: Number = 0.0
    visualization: Ignored = None
    spring_curve_data: Curve = None
    damping_curve_data: Curve = None


class FunctionSection(Section):
    """A function of time: the fields of all its types."""

    type: Annotated[
        Literal["CONSTANT", "POLYNOMIAL", "POLY", "SINE", "RAMP", "DATA", "CONTROLLER"], UPPER
    ]
    value: Number | None = None
    coefficients: list[Number] | None = None
    amplitude: Number | None = None
    frequency: Number | None = None
    phase: Number = 0.0
    slope: Number | None = None
    intercept: Number = 0.0
    data: list[tuple[Number, Number]] | None = None
    repeat: Repeated = None


class MotorSection(Section):
    """A motor between two bodies, which exerts a force or torque over time."""

    name: str
    type: Annotated[Literal["LINEAR", "ROTATION"], UPPER]
    body1: str
    body2: str
    location: Vector3
    axis: Direction
    actuation_type: Annotated[Literal["FORCE"], UPPER]
    actuation_function: FunctionSection
    guide: Annotated[Literal["FREE", "PRISMATIC"], UPPER] = "PRISMATIC"
    spindle: Annotated[Literal["FREE", "REVOLUTE", "CYLINDRICAL"], UPPER] = "REVOLUTE"
    visualization: Ignored = None


class BodyLoadSection(Section):
    """A constant force [N] or torque [N·m] on a body, modulated over time if asked for."""

    name: str
    type: Annotated[Literal["FORCE", "TORQUE"], UPPER]
    body: str
    load: Vector3
    local_load: bool = True
    point: Vector3 = (0.0, 0.0, 0.0)
    local_point: bool = True
    modulation_function: FunctionSection | None = None


class ModelSection(Section):
    """All groups of a model; angles are in degrees unless `angle_degrees` is false."""

    name: str = "chrono"
    angle_degrees: bool = True
    data_path: Ignored = None
    bodies: list[BodySection]
    joints: list[JointSection] = Field(default_factory=list)
    tsdas: list[TsdaSection] = Field(default_factory=list)
    rsdas: list[RsdaSection] = Field(default_factory=list)
    motors: list[MotorSection] = Field(default_factory=list)
    body_loads: list[BodyLoadSection] = Field(default_factory=list)
    constraints: Constraints = None
    load_controllers: Controllers = None


class ChronoSimulationSection(Section):
    """The part of a simulation that belongs to the model; the rest is for Chrono's solver."""

    model_config = ConfigDict(extra="ignore", frozen=True)

    gravity: Vector3 | None = None


class FileSection(Section):
    """A file of a simulation; `model` is the name of its model's file."""

    chrono_version: Ignored = Field(None, alias="chrono-version")
    type: Ignored = None
    model: str | None = None
    simulation: ChronoSimulationSection = ChronoSimulationSection()
    solver: Ignored = None
    output: Ignored = None
    visualization: Ignored = None


class ModelFileSection(FileSection):
    """A file of a model, perhaps with its simulation."""

    model: ModelSection  # pyrefly: ignore[bad-override]
