"""Attachments of the points, rods and lines of a MoorDyn file.

Points are held, moved from outside (coupled, or fixed to a coupled body) or free. A coupled body is
not given to MoorDyn: each of its points is a fairlead of its own, which whoever connects it moves
with the body.
"""

from __future__ import annotations

import math
import re

import numpy as np

from m4e_adapters.moordyn.ready_files.read_file import ReadFile, has_force
from m4e_adapters.moordyn.ready_files.sections import Row, number
from m4e_fmi.errors import suggestion

COUPLED = ("FAIRLEAD", "VESSEL", "VES", "COUPLED", "CPLD")
PINNED = ("VESSELPINNED", "VESPIN", "CPLDPIN", "COUPLEDPINNED")
FIXED = ("ANCHOR", "FIXED", "FIX")
HINGED = ("PINNED", "PIN")  # of rods
FREE = ("POINT", "CONNECT", "CON", "FREE")
BODY = re.compile(r"BODY(\d+)(PINNED|PIN)?")
POINT_END = re.compile(r"(?:CON|C|POINT|P)?(\d+)")
ROD_END = re.compile(r"(?:ROD|R)(\d+)([AB])")
POSE = slice(2, 8)
DRAG, LOST = 12, (3, 6)  # word of a body's drag areas; of so many MoorDyn 2.7.2 leaves the first 0
MASS, VOLUME, ADDED_MASS = 5, 6, 8  # words of a point without a force
BODY_LOST = {8: "mass", 10: "moment of inertia", 11: "volume", 12: "drag area"}
Place = tuple[float, float, float]


class Attachments:
    """Who moves what in `file`, by the words of its rows."""

    def __init__(self, file: ReadFile) -> None:
        self.file = file
        self.bodies = {row.words[0]: row for row in file.rows("bodies")}

    def check(self) -> None:
        """Note kinds that there are not and that are not supported, and points without a line."""
        for row in self.bodies.values():
            self._check_body(row)
        rod_types = [row.words[0] for row in self.file.rows("rod types")]
        for row in self.file.rows("rods"):
            self._check_rod(row, rod_types)
        for row in self.file.rows("points"):
            self._check_point(row)
        used = {end for row in self.file.rows("lines") for end in self._ends(row)}
        for row in self.file.rows("points"):
            if row.words[0] not in used and not _is(row.words[1], FIXED):
                remedy = "remove it, or let a line end there"
                self.file.wrong(row, f"no line ends at point {row.words[0]}", remedy)

    def moved(self, row: Row) -> bool:
        """True if a point is moved from outside."""
        body = BODY.fullmatch(row.words[1].upper())
        if body:
            return _is(self.bodies[body[1]].words[1], COUPLED)
        return _is(row.words[1], COUPLED)

    def free(self, row: Row) -> bool:
        """True if a point moves by its forces."""
        return _is(row.words[1], FREE)

    def held(self, row: Row) -> bool:
        """True if a point stays where it is."""
        return _is(row.words[1], FIXED)

    def simple(self) -> bool:
        """True if all lines end at points that are held, moved or free by themselves."""
        on_others = [
            row
            for row in self.file.rows("points")
            if BODY.fullmatch(row.words[1].upper()) and not self.moved(row)
        ]
        return not on_others and not self.file.rows("rods")

    def place(self, row: Row) -> Place:
        """(x, y, z) [m] of a point in the world, with its body as the file has it."""
        x, y, z = (float(word) for word in row.words[2:5])
        body = BODY.fullmatch(row.words[1].upper())
        if not body:
            return x, y, z
        pose = [float(word) for word in self.bodies[body[1]].words[POSE]]
        turned = np.array(pose[:3]) + _rotation(*map(math.radians, pose[3:])) @ (x, y, z)
        return float(turned[0]), float(turned[1]), float(turned[2])

    def _ends(self, row: Row) -> list[str]:
        """The numbers of the points at which a line ends."""
        found = []
        points = {row.words[0] for row in self.file.rows("points")}
        rods = {row.words[0] for row in self.file.rows("rods")}
        for k, word in enumerate(row.words[2:4], 2):
            point, rod = POINT_END.fullmatch(word.upper()), ROD_END.fullmatch(word.upper())
            if point and point[1] in points:
                found.append(point[1])
            elif not rod or rod[1] not in rods:
                message = f"there is no point {word}" if point else f"there is no rod end {word!r}"
                remedy = suggestion(point[1] if point else word, points, "points")
                self.file.wrong(row, message, remedy, k)
        if row.words[2] == row.words[3]:
            message = f"line {row.words[0]} begins and ends at {row.words[2]}"
            self.file.wrong(row, message, "let it end at another point", 3)
        return found

    def _check_body(self, row: Row) -> None:
        kind = row.words[1]
        if _is(kind, PINNED):
            self.file.wrong(row, "coupled pinned bodies are not supported", "use 'Coupled'")
        elif not _is(kind, (*FIXED, *COUPLED, *FREE)):
            remedy = suggestion(kind, ("Fixed", "Coupled", "Free"), "types")
            self.file.wrong(row, f"there is no type of body {kind!r}", remedy, 1)
        areas = row.words[DRAG]
        if _is(kind, FREE) and len(areas.split("|")) in LOST:
            message = f"drag area CdA: MoorDyn would take the first of {areas!r} for 0"
            remedy = "give one value, or two: of displacements and of rotations"
            self.file.wrong(row, message, remedy, DRAG)
        if _is(kind, COUPLED):
            self._check_lost(row)

    def _check_lost(self, row: Row) -> None:
        """Note the first value of a coupled body that would have no effect."""
        body = f"coupled body {row.words[0]}"
        for k, name in BODY_LOST.items():
            if _is_given(row.words[k]):
                message = f"the {name} {row.words[k]} of {body} would be lost"
                remedy = f"set it to 0, and give it to the body in the model that moves {body}"
                self.file.wrong(row, message, remedy, k)
                return

    def _check_rod(self, row: Row, types: list[str]) -> None:
        if row.words[1] not in types:
            message = f"there is no rod type {row.words[1]!r}"
            remedy = suggestion(row.words[1], types, "rod types")
            self.file.wrong(row, message, remedy, 1)
        kind = row.words[2].upper()
        body = BODY.fullmatch(kind)
        coupled = body and body[1] in self.bodies and _is(self.bodies[body[1]].words[1], COUPLED)
        if coupled or kind.startswith(COUPLED + PINNED):
            self.file.wrong(
                row,
                "rods on coupled bodies, and coupled rods, are not supported: their weight and "
                "moments would be lost",
                "attach the lines to points of the body, and make the rod part of the body",
            )
        elif body and body[1] not in self.bodies:
            self._no_body(row, 2)
        elif not body and not _is(kind, (*FIXED, *HINGED, *FREE)):
            known = ("Fixed", "Pinned", "Free", *(f"Body{k}" for k in self.bodies))
            remedy = suggestion(row.words[2], known, "types")
            self.file.wrong(row, f"there is no type of rod {row.words[2]!r}", remedy, 2)

    def _check_point(self, row: Row) -> None:
        kind, body = row.words[1], BODY.fullmatch(row.words[1].upper())
        if body and body[1] not in self.bodies:
            self._no_body(row, 1)
        elif not body and not _is(kind, (*FIXED, *COUPLED, *FREE)):
            known = ("Fixed", "Coupled", "Free", *(f"Body{k}" for k in self.bodies))
            remedy = suggestion(kind, known, "types")
            self.file.wrong(row, f"there is no type of point {kind!r}", remedy, 1)
        elif self.moved(row):
            self._check_inertia(row)

    def _check_inertia(self, row: Row) -> None:
        """Note mass and added mass of a point that is moved: MoorDyn has their weight only."""
        point, body = f"coupled point {row.words[0]}", "the body in the model that moves it"
        mass, volume = row.words[MASS], row.words[VOLUME]
        if _is_given(mass):
            message = f"the inertia of {point} would be lost: its mass {mass} kg would only weigh"
            self.file.wrong(row, message, f"set it to 0, and add the mass to {body}", MASS)
        k = ADDED_MASS + 3 * has_force(row)
        if _is_given(volume) and _is_given(row.words[k]):
            message = f"the added mass of {point}, CA {row.words[k]} of {volume} m³, would be lost"
            self.file.wrong(row, message, f"set CA to 0, and add it to {body}", k)

    def _no_body(self, row: Row, column: int) -> None:
        word = row.words[column]
        remedy = suggestion(word, [f"Body{k}" for k in self.bodies], "bodies")
        self.file.wrong(row, f"there is no body for {word!r}", remedy, column)


def _is(word: str, kinds: tuple[str, ...]) -> bool:
    return word.upper() in kinds


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
