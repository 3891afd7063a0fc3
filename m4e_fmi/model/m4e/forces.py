"""Points and forces from the paper's `Initial_Points` and `Force`.

Names of points are "BD10" or "BD1_0", "GR00" or "GR0_0", "CG22" or "CG2_2". BD is a body's point
(body number from 1, index of the point from 0), GR a point of the ground (only the index counts),
CG the centre of gravity of a body (only the body's number counts). The first spelling, of numbers
of one digit, is that of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", section
5.2; the second is that of later versions of their code.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from m4e_fmi.files.document import Location
from m4e_fmi.model.elements import GROUND, Point
from m4e_fmi.model.expression import ExpressionError
from m4e_fmi.model.loads import (
    BodyForce,
    Load,
    PointForce,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.m4e.mechanism import Mechanism
from m4e_fmi.model.m4e.values import Data, added, is_number, is_row, is_whole
from m4e_fmi.model.quantity import as_expression

FORCES = (
    "PointsBD", "CG", "TensionSpring", "TensionDamper", "TorsionSpring", "TorsionDamper"
)  # fmt: skip
_FORM = re.compile(r"(GR|BD|CG)(?:(\d)(\d)|(\d+)_(\d+))")


@dataclass(frozen=True)
class PointName:
    """A point of `body` (0: the ground); `index` is None for the centre of gravity."""

    body: int
    index: int | None

    @property
    def name(self) -> str:
        """Its name in a Model: GR0, BD1_0 or CG2."""
        if self.index is None:
            return f"CG{self.body}"
        return f"BD{self.body}_{self.index}" if self.body else f"GR{self.index}"


def point_name(text: object, declared: Collection[PointName], bodies: int) -> PointName:
    """The point that `text` names, of those `declared` or of the CGs of `bodies` bodies.

    ValueError, with a message and a remedy, for an unknown point.
    """
    found = _FORM.fullmatch(text) if isinstance(text, str) else None
    if not found:
        remedy = (
            'write "BD1_0" (body 1, point 0), "GR0_0" (ground, point 0) or "CG2_2" (CG, body 2)'
        )
        raise ValueError(f"{text!r} does not name a point", remedy)
    kind, (body, index) = found[1], map(int, filter(None, found.groups()[1:]))
    name = PointName(body, None if kind == "CG" else index)
    known = 1 <= body <= bodies if kind == "CG" else name in declared
    if not known or (kind == "GR") != (body == 0):
        names = ", ".join(sorted(f"{'BD' if p.body else 'GR'}{p.body}_{p.index}" for p in declared))
        raise ValueError(f"there is no point {text!r}", f"points: {names or 'none'}; CG of a body")
    return name


class Forces:
    """Points and loads of a mechanism's lists."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.lists, self.children = mechanism.lists, mechanism.children
        self.say, self.places = mechanism.say, mechanism.places

    @cached_property
    def _point_rows(self) -> dict[PointName, tuple[Location, list[Data]]]:
        """The declared points: where each stands, and its row [x, z]."""
        groups = self.lists.get("Initial_Points", {})
        found: dict[PointName, tuple[Location, list[Data]]] = {}
        if not isinstance(groups, Mapping):
            self.say(("Initial_Points",), f"expected a dictionary, got {groups!r}")
            return found
        for key in groups:
            if key not in ("GR", "BD"):
                self.say(("Initial_Points", key), f"unknown group {key!r}", "known: 'GR', 'BD'")
        bodies = groups.get("BD") or {}
        if not isinstance(bodies, Mapping):
            message = f"expected a dictionary {{body: [[x, z], …]}}, got {bodies!r}"
            self.say(("Initial_Points", "BD"), message)
            bodies = {}
        lists: list[tuple[int, Location, Data]] = [(0, ("Initial_Points", "GR"), groups.get("GR"))]
        for key, rows in bodies.items():
            at = ("Initial_Points", "BD", key)
            number = int(key) if str(key).isdecimal() else 0
            if number not in self.children:
                self.say(at, f"there is no body {key!r}", f"bodies: 1 to {len(self.children)}")
            else:
                lists.append((number, at, rows))
        for number, at, rows in lists:
            if rows is not None and not isinstance(rows, list):
                self.say(at, f"expected a list of [x, z], got {rows!r}")
                continue
            for index, row in enumerate(rows or []):
                if is_row(row, 2):
                    found[PointName(number, index)] = ((*at, index), row)
                else:
                    self.say((*at, index), f"expected [x, z], got {row!r}")
        return found

    def points(self) -> dict[str, Point]:
        """The points of `Initial_Points` by their names here."""
        points = {}
        for name, (at, row) in self._point_rows.items():
            place = tuple(row) if name.body else added(self.mechanism.origin, row)
            points[name.name] = Point(f"body_{name.body}" if name.body else GROUND, place)
            self.places["points", name.name] = at
            self.places["points", name.name, "at"] = at
        return points

    def loads(self, points: dict[str, Point]) -> Iterator[tuple[str, Load]]:
        """Name and load for every entry of `Force`; `points` are those declared."""
        force = self.lists.get("Force", {})
        if not isinstance(force, Mapping):
            self.say(("Force",), f"expected a dictionary, got {force!r}")
            return
        for key, rows in force.items():
            at = ("Force", key)
            if key == "Moorings" and rows:
                remedy = (
                    "make it a component of a system (kind: mooring) and connect it to the points"
                )
                self.say(at, "mooring lines are not part of a model", remedy)
            elif key not in FORCES and key != "Moorings":
                self.say(at, f"unknown kind of force {key!r}", f"known: {', '.join(FORCES)}")
            elif not isinstance(rows, list):
                self.say(at, f"expected a list, got {rows!r}")
            elif key in FORCES:
                for k, row in enumerate(rows):
                    yield from self._load(key, k, row, points)

    def _load(
        self, kind: str, k: int, row: Data, points: dict[str, Point]
    ) -> Iterator[tuple[str, Load]]:
        """The loads of one row of Force[kind]."""
        name, at = f"{kind}_{k}", ("Force", kind, k)
        self.places["loads", name] = at
        if kind in ("CG", "PointsBD"):
            yield from self._applied(kind, name, at, row)
            return
        spring = kind.endswith("Spring")
        form = "((end, end), [rest, stiffness])" if spring else "((end, end), damping)"
        right = is_row(row, 2) and is_row(row[0], 2) and (not spring or is_row(row[1], 2))
        if not right or (not spring and isinstance(row[1], (list, tuple))):
            self.say(at, f"expected {form}, got {row!r}")
            return
        ends = tuple(self._end(kind, (*at, 0, i), end, points) for i, end in enumerate(row[0]))
        values = row[1] if spring else [row[1]]
        if None in ends:
            return
        made = {
            "TensionSpring": TensionSpring, "TorsionSpring": TorsionSpring,
            "TensionDamper": TensionDamper, "TorsionDamper": TorsionDamper,
        }[kind]  # fmt: skip
        fields = ["length" if kind == "TensionSpring" else "angle"] if spring else []
        if self._is_law(values[-1], made.law_variables):
            fields.append("law")
        else:
            fields.append("stiffness" if spring else "damping")
        for i, field in enumerate(fields):
            self.places["loads", name, field] = (*at, 1, i) if spring else (*at, 1)
        yield name, made(ends, **dict(zip(fields, values, strict=True)))  # pyrefly: ignore[bad-argument-type]

    def _is_law(self, value: Data, variables: Sequence[str]) -> bool:
        """True of a coefficient that is an expression of the extension or its rate: a law."""
        try:
            names = as_expression(value).names()
        except ExpressionError:  # reported where the value itself is checked
            return False
        return bool(names.intersection(variables) - set(self.mechanism.symbols))

    def _applied(self, kind: str, name: str, at: Location, row: Data) -> Iterator[tuple[str, Load]]:
        """A force given by its components: at a CG, or at a point of a body."""
        form = "[body, Fx, Fz, My]" if kind == "CG" else "[body, point, Fx, Fz, My]"
        width = form.count(",") + 1
        if not is_row(row, width):
            self.say(at, f"expected {form}, got {row!r}")
            return
        first = width - 3
        body = self._body((*at, 0), row[0], least=1)
        if body is None:
            return
        self.places |= {
            ("loads", name, "force", 0): (*at, first),
            ("loads", name, "force", 1): (*at, first + 1),
            ("loads", name, "moment"): (*at, first + 2),
        }
        x, z, moment = row[first:]
        if kind == "CG":
            yield name, BodyForce(body, (x, z), moment)
            return
        point = PointName(row[0], row[1] if is_whole(row[1]) else -1)
        if point not in self._point_rows:
            message = f"body {row[0]} has no point {row[1]!r}"
            count = sum(p.body == row[0] for p in self._point_rows)
            self.say((*at, 1), message, f"it has {count} points, counted from 0")
            return
        yield name, PointForce(point.name, (x, z))
        if not (is_number(moment) and moment == 0):
            yield f"{name}_moment", BodyForce(body, moment=moment)
            self.places["loads", f"{name}_moment", "moment"] = (*at, first + 2)

    def _end(self, kind: str, at: Location, end: Data, points: dict[str, Point]) -> str | None:
        """The point or body that an element acts on; a CG becomes a point when it is first used."""
        if kind.startswith("Torsion"):
            return self._body(at, end, least=0)
        try:
            name = point_name(end, self._point_rows, len(self.children))
        except ValueError as error:
            self.say(at, *error.args)
            return None
        if name.index is None:
            points.setdefault(name.name, Point(f"body_{name.body}", (0.0, 0.0)))
        return name.name

    def _body(self, at: Location, number: Data, *, least: int) -> str | None:
        if is_whole(number) and number == least == 0:
            return GROUND
        if not is_whole(number) or number not in self.children:
            self.say(at, f"there is no body {number!r}", f"bodies: {least} to {len(self.children)}")
            return None
        return f"body_{number}"
