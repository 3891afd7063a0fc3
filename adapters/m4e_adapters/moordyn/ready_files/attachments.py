"""Attachments of the points, rods and lines of a MoorDyn file.

Points are held, moved from outside (coupled, or fixed to a coupled body) or free. A coupled body is
not given to MoorDyn: each of its points is a fairlead of its own, which whoever connects it moves
with the body.
"""

from __future__ import annotations

import math
import re

import numpy as np

from m4e_adapters.moordyn.ready_files.read_file import ReadFile, Row, has_force, number
from m4e_fmi.errors import suggestion

COUPLED = ("FAIRLEAD", "VESSEL", "VES", "COUPLED", "CPLD")
FIXED = ("ANCHOR", "FIXED", "FIX")
FREE = ("POINT", "CONNECT", "CON", "FREE")
BODY = re.compile(r"BODY0*(\d+)(PINNED|PIN)?")
HINGED = ("PINNED", "PIN")  # of rods
POINT_END = re.compile(r"(?:CON|C|POINT|P)?0*(\d+)")
POSE = slice(2, 8)
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
        """Note kinds that are not supported, masses that would be lost, points without a line."""
        for row in self.bodies.values():
            self._check_body(row)
        for row in self.file.rows("rods"):
            body = BODY.fullmatch(row.words[2].upper())
            alone = row.words[2].upper() in (*FIXED, *HINGED, *FREE)
            if self.moved(row, 2) or not (body or alone):
                message = f"rods of type {row.words[2]!r} are not supported"
                if self.moved(row, 2):
                    message = "rods that are coupled lose their weight and moments"
                remedy = "attach the lines to points of the body, and make the rod part of the body"
                self.file.wrong(row, message, remedy, 2)
        used = {end for row in self.file.rows("lines") for end in ends_of(row)}
        for row in self.file.rows("points"):
            if self.moved(row):
                self._check_inertia(row)
            elif not (self.free(row) or self.held(row) or BODY.fullmatch(row.words[1].upper())):
                message = f"points of type {row.words[1]!r} are not supported"
                self.file.wrong(row, message, "use 'Fixed', 'Coupled', 'Free' or 'Body1'", 1)
            if row.words[0] not in used and not self.held(row):
                remedy = "remove it, or let a line end there"
                self.file.wrong(row, f"no line ends at point {row.words[0]}", remedy)

    def moved(self, row: Row, kind: int = 1) -> bool:
        """True if a point, or what has its `kind` in another column, is moved from outside."""
        body = BODY.fullmatch(row.words[kind].upper())
        word = self.bodies[body[1]].words[1] if body else row.words[kind]
        return word.upper() in COUPLED

    def free(self, row: Row) -> bool:
        """True if a point moves by its forces."""
        return row.words[1].upper() in FREE

    def held(self, row: Row) -> bool:
        """True if a point stays where it is."""
        return row.words[1].upper() in FIXED

    def simple(self) -> bool:
        """True if all lines end at points that are held, moved or free by themselves."""
        points = self.file.rows("points")
        alone = all(self.moved(row) or self.free(row) or self.held(row) for row in points)
        return alone and not self.file.rows("rods")

    def place(self, row: Row) -> Place:
        """(x, y, z) [m] of a point in the world, with its body as the file has it."""
        x, y, z = (float(word) for word in row.words[2:5])
        body = BODY.fullmatch(row.words[1].upper())
        if not body:
            return x, y, z
        pose = [float(word) for word in self.bodies[body[1]].words[POSE]]
        turned = np.array(pose[:3]) + _rotation(*map(math.radians, pose[3:])) @ (x, y, z)
        return float(turned[0]), float(turned[1]), float(turned[2])

    def _check_body(self, row: Row) -> None:
        kind, areas = row.words[1].upper(), row.words[DRAG]
        if kind not in (*FIXED, *COUPLED, *FREE):  # MoorDyn takes an unknown one for free
            remedy = suggestion(row.words[1], ("Fixed", "Coupled", "Free"), "types")
            self.file.wrong(row, f"bodies of type {row.words[1]!r} are not supported", remedy, 1)
        if kind in FREE and len(areas.split("|")) in LOST:
            message = f"drag area CdA: MoorDyn would take the first of {areas!r} for 0"
            remedy = "give one value, or two: of displacements and of rotations"
            self.file.wrong(row, message, remedy, DRAG)
        lost = [k for k in BODY_LOST if kind in COUPLED and _is_given(row.words[k])]
        for k in lost[:1]:
            body = f"coupled body {row.words[0]}"
            message = f"the {BODY_LOST[k]} {row.words[k]} of {body} would be lost"
            remedy = f"set it to 0, and give it to the body in the model that moves {body}"
            self.file.wrong(row, message, remedy, k)

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


def ends_of(row: Row) -> list[str]:
    """The numbers of the points at which a line ends; a rod's end stays as it is written."""
    found = [(word, POINT_END.match(word.upper())) for word in row.words[2:4]]
    return [match[1] if match else word for word, match in found]


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
