"""Chrono's YAML file of a model, or of a simulation that names it, as a Model."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

from m4e_fmi.errors import InputError, Problem, is_file, suggestion
from m4e_fmi.files.document import Document, Location, SectionType
from m4e_fmi.files.files_read import depends_on
from m4e_fmi.model.checks import group_findings
from m4e_fmi.model.chrono.loads import Loads
from m4e_fmi.model.chrono.mechanism import SMALL, Mechanism
from m4e_fmi.model.chrono.names import GROUPS, Places, entries
from m4e_fmi.model.chrono.planar import LeavesPlaneError, PlanarLoads, PlanarMechanism
from m4e_fmi.model.chrono.rotation import Vector3
from m4e_fmi.model.chrono.sections import (
    REFUSED,
    ChronoSimulationSection,
    FileSection,
    ModelFileSection,
)
from m4e_fmi.model.elements import GROUND, Quantity, Vector, identifier
from m4e_fmi.model.findings import ModelFinding, Names
from m4e_fmi.model.model import Model

GRAVITY: Vector3 = (0.0, 0.0, -9.8)
"""Chrono's own where a simulation says nothing of it [m/s²] (ChParserMbsYAML, SimParams)."""


def model_of_chrono(document: Document) -> Model:
    """The Model of a Chrono file; InputError with every problem found, placed in the file.

    Gravity is that of the simulation: in this file, in the file `<stem>.simulation.yaml` beside a
    `<stem>.model.yaml`, or Chrono's own. `visualization` and what belongs to Chrono's solver has no
    meaning here.
    """
    placed = document
    if isinstance(document.data.get("model"), str):
        named = document.validate(FileSection)
        document = Document.load(document.path.parent / str(named.model))
    elif (beside := _beside(document)) is not None:
        placed = beside
    places = Places(document)
    section = _validated(document, places, ModelFileSection)
    gravity = _gravity(placed, places)
    _report_refused(places)
    _report_names(places)
    if section is None or places.problems:
        raise InputError(dict.fromkeys(places.problems))
    return _model(section, gravity, places)


def _validated(
    document: Document, places: Places, section: type[SectionType], at: Location = ()
) -> SectionType | None:
    """A part of a document; None, with its problems noted, if its form is wrong."""
    try:
        return document.validate(section, at=at)
    except InputError as error:
        places.problems += error.problems
        return None


def _beside(document: Document) -> Document | None:
    """The file of the simulation that belongs to a model by its name, if there is one."""
    stem = document.path.name.removesuffix(".model.yaml")
    path = document.path.with_name(f"{stem}.simulation.yaml")
    if "simulation" in document.data or stem == document.path.name:
        return None
    depends_on(path)
    return Document.load(path) if is_file(path) else None


def _gravity(document: Document, places: Places) -> Vector3:
    """Gravity of the simulation in `document` [m/s²]."""
    if "simulation" not in document.data:
        return GRAVITY
    simulation = _validated(document, places, ChronoSimulationSection, ("simulation",))
    return (simulation and simulation.gravity) or GRAVITY


def _report_refused(places: Places) -> None:
    """Keys of Chrono's that have no counterpart."""
    data = places.document.data
    model = data.get("model")
    for (group, key), (message, remedy) in REFUSED.items():
        if group == "model" and isinstance(model, dict) and model.get(key):
            places.at(("model", key), message, remedy)
        for k, entry in enumerate(entries(data, group)):
            if isinstance(entry, dict) and entry.get(key) is not None:
                places.at(("model", group, k, key), message, remedy)


def _report_names(places: Places) -> None:
    """Names given twice, and bodies that are not there; over all entries, right or wrong."""
    data = places.document.data
    for group in GROUPS:
        first: dict[str, str] = {}
        for k, name in _named(data, group, "name"):
            if identifier(name) in first:
                message = f"{name!r} is given twice"
                if name != first[identifier(name)]:
                    message = f"{name!r} and {first[identifier(name)]!r} would get the same name"
                places.at(("model", group, k, "name"), message, "rename one of the two")
            first.setdefault(identifier(name), name)
    for k, body in enumerate(entries(data, "bodies")):
        if isinstance(body, dict) and body.get("name") == GROUND and not body.get("fixed"):
            message = "'ground' is the name of the world"
            places.at(("model", "bodies", k, "name"), message, "rename it, or 'fixed: true'")
    bodies = {name for _, name in _named(data, "bodies", "name")}
    for group in GROUPS[1:]:
        for key in ("body", "body1", "body2"):
            for k, name in _named(data, group, key):
                if name not in bodies:
                    remedy = suggestion(name, bodies, "bodies")
                    places.at(("model", group, k, key), f"unknown body {name!r}", remedy)


def _named(data: object, group: str, key: str) -> Iterator[tuple[int, str]]:
    for k, entry in enumerate(entries(data, group)):
        if isinstance(entry, dict) and isinstance(entry.get(key), str):
            yield k, entry[key]


def _model(file: ModelFileSection, gravity: Vector3, places: Places) -> Model:
    """The Model: of the plane if nothing leaves it and the file does not ask for space."""
    if file.dimensions is None:
        try:
            if max(map(abs, gravity[:2])) > SMALL:
                raise LeavesPlaneError
            mechanism = PlanarMechanism(file.model, places)
            return _converted(mechanism, PlanarLoads(mechanism), -gravity[2])
        except LeavesPlaneError:
            places.problems.clear()
    spatial = Mechanism(file.model, places)
    along_z = max(map(abs, gravity[:2])) == 0
    return _converted(spatial, Loads(spatial), -gravity[2] if along_z else gravity)


def _converted(mechanism: Mechanism, loads: Loads, gravity: Quantity | Vector) -> Model:
    model, places = mechanism.model, mechanism.places
    joints, bodies = mechanism.joints(), mechanism.bodies()
    if not places.problems:
        loads.convert()
    if places.problems:
        raise InputError(dict.fromkeys(places.problems))
    return _checked(
        places,
        name=identifier(model.name),
        description=f"Chrono model {model.name}",
        bodies=bodies,
        joints=joints,
        points=loads.points,
        loads=loads.loads,
        tables=loads.tables,
        gravity=gravity,
        dimensions=mechanism.dimensions,
        parameters={},
    )


def _checked(places: Places, **fields: Any) -> Model:
    """The Model; what its own checks find is placed in the file as far as that is possible."""

    def placed(finding: ModelFinding) -> Problem:
        message = f"{'.'.join(map(str, finding.location))}: {finding.message}"
        group, name, *_ = (*map(str, finding.location), "", "")
        return places.document.problem(places.of(group, name), message, finding.remedy)

    found = group_findings(SimpleNamespace(**fields), Names.of(fields))
    InputError.raise_for(map(placed, found))
    return Model(**fields).place_warnings(placed)
