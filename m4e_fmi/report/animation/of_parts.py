"""Scenes of several parts that move by each other's variables: models, hulls, lines, the water."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from m4e_fmi.model import Model
from m4e_fmi.report.animation.of_model import scene_of_model, shifted
from m4e_fmi.report.animation.scene import (
    COORDINATES,
    GROUND,
    Body,
    Cable,
    Followed,
    Place,
    Rope,
    Scene,
    Spot,
    Value,
    Water,
)
from m4e_fmi.report.animation.shown import End, Shown, ShownCable, ShownHull, ShownRope

Y = COORDINATES.index("y")
MOST_TRIANGLES = 2000
"""Of the meshes of a model: results carry them."""


@dataclass
class PartScenes:
    """A scene of one part after the other; `follow(part, input)` says what an input is moved by.

    `notes` tell of what cannot be shown.
    """

    follow: Callable[[str, str], Value]
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._models: list[Scene] = []
        self._shown: dict[str, Shown] = {}
        self._shaped: set[int] = set()  # bodies that have a shape of their own
        self._in_water: set[int] = set()  # bodies that are shown by their hulls

    def add(self, name: str, shown: Shown) -> None:
        """Add what the part `name` shows."""
        self._shown[name] = shown

    def add_model(self, name: str, model: Model, values: Mapping[str, float]) -> None:
        """Add a model with these `values` of its parameters."""
        scene = scene_of_model(model, name, values, most=MOST_TRIANGLES)
        first = sum(len(one.bodies) for one in self._models)
        for k, body in enumerate(scene.bodies):
            if getattr(model.bodies[body.name.removeprefix(f"{name}.")], "shape", None):
                self._shaped.add(first + k)
        self._models.append(shifted(scene, first))

    def whole(self, title: str, description: str) -> Scene | None:
        """All of it, with the hulls on the bodies that they belong to; None if there is nothing."""
        bodies = [body for one in self._models for body in one.bodies]
        for name, shown in self._shown.items():
            for hull in shown.hulls:
                self._add_hull(bodies, name, hull)
        ropes = [rope for one in self._models for rope in one.ropes]
        for name, shown in self._shown.items():
            for k, rope in enumerate(shown.ropes):
                aside = k - (len(shown.ropes) - 1) / 2
                ropes.append(self._rope(bodies, name, rope, aside))
        cables = tuple(
            self._cable(name, cable)
            for name, shown in self._shown.items() for cable in shown.cables
        )  # fmt: skip
        if not bodies and not cables:
            return None
        floors = [shown.floor for shown in self._shown.values() if shown.floor is not None]
        return Scene(
            title=title,
            description=" ".join(description.split()),
            planar=not any(isinstance(body.motion[Y], Followed) for body in bodies),
            bodies=tuple(bodies),
            hinges=tuple(hinge for one in self._models for hinge in one.hinges),
            axes=tuple(axis for one in self._models for axis in one.axes),
            ropes=tuple(ropes),
            cables=cables,
            water=self._water(),
            floor=min(floors, default=None),
            notes=tuple(self.notes),
        )

    def _add_hull(self, bodies: list[Body], component: str, hull: ShownHull) -> None:
        """Put a hull on the body whose motion it has, or make it a body of its own.

        What the model has drawn as a box or an outline then goes, but not a shape of its own.
        Hulls of several components, such as members, are shown together.
        """
        name = f"{component}.{hull.name}"
        if hull.fixed:
            bodies.append(Body(f"{name} (fixed)", (0.0,) * 6, (hull.surface,)))
            return
        motion = tuple(self.follow(component, f"{hull.name}.{part}") for part in COORDINATES)
        for k, body in enumerate(bodies):
            if body.motion == motion:
                if k not in self._shaped:
                    others = body.surfaces if k in self._in_water else ()
                    bodies[k] = replace(body, surfaces=(*others, hull.surface))
                    self._in_water.add(k)
                return
        self._in_water.add(len(bodies))
        bodies.append(Body(name, motion, (hull.surface,)))

    def _place(self, component: str, end: End) -> Place:
        if not isinstance(end, str):
            return end
        x, y, z = (self.follow(component, f"{end}.{axis}") for axis in "xyz")
        return x, y, z

    def _rope(self, bodies: list[Body], component: str, rope: ShownRope, rank: float) -> Rope:
        """A rope whose moving ends are bodies without a surface."""

        def spot(end: End) -> Spot:
            if not isinstance(end, str):
                return Spot(GROUND, end)
            body = Body(f"{component}.{end}", (*self._place(component, end), 0.0, 0.0, 0.0))
            if body not in bodies:
                bodies.append(body)
            return Spot(bodies.index(body), (0.0, 0.0, 0.0))

        return Rope(rope.kind, (spot(rope.ends[0]), spot(rope.ends[1])), rank)

    def _cable(self, component: str, cable: ShownCable) -> Cable:
        def node(k: int) -> Place:
            x, y, z = (Followed(f"{component}.{cable.name}.node_{axis}[{k}]") for axis in "xyz")
            return x, y, z

        ends = (self._place(component, cable.ends[0]), self._place(component, cable.ends[1]))
        return Cable(
            f"{component}.{cable.name}",
            ends,
            tuple(node(k) for k in range(1, cable.count + 1)),
        )

    def _water(self) -> Water | None:
        """The water of the first component that has waves, or any; its gauge by its full name."""
        waters = {name: one.water for name, one in self._shown.items() if one.water is not None}
        for name, water in sorted(waters.items(), key=lambda item: not item[1].trains):
            return replace(water, gauge=f"{name}.{water.gauge}" if water.gauge else "")
        return None
