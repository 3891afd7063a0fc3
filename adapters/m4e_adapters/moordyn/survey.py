"""A mooring in static equilibrium, for a report: stiffness, offsets, and broken lines."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

import numpy as np

from m4e_adapters.moordyn.mooring import Mooring, NetData
from m4e_adapters.moordyn.rest import lying
from m4e_adapters.moordyn.resting import LinesAtRest, Resting, tensions
from m4e_fmi.analysis.mooring_data import BrokenLine, LineData, MooringData, OffsetCurve
from m4e_fmi.errors import RunError, UnknownNameError

POINTS = 25
"""Of a curve of offsets."""
STRAIN = 0.02
"""Of lines that are taut at the start, at the end of a curve."""
ITERATIONS, LONGEST_MOVE = 200, 0.05
"""Of the search without a line; longest move in one, over the length of the longest line."""
BALANCED = 1e-6
"""Force that may be left then, over the largest tension."""


def survey(
    mooring: Mooring,
    places: np.ndarray,
    *,
    title: str,
    about: Sequence[float] | None,
    directions: Sequence[float],
    moved: Sequence[str],
) -> MooringData:
    """The mooring with its fairleads at `places` (f, 3) [m], of which those named in `moved` move.

    `about` [m] is the mean of these if it is None; `directions` [rad] of offsets, from X to Y.
    InputError for names of no fairleads, RunError if no equilibrium is found.
    """
    names = [fairlead.name for fairlead in mooring.fairleads]
    if unknown := [name for name in moved if name not in names]:
        raise UnknownNameError.of(f"{title} has no fairlead", unknown, names)
    which = [k for k, name in enumerate(names) if not moved or name in moved]
    net = mooring.net and _holding(mooring.net, places, which)
    places = places[which]
    found = LinesAtRest(net).at(places) if net and names else None
    if net is None or found is None:
        message = f"{title}: no static equilibrium of its lines is found by itself"
        remedy = "run it, if it has rods, bodies, an uneven seabed or lines on the surface"
        raise RunError(message, remedy)
    point = places.mean(axis=0) if about is None else np.array(about, dtype=float)
    force, stiffness = _about(found, places - point)
    strength = np.array([mooring.strengths.get(name, np.nan) for name in mooring.lines])
    rows = zip(mooring.lines, found.net.lines, found.nodes, found.ends, strict=True)
    largest = _largest(found)
    lines = tuple(
        LineData(
            name,
            line["length"],
            lying((nodes[:, 2] - net["bed"]).tolist(), line["length"]),
            nodes,
            np.linalg.norm(ends, axis=1),
            _angles(nodes, ends, net["bed"]),
            float(largest[k]),
            float(strength[k]),
        )
        for k, (name, line, nodes, ends) in enumerate(rows)
    )
    return MooringData(
        title,
        lines,
        point,
        force,
        stiffness,
        tuple(_curve(net, places, angle, strength) for angle in directions),
        tuple(
            b for k in range(len(lines)) if (b := _without(net, k, places, found, lines[k].name))
        ),
        float(net["bed"]),
        mooring.notes,
    )


def _holding(net: NetData, places: np.ndarray, moved: Sequence[int]) -> NetData:
    """The net with its fairleads at `places` (f, 3) [m], but for those `moved` held there."""
    points = [dict(point) for point in net["points"]]
    for k, place in zip(net["fairleads"], places.tolist(), strict=True):
        points[k]["position"] = place
    return {**net, "points": points, "fairleads": [net["fairleads"][k] for k in moved]}


def _angles(nodes: np.ndarray, ends: np.ndarray, bed: float) -> np.ndarray:
    """Angles (2,) [rad] of a line to the horizontal, positive where B is higher; on the bed 0.

    Forces at the ends `ends` (2, 3) [N] contain half a segment, which the bed carries there.
    """
    found = np.arctan2(ends[:, 2] * (1, -1), np.hypot(ends[:, 0], ends[:, 1]))
    lies = (nodes[[0, -1], 2] <= bed) & (nodes[[1, -2], 2] <= bed)
    return np.where(lies, 0.0, found)


def _largest(found: Resting) -> np.ndarray:
    """The largest tension (lines,) [N] along each line."""
    rows = zip(found.net.lines, found.nodes, found.ends, strict=True)
    forces = (np.vstack([tensions(line, nodes), ends]) for line, nodes, ends in rows)
    return np.array([np.linalg.norm(force, axis=1).max() for force in forces])


def _about(found: Resting, arms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Force (6,) and stiffness (6, 6) of fairleads on a rigid body with `arms` (f, 3) [m]."""
    turns = [np.cross(np.eye(3), arm).T for arm in arms]  # of an arm by turns about X, Y, Z
    moves = np.hstack([np.vstack([np.eye(3)] * len(arms)), np.vstack(turns)])
    slopes = moves.T @ found.force_slopes.reshape(len(moves), -1) @ moves
    for force, turn in zip(found.force, turns, strict=True):
        slopes[3:, 3:] += np.cross(turn.T, force).T
    return found.force.reshape(-1) @ moves, -slopes


def _curve(net: NetData, places: np.ndarray, angle: float, strength: np.ndarray) -> OffsetCurve:
    """Offsets of fairleads until a line is as strong as it is, or taut."""
    way, lines = np.array([np.cos(angle), np.sin(angle), 0.0]), LinesAtRest(net)
    rows: list[tuple[float, float, np.ndarray]] = []
    limit = "taut"
    for offset in np.linspace(0.0, _reach(net, places, way), POINTS):
        if (found := lines.at(places + offset * way)) is None:
            limit = "no equilibrium beyond"
            break
        rows.append((float(offset), float(-found.force.sum(axis=0) @ way), _largest(found)))
        if (rows[-1][2] > strength).any():
            limit = "at its strength"
            break
    offsets, pull, tensions = (np.array(column) for column in zip(*rows, strict=True))
    return OffsetCurve(angle, offsets, pull, tensions, limit)


def _reach(net: NetData, places: np.ndarray, way: np.ndarray) -> float:
    """The offset [m] at which the first line between a fairlead and an anchor is straight."""
    moved = dict(zip(net["fairleads"], places, strict=True))
    found = [-net["bed"]]
    for line in net["lines"]:
        a, b = line["ends"]
        anchor, fairlead = (b, a) if a in moved else (a, b)
        if fairlead in moved and anchor not in moved and net["points"][anchor]["force"] is None:
            span = moved[fairlead] - net["points"][anchor]["position"]
            along, chord = float(span @ way), float(np.linalg.norm(span))
            longest = max(line["length"], (1.0 + STRAIN) * chord)
            found.append(sqrt(along**2 + longest**2 - chord**2) - along)
    return min(found[1:], default=found[0])


def _without(
    net: NetData, broken: int, places: np.ndarray, before: Resting, name: str
) -> BrokenLine | None:
    """The equilibrium without a line; None if there is none, or no line is left."""
    left = [k for k in range(len(net["lines"])) if k != broken]
    lines = LinesAtRest({**net, "lines": [net["lines"][k] for k in left]})
    longest = LONGEST_MOVE * max(line["length"] for line in net["lines"])
    wanted, share = before.force.sum(axis=0)[:2], BALANCED * _largest(before).max()
    drift, damping, held = np.zeros(2), 0.0, lines.at(places) if left else None
    for _ in range(ITERATIONS):
        if held is None:
            return None
        force = held.force.sum(axis=0)[:2] - wanted
        if np.linalg.norm(force) <= share:
            return BrokenLine(name, drift, np.insert(_largest(held), broken, 0.0))
        slopes = held.force_slopes.reshape(*held.force.shape, -1, 3).sum(axis=(0, 2))[:2, :2]
        if not slopes.any():
            return None
        damping = max(damping, 1e-6 * abs(np.trace(slopes)))
        step = np.linalg.solve(damping * np.eye(2) - slopes, force)
        step *= min(1.0, longest / np.linalg.norm(step))
        ahead = lines.at(places + np.append(drift + step, 0.0))
        if ahead is not None and np.hypot(*ahead.force.sum(axis=0)[:2] - wanted) < np.hypot(*force):
            drift, held, damping = drift + step, ahead, damping / 4.0
        else:
            damping = 4.0 * max(damping, 1e-3 * abs(np.trace(slopes)))
    return None
