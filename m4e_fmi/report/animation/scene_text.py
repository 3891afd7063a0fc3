"""Scenes as text, which results carry as the attribute `scene`: compressed JSON.

They can be animated from it without models, meshes or FMUs.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.files.limits import LARGEST_SCENE, MB
from m4e_fmi.report.animation.scene import (
    Body,
    Cable,
    Followed,
    Place,
    Rope,
    Scene,
    Spot,
    Train,
    Triple,
    Value,
    Water,
)
from m4e_fmi.report.drawing.hulls import Hull
from m4e_fmi.results.series import SCENE

FORMAT = 1
PLACES, WAVES, CORNERS = 6, 10, 5
"""Significant digits of places, of waves, and of the corners of surfaces."""

Plain = Any
"""Values of JSON: a spot is the number of a body, −1 for the ground, and x, y, z [m]."""

_DAMAGED = (
    ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError, zlib.error
)  # fmt: skip


def carried(scene: Scene | None) -> dict[str, str]:
    """The attributes by which results carry a scene."""
    if scene is None:
        return {}
    water = scene.water
    data = {
        "format": FORMAT,
        "title": scene.title,
        "description": scene.description,
        "planar": scene.planar,
        "bodies": [
            {
                "name": body.name,
                "motion": _plain(body.motion),
                "surfaces": [plain_hull(hull) for hull in body.surfaces],
                "sticks": [short(end) for end in body.sticks],
            }
            for body in scene.bodies
        ],
        "hinges": [(plain_spot(spot), weld) for spot, weld in scene.hinges],
        "axes": [(plain_spot(a), plain_spot(b), turns) for a, b, turns in scene.axes],
        "ropes": [
            (rope.kind, plain_spot(rope.ends[0]), plain_spot(rope.ends[1]), rope.rank)
            for rope in scene.ropes
        ],
        "cables": [
            {
                "name": cable.name,
                "ends": [_plain(end) for end in cable.ends],
                "nodes": [_plain(node) for node in cable.nodes],
            }
            for cable in scene.cables
        ],
        "water": {
            "depth": None if np.isinf(water.depth) else water.depth,
            "trains": [
                {"ramp": train.ramp, "waves": [short(column, WAVES) for column in train.columns]}
                for train in water.trains
            ],
            "gauge": water.gauge,
            "density": water.density,
        }
        if water
        else None,
        "floor": scene.floor,
        "notes": list(scene.notes),
    }
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return {SCENE: base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")}


def scene_of_text(text: str) -> Scene:
    """The scene of an attribute; InputError if it is damaged or of a newer format."""
    try:
        data = json.loads(_unpacked(text), parse_float=_finite, parse_constant=_finite)
        if data["format"] > FORMAT:
            message = f"its scene is of format {data['format']}, known are those up to {FORMAT}"
            raise InputError.single(message, "update m4e_fmi")
        return _scene(data)
    except _DAMAGED as error:
        raise InputError.single("its scene is damaged", "run again") from error


def _unpacked(text: str) -> bytes:
    """The JSON of an attribute; InputError if there is more of it than LARGEST_SCENE."""
    stream = zlib.decompressobj()
    found = stream.decompress(base64.b64decode(text, validate=True), LARGEST_SCENE + 1)
    if len(found) > LARGEST_SCENE:
        message = f"its scene has more than {LARGEST_SCENE // MB} MB when unpacked"
        raise InputError.single(message, "animate results of meshes with fewer triangles")
    if not stream.eof:
        raise ValueError("ends early")
    return found


def _finite(text: str) -> float:
    """A number as written; InputError for NaN and infinity, and for what is beyond them."""
    number = float(text)
    if not math.isfinite(number):
        message = f"its scene has the number {text[:20]}, which is not finite"
        raise InputError.single(message, "look for it in what is shown: meshes, places, parameters")
    return number


def short(numbers: Iterable[float], digits: int = PLACES) -> list[float]:
    """Numbers with so many significant digits."""
    return [float(f"{number:.{digits}g}") for number in numbers]


def plain_hull(hull: Hull) -> Plain:
    """A surface in values of JSON."""
    return {
        "vertices": [short(corner, CORNERS) for corner in hull.vertices],
        "faces": [list(face) for face in hull.faces],
        "edged": hull.edged,
    }


def plain_spot(spot: Spot) -> Plain:
    """A point of a body in values of JSON."""
    return [spot.body, *short(spot.at)]


def _plain(values: Iterable[Value]) -> list[Plain]:
    found: list[Plain] = []
    for value in values:
        if not isinstance(value, Followed):
            found.append(value)
        elif value == Followed(value.variable):
            found.append(value.variable)
        else:
            found.append((value.variable, value.factor, value.offset))
    return found


def _scene(data: Plain) -> Scene:
    return Scene(
        title=data["title"],
        description=data["description"],
        planar=data["planar"],
        bodies=tuple(map(_body, data["bodies"])),
        hinges=tuple((_spot(spot), weld) for spot, weld in data["hinges"]),
        axes=tuple((_spot(a), _spot(b), turns) for a, b, turns in data["axes"]),
        ropes=tuple(Rope(kind, (_spot(a), _spot(b)), rank) for kind, a, b, rank in data["ropes"]),
        cables=tuple(map(_cable, data["cables"])),
        water=data["water"] and _water(data["water"]),
        floor=data["floor"],
        notes=tuple(data["notes"]),
    )


def _body(data: Plain) -> Body:
    surfaces = (
        Hull(np.array(one["vertices"]), tuple(map(tuple, one["faces"])), one["edged"])
        for one in data["surfaces"]
    )
    sticks = (_triple(end) for end in data["sticks"])
    return Body(data["name"], tuple(_values(data["motion"])), tuple(surfaces), tuple(sticks))


def _cable(data: Plain) -> Cable:
    start, end = map(_place, data["ends"])
    nodes = tuple(map(_place, data["nodes"]))
    return Cable(data["name"], (start, end), nodes)


def _water(data: Plain) -> Water:
    trains = (Train(*map(np.array, one["waves"]), ramp=one["ramp"]) for one in data["trains"])
    depth = np.inf if data["depth"] is None else data["depth"]
    return Water(depth, tuple(trains), data["gauge"], data.get("density", 0.0))


def _values(data: Iterable[Plain]) -> Iterator[Value]:
    for one in data:
        if isinstance(one, str):
            yield Followed(one)
        else:
            yield float(one) if isinstance(one, float | int) else Followed(*one)


def _place(data: Iterable[Plain]) -> Place:
    x, y, z = _values(data)
    return x, y, z


def _spot(data: Plain) -> Spot:
    return Spot(int(data[0]), _triple(data[1:]))


def _triple(data: Sequence[float]) -> Triple:
    x, y, z = data
    return x, y, z
