"""A scene: what an animation of results shows, with names of variables where something moves.

Results carry it as the attribute `scene`, so that they can be animated without models, meshes or
FMUs: JSON, compressed. Lengths in m, angles in rad, world frame; places of bodies in their axes.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.report.drawing.space.hinges import Spot, Triple
from m4e_fmi.report.drawing.space.hulls import Hull

ATTRIBUTE = "scene"
FORMAT = 1
COORDINATES = ("x", "y", "z", "phi", "theta", "psi")
"""Of a body: place [m], and R = R_z(psi) R_y(theta) R_x(phi) [rad] from body to world axes."""
DIGITS = 6
"""Significant digits of places."""


@dataclass(frozen=True)
class Followed:
    """`factor` times the variable ``component.name``, plus `offset`."""

    variable: str
    factor: float = 1.0
    offset: float = 0.0


Value = float | Followed
Place = tuple[Value, Value, Value]
"""x, y, z [m]."""


@dataclass(frozen=True)
class Body:
    """A rigid body: its surfaces, lines from its origin to `sticks` [m], and its motion.

    The motion has the coordinates of `COORDINATES`, in their order.
    """

    name: str
    motion: tuple[Value, ...]
    surfaces: tuple[Hull, ...] = ()
    sticks: tuple[Triple, ...] = ()


@dataclass(frozen=True)
class Rope:
    """A load on the line between two points; `rank` puts several aside."""

    kind: str
    ends: tuple[Spot, Spot]
    rank: float = 0.0


@dataclass(frozen=True)
class Cable:
    """A line through `nodes`, from end to end; through its `ends` if these were not recorded.

    `tensions` are variables that are all 0 once it has parted, if it can.
    """

    name: str
    ends: tuple[Place, Place]
    nodes: tuple[Place, ...] = ()
    tensions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Train:
    """Airy waves that grow with one `ramp` [s]: ½(1 − cos π t/T) until t = T, then 1; 0: none.

    The elevation is ramp Σ a cos(ω t + φ − k (x cos β + y sin β)): `omega` [rad/s], `number` k
    [rad/m], `amplitude` [m], `phase` [rad] and `direction` [rad], all (n,).
    """

    omega: np.ndarray = field(repr=False)
    number: np.ndarray = field(repr=False)
    amplitude: np.ndarray = field(repr=False)
    phase: np.ndarray = field(repr=False)
    direction: np.ndarray = field(repr=False)
    ramp: float = 0.0

    @property
    def columns(self) -> tuple[np.ndarray, ...]:
        """Those five, (n,) each, in the units above."""
        return self.omega, self.number, self.amplitude, self.phase, self.direction

    def elevation(self, x: float, y: float, time: np.ndarray) -> np.ndarray:
        """Height of the water [m] at x, y [m] and `time` (T,) [s], (T,)."""
        way = self.phase - self.number * (x * np.cos(self.direction) + y * np.sin(self.direction))
        height = np.cos(np.multiply.outer(time, self.omega) + way) @ self.amplitude
        if not self.ramp:
            return height
        return height * (0.5 - 0.5 * np.cos(np.pi * np.minimum(time / self.ramp, 1.0)))


@dataclass(frozen=True)
class Water:
    """Water with its still surface at z = 0, of a `depth` [m]; `trains` are the waves in it.

    `gauge` is the variable that has the elevation at x = y = 0, "" if none has.
    """

    depth: float
    trains: tuple[Train, ...] = ()
    gauge: str = ""

    def elevation(self, x: float, y: float, time: np.ndarray) -> np.ndarray:
        """Height [m] at x, y [m] and `time` (T,) [s], (T,)."""
        found = [train.elevation(x, y, time) for train in self.trains]
        return np.sum(found, axis=0) if found else np.zeros(len(time))


@dataclass(frozen=True)
class Scene:
    """All that is shown of a system; `planar` ones are seen from the side.

    `hinges` are points of joints, with True for welds; `axes` their lines, with True for those
    about which they turn. `floor` [m] is z of the bed, where there is one. `notes` tell what is
    not shown.
    """

    title: str
    description: str
    planar: bool
    bodies: tuple[Body, ...]
    hinges: tuple[tuple[Spot, bool], ...] = ()
    axes: tuple[tuple[Spot, Spot, bool], ...] = ()
    ropes: tuple[Rope, ...] = ()
    cables: tuple[Cable, ...] = ()
    water: Water | None = None
    floor: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[str, ...]:
        """All variables that an animation follows."""
        values = chain(
            *(body.motion for body in self.bodies),
            *(place for cable in self.cables for place in (*cable.ends, *cable.nodes)),
        )
        names = [value.variable for value in values if isinstance(value, Followed)]
        names += [name for cable in self.cables for name in cable.tensions]
        return tuple(dict.fromkeys(names))

    def to_text(self) -> str:
        """The text of the attribute."""
        return _packed({"format": FORMAT, **_plain_scene(self)})

    @classmethod
    def from_text(cls, text: str) -> Scene:
        """The scene of an attribute; InputError if it is damaged or of a newer format."""
        try:
            data = json.loads(zlib.decompress(base64.b64decode(text, validate=True)))
            if data["format"] > FORMAT:
                message = f"the scene is of format {data['format']}, known are those up to {FORMAT}"
                raise InputError.single(message, "update m4e_fmi")
            return _scene(data)
        except (ValueError, LookupError, TypeError, zlib.error) as error:
            raise InputError.single("the scene in it is damaged", "run again") from error


def carried(scene: Scene | None) -> dict[str, str]:
    """The attributes by which results carry a scene."""
    return {ATTRIBUTE: scene.to_text()} if scene else {}


def _packed(data: Mapping[str, object]) -> str:
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=False)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode("ascii")


def short(numbers: Iterable[float], digits: int = DIGITS) -> list[float]:
    """Numbers with so many significant digits."""
    return [float(f"{number:.{digits}g}") for number in numbers]


def _plain_scene(scene: Scene) -> dict[str, Any]:
    return {
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
        "hinges": [[*_spot(spot), weld] for spot, weld in scene.hinges],
        "axes": [[_spot(first), _spot(second), turns] for first, second, turns in scene.axes],
        "ropes": [[rope.kind, *map(_spot, rope.ends), rope.rank] for rope in scene.ropes],
        "cables": [
            {
                "name": cable.name,
                "ends": [_plain(end) for end in cable.ends],
                "nodes": [_plain(node) for node in cable.nodes],
                "tensions": list(cable.tensions),
            }
            for cable in scene.cables
        ],
        "water": scene.water and {
            "depth": None if np.isinf(scene.water.depth) else scene.water.depth,
            "trains": [
                {"ramp": train.ramp, "waves": [short(column, 10) for column in train.columns]}
                for train in scene.water.trains
            ],
            "gauge": scene.water.gauge,
        },
        "floor": scene.floor,
        "notes": list(scene.notes),
    }  # fmt: skip


def plain_hull(hull: Hull) -> dict[str, Any]:
    """A surface as JSON values."""
    return {
        "vertices": [short(corner, 5) for corner in hull.vertices],
        "faces": [list(face) for face in hull.faces],
        "edged": hull.edged,
    }


def _plain(values: Iterable[Value]) -> list[object]:
    return [
        value if not isinstance(value, Followed)
        else value.variable if (value.factor, value.offset) == (1.0, 0.0)
        else [value.variable, value.factor, value.offset]
        for value in values
    ]  # fmt: skip


def _spot(spot: Spot) -> list[float]:
    return [spot.body, *short(spot.at)]


def _scene(data: Mapping[str, Any]) -> Scene:
    return Scene(
        title=data["title"],
        description=data["description"],
        planar=data["planar"],
        bodies=tuple(map(_body, data["bodies"])),
        hinges=tuple((_read_spot(spot), weld) for *spot, weld in data["hinges"]),
        axes=tuple((_read_spot(a), _read_spot(b), turns) for a, b, turns in data["axes"]),
        ropes=tuple(
            Rope(kind, (_read_spot(a), _read_spot(b)), rank) for kind, a, b, rank in data["ropes"]
        ),
        cables=tuple(map(_cable, data["cables"])),
        water=data["water"] and _water(data["water"]),
        floor=data["floor"],
        notes=tuple(data["notes"]),
    )


def _body(data: Mapping[str, Any]) -> Body:
    surfaces = (
        Hull(np.array(one["vertices"]), tuple(map(tuple, one["faces"])), one["edged"])
        for one in data["surfaces"]
    )
    sticks = (tuple(end) for end in data["sticks"])
    return Body(data["name"], tuple(_values(data["motion"])), tuple(surfaces), tuple(sticks))


def _cable(data: Mapping[str, Any]) -> Cable:
    start, end = map(_place, data["ends"])
    nodes = tuple(map(_place, data["nodes"]))
    return Cable(data["name"], (start, end), nodes, tuple(data["tensions"]))


def _water(data: Mapping[str, Any]) -> Water:
    trains = (Train(*map(np.array, one["waves"]), ramp=one["ramp"]) for one in data["trains"])
    depth = np.inf if data["depth"] is None else data["depth"]
    return Water(depth, tuple(trains), data["gauge"])


def _values(data: Iterable[Any]) -> Iterator[Value]:
    for one in data:
        if isinstance(one, str):
            yield Followed(one)
        else:
            yield Followed(*one) if isinstance(one, list) else one


def _place(data: Iterable[Any]) -> Place:
    x, y, z = _values(data)
    return x, y, z


def _read_spot(data: list[float]) -> Spot:
    body, x, y, z = data
    return Spot(int(body), (x, y, z))
