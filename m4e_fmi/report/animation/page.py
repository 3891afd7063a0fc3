"""Pages of animations: the scene and its frames as data, with the parts that draw them."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.report.animation.frames import PER_BODY, Frames, packed
from m4e_fmi.report.animation.scene import Scene, Water
from m4e_fmi.report.animation.scene_text import plain_hull, plain_spot, short
from m4e_fmi.report.drawing.views import RISE, SIDE, TURN, colour, extent
from m4e_fmi.report.web.markup import filled, json_text, text_of

Floats = NDArray[np.float64]
HERE = "m4e_fmi.report.animation"
LONGEST = 20.0
"""Seconds that an animation takes; a longer simulation is shown faster."""
SIDE_RISE = 0.12
"""How far the eye is above the still water of a planar scene [rad]."""
REACH, ACROSS = 1.7, 0.6
"""Half sides of the water shown over the radius of what is near; the second in the plane."""
FARTHER = 1.3
"""Size of all over that of what is near, from which there is a choice between them."""
CELLS, CELLS_IN_PLANE = (40, 40), (64, 12)
"""Pieces of the water along X and Y."""
WAVE_SHARE = 1e-5
"""Share of a sea's energy in its smallest waves that are left out: 0.3 % of its height."""


@dataclass(frozen=True)
class Part:
    """An animation for any page: put `style` into a style element, `markup` into the body.

    The `script` defines ``animation(root, data, keys)``, to be called with the element, `data` and
    what hears the keys. See player.js for what it returns.
    """

    style: str
    markup: str
    script: str
    data: str


def part(data: dict[str, object]) -> Part:
    """The part for `data`."""
    names = ("part.css", "part.html", "player.js")
    style, markup, player = (text_of(HERE, name) for name in names)
    return Part(
        style=style.rstrip(),
        markup=markup.rstrip(),
        script=player.rstrip(),
        data=json_text(data),
    )


def page(title: str, texts: Sequence[str], shown: Part) -> str:
    """A page with nothing but an animation, and `texts` above it."""
    marks = {
        "@title@": html.escape(title),
        "@texts@": "\n  ".join(f"<p>{html.escape(text)}</p>" for text in texts if text),
        "@style@": shown.style,
        "@markup@": shown.markup,
        "@script@": shown.script,
        '"@data@"': shown.data,
    }
    return filled(text_of(HERE, "page.html"), marks)


def scene_part(scene: Scene, shown: Frames) -> Part:
    """The part of a scene, whose frames are `shown`."""
    near = extent(scene, shown.poses, shown.cables)
    fixed = [spot.at for rope in scene.ropes for spot in rope.ends if spot.body < 0]
    seen = [near, *(nodes.reshape(-1, 3) for nodes in shown.cables), np.reshape(fixed, (-1, 3))]
    everything = np.concatenate(seen)
    far = np.array([everything.min(axis=0), everything.max(axis=0)])  # with cables, fixed points
    start, stop = float(shown.times[0]), float(shown.times[-1])
    columns = shown.columns()
    is_far = np.ptp(far, axis=0).max() > FARTHER * np.ptp(near, axis=0).max()
    data: dict[str, object] = {
        "start": start,
        "stop": stop,
        "speed": max(1.0, round((stop - start) / LONGEST)),
        **packed(columns),
        "numbers": PER_BODY,
        "turn": SIDE if scene.planar else float(TURN),
        "rise": (SIDE_RISE if scene.water else 0.0) if scene.planar else float(RISE),
        "near": near.tolist(),
        "far": far.tolist() if is_far else None,
        "ground": _ground(scene, near, far),
        "bodies": _bodies(scene),
        "ropes": [
            {"kind": rope.kind, "ends": list(map(plain_spot, rope.ends)), "rank": rope.rank}
            for rope in scene.ropes
        ],
        "hinges": [[*plain_spot(spot), weld] for spot, weld in scene.hinges],
        "lines": [[plain_spot(a), plain_spot(b), turns] for a, b, turns in scene.axes],
        "cables": _cables(scene, shown),
        "water": scene.water and _water(scene.water, near, far, scene.planar),
    }  # fmt: skip
    return part(data)


def _bodies(scene: Scene) -> list[dict[str, object]]:
    seen = [k for k, body in enumerate(scene.bodies) if body.surfaces or body.sticks]
    return [
        {
            "name": f"{seen.index(k) + 1} {body.name}" if k in seen else "",
            "colour": colour(seen.index(k) if k in seen else 0),
            "surfaces": [plain_hull(hull) for hull in body.surfaces],
            "sticks": [short(end) for end in body.sticks],
        }
        for k, body in enumerate(scene.bodies)
    ]


def _cables(scene: Scene, shown: Frames) -> list[dict[str, object]]:
    """Each cable with the columns of its places."""
    first = PER_BODY * len(scene.bodies)
    found = list[dict[str, object]]()
    for nodes, exact in zip(shown.cables, shown.exact, strict=True):
        found.append({"first": first, "count": nodes.shape[1], "exact": exact})
        first += 3 * nodes.shape[1]
    return found


def _ground(scene: Scene, near: Floats, far: Floats) -> list[list[float]] | None:
    """Corners of the bed, or without water of the ground; None if it is far below all."""
    if scene.water is None and scene.floor is None:
        z = 0.0 if near[0, 2] <= 0.0 <= near[1, 2] else float(near[0, 2])
        middle, half = near.mean(axis=0), np.linalg.norm(near[1] - near[0]) / 2
        low, high = middle - half, middle + half
    else:
        if scene.floor is None:
            return None
        z = scene.floor
        reach = max(0.1 * np.ptp(far, axis=0).max(), np.linalg.norm(near[1] - near[0]) / 2)
        low, high = far[0] - reach, far[1] + reach
    return [[float(low[0]), float(low[1]), z], [float(high[0]), float(high[1]), z]]


def _water(water: Water, near: Floats, far: Floats, planar: bool) -> dict[str, object]:
    """The waves, surfaces about what is near and about all, and z of their sides' lower edge."""

    size = float(np.linalg.norm(near[1] - near[0])) / 2

    def patch(corners: Floats) -> list[list[float]]:
        along = REACH * float(np.linalg.norm(corners[1] - corners[0])) / 2
        half = np.array([along, ACROSS * size if planar else along])
        middle = corners.mean(axis=0)[:2]
        return [(middle - half).tolist(), (middle + half).tolist()]

    floor = max(-water.depth, min(float(near[0, 2]) - size, -size))
    steepest = sum(float((t.amplitude * t.number) @ (t.amplitude * t.number)) for t in water.trains)
    return {
        "trains": [
            {"ramp": train.ramp, "waves": [short(wave, 10) for wave in _largest(train.columns)]}
            for train in water.trains
        ],
        "near": patch(near),
        "far": patch(far),
        "cells": CELLS_IN_PLANE if planar else CELLS,
        "floor": floor,
        "steepest": 1.5 * steepest**0.5 or 1.0,
    }


def _largest(columns: Sequence[Floats]) -> Floats:
    """Rows (n, 5) of waves, in the units of `Train`, without the smallest."""
    waves = np.stack(columns, axis=1)
    order = np.argsort(waves[:, 2] ** 2)
    energy = np.cumsum(waves[order, 2] ** 2)
    kept = energy > WAVE_SHARE * energy[-1] if len(energy) else np.zeros(0, bool)
    return waves[np.sort(order[kept])]
