"""Models in YAML files (``*.model.yaml``)."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    StrictFloat,
    Tag,
    ValidationInfo,
    create_model,
)

from m4e_fmi.errors import InputError, Problem
from m4e_fmi.files.csv_columns import heading, read_columns
from m4e_fmi.files.document import Document, Location, Section, rejected
from m4e_fmi.model.checks import group_findings
from m4e_fmi.model.elements import (
    AngleReference,
    Axes,
    Body,
    Joint,
    Parameter,
    Point,
)
from m4e_fmi.model.findings import ModelFinding, Names
from m4e_fmi.model.groups import STANDARD_GRAVITY, Groups
from m4e_fmi.model.loads import LOAD_TYPES, Load
from m4e_fmi.model.model import Model
from m4e_fmi.model.shapes import Box, Cylinder, Mesh, Shape, Sphere
from m4e_fmi.model.table import Table

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

SHAPES = {"box": Box, "cylinder": Cylinder, "sphere": Sphere}


def _number_or_text(value: object) -> float | str:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        got = "nothing" if value is None else repr(value)
        remedy = "give one number" if isinstance(value, list) else ""
        if isinstance(value, dict):
            remedy = "give its unit to a parameter under 'parameters', and its name here"
        raise rejected(f"expected a number or an expression, got {got}", remedy)
    return value


def _vector(value: object, info: ValidationInfo) -> object:
    """A vector as it is, whose length is checked later; anything else is rejected."""
    if not isinstance(value, (list, tuple)):
        raise rejected(
            f"{info.field_name}: expected a vector, got {value!r}",
            "write [x, z], in space [x, y, z]",
        )
    return value


def _unit(value: object) -> str:
    """A unit as it is; the number 1 is the text."""
    if isinstance(value, str):
        return value
    if not isinstance(value, bool) and value == 1:
        return "1"
    raise rejected(f"unit: expected a unit, got {value!r}", "write one like N/m, or 1 for none")


Quantity = Annotated[float | str, BeforeValidator(_number_or_text)]
Vector = Annotated[tuple[Quantity, ...], BeforeValidator(_vector)]
Numbers = Annotated[
    Annotated[Quantity, Tag("number")] | Annotated[tuple[Quantity, ...], Tag("list")],
    Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "number"),
]
UnitText = Annotated[str, BeforeValidator(_unit)]


_FIELD_TYPES: dict[str, object] = {
    "Quantity": Quantity,
    "Quantity | None": Quantity | None,
    "QuantityOrVector": Numbers,
    "Inertia": Numbers,
    "Vector": Vector,
    "Vector | None": Vector | None,
    "AngleReference | None": AngleReference | None,
    "Axes": Axes,
    "dict[str, Quantity]": dict[str, Quantity],
    "bool": bool,
    "str": str,
    "tuple[str, str]": tuple[str, str],
}


def _section(kind: type[DataclassInstance], **given: Any) -> type[Section]:
    """The section of a file that gives the fields of an element, and those `given`."""
    for field in fields(kind):
        default = ... if field.default is MISSING else field.default
        if field.default_factory is not MISSING:
            default = Field(default_factory=field.default_factory)
        if field.name not in given:
            given[field.name] = (_FIELD_TYPES[str(field.type)], default)
    return create_model(f"{kind.__name__}Section", __base__=Section, **given)


class ParameterSection(Section):
    """A parameter: value with unit."""

    value: StrictFloat
    unit: UnitText
    description: str = ""
    tunable: bool = False


def _one_shape(value: object) -> object:
    """The section of a shape as it is, unless it has no shape, or more than one."""
    if not isinstance(value, dict):
        return value
    given = [key for key in (*SHAPES, "mesh") if value.get(key) is not None]
    if len(given) != 1:
        raise rejected(
            f"a body has one shape, got {' and '.join(given) or 'none'}",
            "write one of box: {length, width, height}, cylinder: {radius, height}, "
            "sphere: {radius}, mesh: FILE",
        )
    if "mesh_origin" in value and given != ["mesh"]:
        raise rejected("'mesh_origin' is for mesh files", f"give the {given[0]} a center")
    return value


if TYPE_CHECKING:
    ShapeSection = Section
else:
    ShapeSection = Annotated[
        create_model(
            "ShapeSection",
            __base__=Section,
            **{name: (_section(kind) | None, None) for name, kind in SHAPES.items()},
            mesh=(str | None, None),
            mesh_origin=(Vector, (0.0, 0.0, 0.0)),
        ),
        BeforeValidator(_one_shape),
    ]


class TableSection(Section):
    """A table over time, its numbers given here or in a CSV file."""

    times: list[StrictFloat] | None = None
    values: list[StrictFloat] | None = None
    file: str | None = None
    columns: tuple[str, str] | None = None
    unit: UnitText = "1"
    description: str = ""


if TYPE_CHECKING:
    BodySection = JointSection = PointSection = LoadSection = Section
else:
    BodySection = _section(Body, shape=(ShapeSection | None, None))
    JointSection = _section(Joint)
    PointSection = _section(Point)
    sections = (_section(kind, type=(Literal[name], ...)) for name, kind in LOAD_TYPES.items())
    LoadSection = Annotated[reduce(operator.or_, sections), Field(discriminator="type")]


class ModelSection(Section):
    """The whole file."""

    name: str
    description: str = ""
    dimensions: Literal[2, 3] = 2
    gravity: Numbers = STANDARD_GRAVITY
    parameters: dict[str, ParameterSection] = Field(default_factory=dict)
    tables: dict[str, TableSection] = Field(default_factory=dict)
    bodies: dict[str, BodySection] = Field(default_factory=dict)
    joints: dict[str, JointSection] = Field(default_factory=dict)
    points: dict[str, PointSection] = Field(default_factory=dict)
    loads: dict[str, LoadSection] = Field(default_factory=dict)


def model_of(document: Document) -> Model:
    """The model in `document`; InputError with every problem found, placed in the file.

    Where keys or values are wrong, these are all problems: what they mean is checked after them.
    """

    def placed(finding: ModelFinding) -> Problem:
        return document.problem(finding.location, finding.message, finding.remedy)

    section, names = document.validate(ModelSection), Names.of(document.data)
    shapes, unread = _shapes(section, document.path.parent)
    groups = _elements(section, shapes)
    groups["tables"], unread_tables = _tables(section, document.path.parent)
    unread += unread_tables
    model = Groups(
        name=section.name,
        description=section.description,
        gravity=section.gravity,
        dimensions=section.dimensions,
        **groups,
    )
    found = group_findings(model, names)
    if not found and not unread:
        return Model(**vars(model)).place_warnings(placed)
    raise InputError([placed(finding) for finding in (*unread, *found)])


def _elements(section: ModelSection, shapes: Mapping[str, Shape]) -> dict[str, Any]:
    def made(
        kind: Callable[..., object],
        members: Mapping[str, Section],
        **instead: Mapping[str, object],
    ) -> dict[str, object]:
        return {
            name: kind(**{**dict(member), **{key: of.get(name) for key, of in instead.items()}})
            for name, member in members.items()
        }

    loads: dict[str, Load] = {}
    for name, member in section.loads.items():
        given = dict(member)
        loads[name] = LOAD_TYPES[given.pop("type")](**given)
    return {
        "parameters": made(Parameter, section.parameters),
        "bodies": made(Body, section.bodies, shape=shapes),
        "joints": made(Joint, section.joints),
        "points": made(Point, section.points),
        "loads": loads,
    }


def _shapes(section: ModelSection, folder: Path) -> tuple[dict[str, Shape], list[ModelFinding]]:
    """The shapes of bodies, their files from `folder`, and what is wrong with those files."""
    shapes: dict[str, Shape] = {}
    found: list[ModelFinding] = []
    for name, body in section.bodies.items():
        given = {key: value for key, value in dict(body)["shape"] or () if value is not None}
        for key in SHAPES.keys() & given.keys():
            make: Callable[..., Shape] = SHAPES[key]
            shapes[name] = make(**dict(given[key]))
        if "mesh" in given:
            at = ("bodies", name, "shape", "mesh")
            try:
                shapes[name] = Mesh(folder / given["mesh"], given["mesh_origin"])
            except InputError as error:
                found += (ModelFinding(at, p.message, p.remedy) for p in error.problems)
    return shapes, found


def _tables(section: ModelSection, folder: Path) -> tuple[dict[str, Table], list[ModelFinding]]:
    """The tables that can be read, their files from `folder`, and what is wrong with the others."""
    tables: dict[str, Table] = {}
    found: list[ModelFinding] = []
    for name, member in section.tables.items():
        at = ("tables", name)
        inline = member.times is not None and member.values is not None
        partly = member.times is not None or member.values is not None
        if inline == (member.file is not None) or (partly and not inline):
            remedy = "give 'times' and 'values', or the 'file' of a table"
            found.append(ModelFinding(at, "expected numbers or a file", remedy))
            continue
        times, values, unit = member.times or [], member.values or [], member.unit
        if member.file is not None:
            first, second = member.columns or (0, 1)
            wanted = (first, "s"), (second, None if unit == "1" else unit)
            try:
                columns = read_columns(folder / member.file, wanted)
            except InputError as error:
                found += (_file_finding(at, problem) for problem in error.problems)
                continue
            times, values = columns.values
            unit = (heading(columns.names[1])[1] or "1") if unit == "1" else unit
        tables[name] = Table(tuple(times), tuple(values), unit, member.description)
    return tables, found


def _file_finding(at: Location, problem: Problem) -> ModelFinding:
    """The finding on a problem of the file of the table at `at`."""
    place = "columns" if "column '" in problem.message else "file"
    line = f", line {problem.line}" if problem.line else ""
    message = f"{Path(problem.file).name}{line}: {problem.message}"
    return ModelFinding((*at, place), message, problem.remedy)
