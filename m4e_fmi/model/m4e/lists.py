"""Models from the lists of the paper, as its listings are typed.

S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", sections 5.1 and 5.2: `joints`,
`types`, `parent_cg_to_joint`, …, `Initial_Points`, `Force`, `ic`, `m0`, `J0`, `g`. In Python the
entries are numbers, SymPy expressions or texts of our own grammar; a YAML or JSON file may hold the
same lists, with `.nan` or `null` for NaN.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.files.document import Document, Location
from m4e_fmi.model.checks import element_findings, group_findings
from m4e_fmi.model.elements import Parameter
from m4e_fmi.model.findings import ModelFinding, Names
from m4e_fmi.model.groups import Groups
from m4e_fmi.model.m4e.forces import Forces
from m4e_fmi.model.m4e.mechanism import ROWS, SYMBOLS, Mechanism
from m4e_fmi.model.m4e.values import Data, plain
from m4e_fmi.model.model import Model

KEYS = (
    "joints", *ROWS, "Reference_frame_Origin", "Initial_Points", "Force", "ic", "m0", "J0", "g",
    "gVec", *(key for pair in SYMBOLS for key in pair),
)  # fmt: skip
SETTINGS = ("TimeStep", "tspan", "integrator_kwargs", "animation_on", "SaveMovieOn", "plotTstep")


def model_from_lists(
    lists: Mapping[str, Data],
    *,
    name: str = "m4e",
    description: str = "",
    parameters: Mapping[str, Parameter | float] | None = None,
) -> Model:
    """The Model that the paper's lists describe; InputError with every problem of theirs.

    `lists` holds them by the paper's names: a dictionary, or `globals()` of a script that defines
    them. Body k becomes `body_k`, held by `joint_k`; a point is `BD1_0`, `GR0` or `CG2`, a load
    `TensionSpring_0`. Masses, inertias and gravity that are numbers become the parameters `m1`, …,
    `J1`, …, `g`. Other symbols take their values from `BodyDataSym` with `BodyDataNum`, from
    `ForcesPointsSym` with `ForcesPointsNum`, or from `parameters` (a number, or with its unit).
    `ic` is [Q; QD] in the order of the children's numbers; what `parent_cg_to_joint` says of a
    floating body's place need not be said again. Coordinates X, Z of floating bodies are those of
    the world, `Reference_frame_Origin` included. Settings of the simulation (`tspan`, `TimeStep`,
    …) are not part of a model.
    """
    mechanism = Mechanism(
        {key: plain(lists[key]) for key in KEYS if key in lists}, parameters or {}
    )
    if "__name__" not in lists:  # in a script's globals() there is more than lists
        _report_unknown(mechanism, lists)

    def place(finding: ModelFinding) -> Problem:
        return Problem(f"{_place(finding.location)}: {finding.message}", finding.remedy, name)

    return _checked(mechanism, name, description, place)


def model_of_lists(document: Document) -> Model:
    """The Model of a file with the paper's lists; InputError with problems placed in the file.

    Its name is the file's, if none is given.
    """
    data = dict(document.data)
    name = data.pop("name", document.path.name.partition(".")[0])
    description = data.pop("description", "")
    mechanism = Mechanism({key: data[key] for key in KEYS if key in data}, {})
    _report_unknown(mechanism, data)
    for key, value in (("name", name), ("description", description)):
        if not isinstance(value, str):
            mechanism.say((key,), f"expected a text, got {value!r}")

    def place(finding: ModelFinding) -> Problem:
        return document.problem(finding.location, finding.message, finding.remedy)

    return _checked(mechanism, name, description, place)


def are_lists(data: Mapping[str, Data]) -> bool:
    """True if a file's plain data are the paper's lists."""
    return isinstance(data.get("joints"), list) and "model" not in data


def normalize_prismatic(directions: Data) -> list[list[Data]]:
    """Rows scaled to length 1 (NaN and zero rows as they are); here for the paper's listings.

    Models take directions of any length, so nothing depends on calling it.
    """
    return [_unit_vector(list(row)) for row in directions]


def _unit_vector(row: list[Data]) -> list[Data]:
    square: Data = 0
    for entry in row:
        square = square + entry * entry
    if square != square or square == 0:
        return row
    length = math.sqrt(square) if isinstance(square, int | float) else square**0.5
    return [entry / length for entry in row]


def _report_unknown(mechanism: Mechanism, lists: Mapping[str, Data]) -> None:
    for key in lists:
        if key not in KEYS and key not in SETTINGS:
            remedy = suggestion(str(key), KEYS, "names")
            mechanism.say((str(key),), f"unknown name {str(key)!r}", remedy)


def _checked(
    mechanism: Mechanism, name: str, description: str, place: Callable[[ModelFinding], Problem]
) -> Model:
    """The Model; InputError with what is wrong, placed in the lists."""
    forces = Forces(mechanism)
    points = forces.points()
    groups = Groups(
        name=name,
        description=description,
        gravity=mechanism.gravity(),
        bodies=mechanism.bodies(),
        joints=mechanism.joints(),
        loads=dict(forces.loads(points)),
        points=points,
        parameters=mechanism.symbols,
    )
    bodies = frozenset(f"body_{child}" for child in mechanism.children)
    names = replace(Names.of(groups), bodies=bodies)
    check = element_findings if mechanism.findings else group_findings

    def placed(finding: ModelFinding) -> Problem:
        return place(replace(finding, location=mechanism.place_of(finding.location)))

    found = [*map(place, mechanism.findings), *map(placed, check(groups, names))]
    InputError.raise_for(dict.fromkeys(found))
    return Model(**vars(groups)).place_warnings(placed)


def _place(location: Location) -> str:
    """A location as it is written in Python: Force["TensionSpring"][0][1]."""
    first, *rest = location or ("lists",)
    return str(first) + "".join(f'["{k}"]' if isinstance(k, str) else f"[{k}]" for k in rest)
