"""Chrono's YAML file of a model, or of a simulation that names it, as a Model."""

from __future__ import annotations

from m4e_fmi.errors import InputError, Problem, is_file
from m4e_fmi.files.document import Document
from m4e_fmi.files.files_read import depends_on
from m4e_fmi.model.checks import group_findings
from m4e_fmi.model.chrono.loads import Loads
from m4e_fmi.model.chrono.mechanism import Mechanism
from m4e_fmi.model.chrono.names import Places
from m4e_fmi.model.chrono.sections import (
    ChronoSimulationSection,
    FileSection,
    ModelFileSection,
)
from m4e_fmi.model.elements import identifier
from m4e_fmi.model.findings import ModelFinding, Names
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.model import Model

GRAVITY = (0.0, 0.0, -9.8)
"""Chrono's own where a simulation says nothing of it [m/s²] (ChParserMbsYAML, SimParams)."""


def model_of_chrono(document: Document) -> Model:
    """The Model of a Chrono file; InputError with the problems found, placed in the file.

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
    section = document.validate(ModelFileSection).model
    gravity = _gravity(placed)
    places = Places(document, section)
    places.check_names()
    InputError.raise_for(places.problems)
    mechanism = Mechanism(section, places)
    joints, bodies = mechanism.joints(), mechanism.bodies()
    InputError.raise_for(places.problems)
    loads = Loads(mechanism)
    loads.convert()
    InputError.raise_for(dict.fromkeys(places.problems))
    groups = Groups(
        name=identifier(section.name),
        description=f"Chrono model {section.name}",
        bodies=bodies,
        joints=joints,
        points=loads.points,
        loads=loads.loads,
        tables=loads.tables,
        gravity=gravity if any(gravity[:2]) else -gravity[2],
        dimensions=3,
    )

    def at_entry(finding: ModelFinding) -> Problem:
        message = f"{'.'.join(map(str, finding.location))}: {finding.message}"
        group, name, *_ = (*map(str, finding.location), "", "")
        return document.problem(places.of(group, name), message, finding.remedy)

    found = group_findings(groups, Names.of(groups))
    InputError.raise_for(map(at_entry, found))
    return Model(**vars(groups)).place_warnings(at_entry)


def _beside(document: Document) -> Document | None:
    """The file of the simulation that belongs to a model by its name, if there is one."""
    stem = document.path.name.removesuffix(".model.yaml")
    path = document.path.with_name(f"{stem}.simulation.yaml")
    if "simulation" in document.data or stem == document.path.name:
        return None
    depends_on(path)
    return Document.load(path) if is_file(path) else None


def _gravity(document: Document) -> tuple[float, float, float]:
    """Gravity of the simulation in `document` [m/s²]."""
    if "simulation" not in document.data:
        return GRAVITY
    return document.validate(ChronoSimulationSection, at=("simulation",)).gravity or GRAVITY
