"""Attachments of the points, rods and lines of a MoorDyn file.

Points and rods are held, moved from outside (coupled, or fixed to a coupled body) or free. A
coupled body is not given to MoorDyn: each of its points is a fairlead of its own, and each of its
rods has one at either end, which whoever connects them moves with the body. A coupled body or rod
that is pinned has one fairlead, where it is pinned; MoorDyn turns it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from m4e_adapters.moordyn.ready_files.read_file import ReadFile, Row, has_force, number
from m4e_fmi.errors import suggestion

COUPLED = ("FAIRLEAD", "VESSEL", "VES", "COUPLED", "CPLD")
PINNED = ("VESSELPINNED", "VESPIN", "CPLDPIN", "COUPLEDPINNED")
FIXED = ("ANCHOR", "FIXED", "FIX")
FREE = ("POINT", "CONNECT", "CON", "FREE")
BODY = re.compile(r"BODY0*(\d+)(PINNED|PIN)?")
LETTERS = re.compile(r"[A-Z]*")
POINT_END = re.compile(r"(?:CON|C|POINT|P)?0*(\d+)")
ROD_END = re.compile(r"R(?:OD)?0*(\d+)([AB])")
POSE, ENDS = slice(2, 8), slice(3, 9)
DRAG, LOST = 12, (3, 6)  # word of a body's drag areas; of so many MoorDyn 2.7.2 leaves the first 0
MASS, VOLUME, ADDED_MASS = 5, 6, 8  # words of a point without a force
BODY_LOST = {8: "mass", 10: "moment of inertia", 11: "volume", 12: "drag area"}
Place = tuple[float, float, float]


class Attachments:
    """Who moves what in `file`, by the words of its rows, which MoorDyn accepts."""

    def __init__(self, file: ReadFile) -> None:
        self.file = file
        self.bodies = {row.words[0]: row for row in file.rows("bodies")}

    def check(self) -> None:
        """Note what MoorDyn leaves out or would misread, and loose points."""
        for row in self.bodies.values():
            self._check_body(row)
        for row in self.file.rows("rods"):
            if self.moved(row, 2) and float(row.words[9]) == 0:
                message = "a coupled rod without length has no direction"
                self.file.wrong(row, message, "make it a coupled point", 9)
        used = {end for row in self.file.rows("lines") for end in ends_of(row)}
        for row in self.file.rows("points"):
            if self.moved(row):
                self._note_inertia(row)
            if row.words[0] not in used and self.free(row):
                remedy = "remove it, or let a line end there"
                self.file.wrong(row, f"no line ends at point {row.words[0]}", remedy)

    def moved(self, row: Row, kind: int = 1) -> bool:
        """True if a point, or what has its `kind` in another column, is moved from outside."""
        body = BODY.match(row.words[kind].upper())
        if body:
            return _kind(self.bodies[body[1]]) in COUPLED
        return _kind(row, kind) in (*COUPLED, *PINNED)

    def hinged(self, row: Row) -> bool:
        """True if a rod that is moved turns about its end A."""
        body = BODY.match(row.words[2].upper())
        return bool(body[2]) if body else _kind(row, 2) in PINNED

    def coupled(self) -> Iterator[tuple[Row, tuple[Place, ...]]]:
        """Moved rows in the order of MoorDyn, with the places of their fairleads [m]."""
        for row in self.bodies.values():
            if _kind(row) in PINNED:
                x, y, z = map(float, row.words[2:5])
                yield row, ((x, y, z),)
        for row in self.file.rows("rods"):
            if self.moved(row, 2):
                ends = self.rod_ends(row)
                yield row, ends[:1] if self.hinged(row) else ends
        for row in self.file.rows("points"):
            if self.moved(row):
                yield row, (self.place(row),)

    def free(self, row: Row) -> bool:
        """True if a point moves by its forces."""
        return _kind(row) in FREE

    def held(self, row: Row) -> bool:
        """True if a point stays where it is."""
        return _kind(row) in FIXED

    def simple(self) -> bool:
        """True if all lines end at points that are held, moved or free by themselves."""
        points = self.file.rows("points")
        alone = all(self.moved(row) or self.free(row) or self.held(row) for row in points)
        still = all(_kind(row) in (*COUPLED, *FIXED) for row in self.bodies.values())
        return alone and still and not self.file.rows("rods")

    def place(self, row: Row) -> Place:
        """(x, y, z) [m] of a point in the world, with its body as the file has it."""
        return self._in_world(row.words[1], row.words[2:5])

    def rod_ends(self, row: Row) -> tuple[Place, Place]:
        """(x, y, z) [m] of the ends A and B of a rod in the world."""
        a, b = row.words[3:6], row.words[6:9]
        return self._in_world(row.words[2], a), self._in_world(row.words[2], b)

    def _in_world(self, kind: str, words: tuple[str, ...]) -> Place:
        x, y, z = map(float, words)
        body = BODY.match(kind.upper())
        if not body:
            return x, y, z
        pose = [float(word) for word in self.bodies[body[1]].words[POSE]]
        turned = np.array(pose[:3]) + _rotation(*map(math.radians, pose[3:])) @ (x, y, z)
        return float(turned[0]), float(turned[1]), float(turned[2])

    def _check_body(self, row: Row) -> None:
        kind, areas = _kind(row), row.words[DRAG]
        if kind not in (*FIXED, *COUPLED, *PINNED, *FREE):  # MoorDyn takes an unknown one for free
            remedy = suggestion(row.words[1], ("Fixed", "Coupled", "Free"), "types")
            self.file.wrong(row, f"bodies of type {row.words[1]!r} are not supported", remedy, 1)
        if kind in (*FREE, *PINNED) and len(areas.split("|")) in LOST:
            message = f"drag area CdA: MoorDyn would take the first of {areas!r} for 0"
            remedy = "give one value, or two: of displacements and of rotations"
            self.file.wrong(row, message, remedy, DRAG)
        lost = [name for k, name in BODY_LOST.items() if _is_given(row.words[k])]
        if kind in COUPLED and lost:
            self.file.notes.append(
                f"MoorDyn leaves out the {' and the '.join(lost)} of coupled body {row.words[0]}: "
                "give it to the body in the model that moves it"
            )

    def _note_inertia(self, row: Row) -> None:
        """Note mass and added mass of a point that is moved: MoorDyn has their weight only."""
        k = ADDED_MASS + 3 * has_force(row)
        volume = _is_given(row.words[VOLUME]) and _is_given(row.words[k])
        if _is_given(row.words[MASS]) or volume:
            self.file.notes.append(
                f"the mass of coupled point {row.words[0]} only weighs and the added mass is left "
                "out, as in MoorDyn: add their inertia to the body in the model that moves it"
            )


def ends_of(row: Row) -> list[str]:
    """The numbers of the points at which a line ends; of a rod's end as R1A."""
    return [end_name(word) for word in row.words[2:4]]


def end_name(word: str) -> str:
    """The number of a point, or R1A for end A of the first rod; as it is written if it is none."""
    rod, point = ROD_END.match(word.upper()), POINT_END.match(word.upper())
    return f"R{rod[1]}{rod[2]}" if rod else point[1] if point else word


def _kind(row: Row, column: int = 1) -> str:
    """The letters of a type, which MoorDyn goes by."""
    found = LETTERS.match(row.words[column].upper())
    return found[0] if found else ""


def _is_given(word: str) -> bool:
    """True if a value of `word` is a number other than 0."""
    return any(number(value) and float(value) != 0 for value in word.split("|"))


def _rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """MoorDyn's body → world matrix: X(roll) Y(pitch) Z(yaw), angles in rad."""
    c, s = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    return x @ y @ z
