"""Bodies and water of a configuration, and those of its file of coefficients."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficient_files.file_data import (
    KEYS,
    FileBody,
    FileData,
    Point,
)
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.geometry.motions import point_in_space
from m4e_fmi.errors import Problem

SAME_WATER = 1e-3  # relative difference of water properties that is none


@dataclass(frozen=True)
class MatchedBody:
    """A body of the configuration: `number` k in the file, points (x, y, z) [m], `volume` [m3].

    `weight_at` is where the weight acts in the stiffness of the file.
    """

    name: str
    number: int
    of_file: FileBody
    center: Point
    reference: Point
    weight_at: Point
    volume: float

    @property
    def arm(self) -> np.ndarray:
        """From the centre of gravity to the reference point, (3,) [m]."""
        return np.subtract(self.reference, self.center)

    @property
    def stiffness(self) -> np.ndarray:
        """K/(ρg), (6, 6) [m2, m3, m4], of the file, with the weight at the centre of gravity."""
        found = self.of_file.stiffness.copy()
        x, y, z = (self.volume * np.subtract(self.center, self.weight_at)).tolist()
        found[[3, 4, 3, 4], [3, 4, 5, 5]] += -z, -z, x, y
        return found


def matched_bodies(
    config: HydrodynamicsConfig, data: FileData, problems: list[Problem]
) -> list[MatchedBody]:
    """The bodies of the configuration, in its order; what is wrong joins the `problems`."""
    numbers = _numbers(list(config.bodies), [body.name for body in data.bodies], problems)
    found = []
    for name, number in numbers.items():
        wrong: list[Problem] = []
        body = _matched(config, name, number, data.bodies[number], wrong)
        problems += wrong
        if body is not None:
            found.append(body)
    return found


def _numbers(wanted: list[str], there: list[str], problems: list[Problem]) -> dict[str, int]:
    """The body in the file of each of those `wanted`: by name, or all by order."""
    places = {name.lower(): k for k, name in enumerate(there)}
    numbered = {f"body{k + 1}": k for k in range(len(there))}
    by_name = {name: places.get(name.lower(), numbered.get(name.lower())) for name in wanted}
    known = {name: k for name, k in by_name.items() if k is not None}
    if len(known) == len(wanted) and len(set(known.values())) == len(known):
        return known
    if not known and len(wanted) == len(there):
        return {name: k for k, name in enumerate(wanted)}
    shown = ", ".join(repr(name) for name in there)
    text = f"the file has {len(there)} {'body' if len(there) == 1 else 'bodies'} ({shown}), here "
    text += f"are {len(wanted)}: {', '.join(map(repr, wanted))}"
    remedy = (
        "give as many, in the order of the file, or call them as in the file (or body1, body2, …): "
        "then some may be left out, which are held in place"
    )
    problems.append(Problem(text, remedy, keys=("bodies",)))
    return {}


def _matched(
    config: HydrodynamicsConfig,
    name: str,
    number: int,
    of_file: FileBody,
    problems: list[Problem],
) -> MatchedBody | None:
    body = config.bodies[name]
    keys = ("bodies", name)
    center = point_in_space(body.center_of_gravity) if body.center_of_gravity else None
    if center is None and of_file.center_of_gravity is None:
        text = f"body {name!r}: the file has no centre of gravity"
        remedy = f"write center_of_gravity: {'[x, z]' if config.dimensions == 2 else '[x, y, z]'}"
        problems.append(Problem(text, remedy, keys=keys))
    center = center or of_file.center_of_gravity
    reference = point_in_space(body.reference_point) if body.reference_point else None
    if reference is not None and of_file.reference is not None:
        x, y, z = of_file.reference
        text = f"body {name!r}: the motions of the file are about ({x:g}, {y:g}, {z:g}) m"
        problems.append(Problem(text, "remove it", keys=(*keys, "reference_point")))
    volume = body.volume
    if volume is None and of_file.volume is None:
        text = f"body {name!r}: the file does not have the displaced volume"
        problems.append(Problem(text, "write volume: … [m3]", keys=keys))
    elif volume is not None and of_file.volume is not None:
        text = f"body {name!r}: the volume of the file is {of_file.volume:.6g} m3"
        problems.append(Problem(text, "remove it", keys=(*keys, "volume")))
    volume = of_file.volume or volume
    if volume is not None and volume <= 0:
        text = f"body {name!r}: the displaced volume of the file is {volume:g} m3"
        problems.append(Problem(text, "it must be positive: compute it anew", keys=KEYS))
    if problems or center is None or volume is None:
        return None
    reference = of_file.reference or reference or center
    given = point_in_space(body.weight_at) if body.weight_at else None
    weight_at = given or of_file.center_of_gravity or center
    return MatchedBody(name, number, of_file, center, reference, weight_at, volume)


def matched_water(config: HydrodynamicsConfig, data: FileData, problems: list[Problem]) -> Water:
    """The water of the file where it has one; a different one that is given is a problem."""
    given, own = config.water, {}
    for key, unit in (("density", "kg/m3"), ("depth", "m"), ("gravity", "m/s2")):
        there, here = getattr(data, key), getattr(given, key)
        if there is None:
            continue
        if not (there > 0):
            text = f"{key} of the file is {there:g} {unit}"
            problems.append(Problem(text, "write the file anew", keys=KEYS))
            continue
        own[key] = there
        same = there == here or abs(there - here) <= SAME_WATER * min(abs(there), abs(here))
        if key in given.model_fields_set and not same:
            text = f"{key} is {_shown(here)} {unit} here, the file is for {_shown(there)} {unit}"
            remedy = f"write {_shown(there)}, or leave it out; or compute the file anew"
            problems.append(Problem(text, remedy, keys=("water", key)))
    return given.model_copy(update=own)


def _shown(value: float) -> str:
    return "deep" if math.isinf(value) else f"{value:.6g}"


def told_bodies(
    bodies: Sequence[MatchedBody], config: HydrodynamicsConfig, data: FileData
) -> list[str]:
    """Lines on each body and its values' sources, and on bodies that are left out."""
    sources = {True: "(system file)", False: "(file)"}
    lines = []
    for body in bodies:
        given, own = config.bodies[body.name], body.of_file
        about = "(assumed)"  # if neither has the point
        if own.reference is not None or given.reference_point is not None:
            about = sources[own.reference is None]
        weight = sources[given.weight_at is not None]
        if given.weight_at is None and own.center_of_gravity is None:
            weight = "(assumed; if the file is of another one, write weight_at)"
        lines.append(
            f"body {body.name!r} is {own.name!r} of the file, number {body.number + 1}: centre of "
            f"gravity {_place(body.center)} {sources[bool(given.center_of_gravity)]}, displaces "
            f"{body.volume:.6g} m3 {sources[own.volume is None]}, motions of the file about "
            f"{_place(body.reference)} {about}, its hydrostatic stiffness with the weight at "
            f"{_place(body.weight_at)} {weight}"
        )
        if own.missing:
            motions = ", ".join(own.missing)
            lines.append(f"warning: the file has no {motions} of {own.name!r}: they feel no water")
    left = {body.name for body in data.bodies} - {body.of_file.name for body in bodies}
    if left:
        names = ", ".join(sorted(left))
        lines.append(f"bodies of the file that are not named here are held in place: {names}")
    return lines


def _place(point: Point) -> str:
    return "({:.6g}, {:.6g}, {:.6g}) m".format(*point)
