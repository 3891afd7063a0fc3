"""A mooring in static equilibrium: its lines, their stiffness, offsets, and broken lines.

A kind of FMU with mooring lines offers it by its function `mooring`: docs/adapters.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_fmi.shown import columns


@dataclass(frozen=True)
class LineData:
    """A line at rest, from end A (`from`) to end B (`to`).

    `length` [m] unstretched, of which `on_bed` [m] lie on the seabed; `nodes` (n, 3) [m];
    `tensions` (2,) [N] at the ends, `angles` (2,) [rad] of the line to the horizontal there;
    `largest` [N] tension along it; `strength` [N], nan if it is not known.
    """

    name: str
    length: float
    on_bed: float
    nodes: np.ndarray
    tensions: np.ndarray
    angles: np.ndarray
    largest: float
    strength: float

    @property
    def layback(self) -> float:
        """Horizontal distance [m] of its ends."""
        return float(np.hypot(*(self.nodes[-1] - self.nodes[0])[:2]))


@dataclass(frozen=True)
class OffsetCurve:
    """All fairleads moved towards `direction` [rad] from X to Y: m points until `limit`.

    `offsets` (m,) [m]; `pull` (m,) [N] back, against the direction; `tensions` (m, lines) [N], the
    largest along each line.
    """

    direction: float
    offsets: np.ndarray
    pull: np.ndarray
    tensions: np.ndarray
    limit: str


@dataclass(frozen=True)
class BrokenLine:
    """The equilibrium without a line: the `drift` (2,) [m] of fairleads, `tensions` (lines,) [N].

    They move horizontally, unturned, until the lines pull them sideways as before.
    """

    name: str
    drift: np.ndarray
    tensions: np.ndarray


@dataclass(frozen=True)
class MooringData:
    """A mooring whose fairleads, or some of them, move as one rigid body.

    `about` (3,) [m] is the point for `force` (6,) [N, N.m] on the body and `stiffness` (6, 6)
    [N/m, N, N.m] by displacements [m] and turns [rad] about X, Y, Z; moments are about the moved
    point. `broken` has those lines without which an equilibrium was found.
    """

    title: str
    lines: tuple[LineData, ...]
    about: np.ndarray
    force: np.ndarray
    stiffness: np.ndarray
    curves: tuple[OffsetCurve, ...]
    broken: tuple[BrokenLine, ...]
    bed: float
    notes: tuple[str, ...] = ()

    def safety(self, tensions: np.ndarray) -> tuple[float, str]:
        """The smallest safety factor at these `tensions` (lines,) [N], nan if none is known.

        With the name of its line; without strengths that of the largest tension.
        """
        factors = np.array([line.strength for line in self.lines]) / np.maximum(tensions, 1e-9)
        if np.isnan(factors).all():
            return np.nan, self.lines[int(np.nanargmax(tensions))].name
        k = int(np.nanargmin(factors))
        return float(factors[k]), self.lines[k].name

    def to_dict(self) -> dict[str, object]:
        """All numbers, SI; angles in deg."""
        return {
            "title": self.title,
            "notes": list(self.notes),
            "lines": {
                line.name: {
                    "length": line.length,
                    "on_bed": line.on_bed,
                    "layback": line.layback,
                    "tensions": line.tensions.tolist(),
                    "angles": np.degrees(line.angles).tolist(),
                    "largest_tension": line.largest,
                    "breaking_strength": _known(line.strength),
                    "safety_factor": _known(line.strength / line.largest),
                    "nodes": line.nodes.tolist(),
                }
                for line in self.lines
            },
            "about": self.about.tolist(),
            "force": self.force.tolist(),
            "stiffness": self.stiffness.tolist(),
            "offsets": [
                {
                    "direction": float(np.degrees(curve.direction)),
                    "offset": curve.offsets.tolist(),
                    "pull": curve.pull.tolist(),
                    "tensions": curve.tensions.tolist(),
                    "limit": curve.limit,
                }
                for curve in self.curves
            ],
            "broken": {
                one.name: {
                    "drift": one.drift.tolist(),
                    "tensions": one.tensions.tolist(),
                    "safety_factor": _known(self.safety(one.tensions)[0]),
                }
                for one in self.broken
            },
        }

    def __str__(self) -> str:
        return "\n".join(self._text())

    def _text(self) -> Iterator[str]:
        """Lines, stiffness, offsets and broken lines as tables."""
        yield f"{self.title}: {len(self.lines)} lines in static equilibrium"
        yield from (f"  {note}" for note in self.notes)
        head = ("line", "length", "on bed", "layback", "tension from", "to", "largest",
                "angle from", "to", "safety factor")  # fmt: skip
        units = ("", "[m]", "[m]", "[m]", "[kN]", "[kN]", "[kN]", "[deg]", "[deg]", "[1]")
        rows = [
            (line.name, *map(_short, (line.length, line.on_bed, line.layback, *line.tensions / 1e3,
             line.largest / 1e3, *np.degrees(line.angles), line.strength / line.largest)))
            for line in self.lines
        ]  # fmt: skip
        yield from ("", *columns("<>>>>>>>>>", head, units, *rows), "")
        x, y, z = map(_short, self.about)
        yield f"force and stiffness about ({x}, {y}, {z}) m [N, N.m; N/m, N/rad, N.m/rad]"
        names = ("", "force", "surge", "sway", "heave", "roll", "pitch", "yaw")
        diagonal = np.sqrt(np.abs(self.stiffness.diagonal()))
        clean = np.where(
            np.abs(self.stiffness) < 1e-9 * np.outer(diagonal, diagonal), 0.0, self.stiffness
        )
        force = np.where(np.abs(self.force) < 1e-9 * np.abs(self.force).max(), 0.0, self.force)
        matrix = [
            (name, f"{f:.5g}", *(f"{x + 0.0:.5g}" for x in row))
            for name, f, row in zip(names[2:], force, clean, strict=True)
        ]
        yield from (*columns("<>>>>>>>", names, *matrix), "")
        offsets: list[Sequence[str]] = [
            ("offset towards", "up to", "pull back", "largest tension", "safety factor", "")
        ]
        offsets += [("[deg]", "[m]", "[kN]", "[kN]", "[1]", "")]
        for curve in self.curves:
            factor, name = self.safety(curve.tensions[-1])
            angle, reach = np.degrees(curve.direction), curve.offsets[-1]
            last = (angle, reach, curve.pull[-1] / 1e3, curve.tensions[-1].max() / 1e3, factor)
            offsets.append((*map(_short, last), f"{name}: {curve.limit}"))
        yield from columns(">>>>><", *offsets)
        if self.broken:
            left: list[Sequence[str]] = [
                ("broken", "drift x", "y", "largest tension", "safety factor", "of line")
            ]
            left += [("", "[m]", "[m]", "[kN]", "[1]", "")]
            for one in self.broken:
                factor, name = self.safety(one.tensions)
                values = (*one.drift, one.tensions.max() / 1e3, factor)
                left.append((one.name, *map(_short, values), name))
            yield from ("", *columns("<>>>><", *left))
        held = {one.name for one in self.broken}
        if lost := [line.name for line in self.lines if line.name not in held]:
            yield f"nothing holds the fairleads sideways without {' or '.join(lost)}"


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value


def _short(value: float) -> str:
    return "-" if np.isnan(value) else f"{round(value, 9) + 0.0:.4g}"
