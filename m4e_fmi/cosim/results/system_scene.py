"""The scene of a system: parts of its models and kinds, followed along its connections."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from m4e_fmi.cosim.preparation.components import expected_descriptions
from m4e_fmi.cosim.system.component import Component, Kind, ModelFile, kind_module
from m4e_fmi.cosim.system.start_values import start_values
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import Description
from m4e_fmi.model import load_model
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

SCENE = "scene"
"""Function of a kind that tells what it shows: docs/adapters.md."""
Y = COORDINATES.index("y")
MOST_TRIANGLES = 2000
"""Of the meshes of a model: results carry them."""


def system_scene(
    system: System, descriptions: Mapping[str, Description], wiring: Wiring
) -> Scene | None:
    """The scene of a system with these `descriptions` and `wiring`; None if it shows no bodies.

    Components that are FMUs show nothing. Notes of the scene tell of parts that cannot be made.
    """
    built = _Built(system, descriptions, wiring)
    for component in system.components:
        built.add(component)
    return built.scene()


def scene_without_build(system: System) -> Scene | None:
    """The scene of a system of which nothing is built; None if it shows no bodies."""
    descriptions = expected_descriptions(system)
    known = tuple(c for c in system.components if c.name in descriptions)
    part = replace(system, components=known)
    return system_scene(part, descriptions, connect(part, descriptions))


@dataclass
class _Built:
    """A scene of one component after the other."""

    system: System
    descriptions: Mapping[str, Description]
    wiring: Wiring

    def __post_init__(self) -> None:
        self.sources: dict[Port, Link] = {link.target: link for link in self.wiring.links}
        self.models: list[Scene] = []
        self.shown: dict[str, Shown] = {}
        self.notes: list[str] = []
        self.starts: dict[str, dict[str, float]] = {}
        self.shaped: set[int] = set()  # bodies that have a shape of their own
        self.in_water: set[int] = set()  # bodies that are shown by their hulls

    def add(self, component: Component) -> None:
        """Add all that one component shows."""
        name, source = component.name, component.source
        self.starts[name] = values = _starts(component, self.descriptions[name])
        try:
            if isinstance(source, ModelFile):
                self._add_model(name, source, values)
            elif isinstance(source, Kind):
                self._add_kind(name, source, values)
        except InputError as error:
            self.notes.append(f"{name} is not shown: {error.problems[0].message}")

    def _add_kind(self, name: str, source: Kind, values: Mapping[str, float]) -> None:
        """Add a kind's scene. Its code may be anyone's: a fault of it is a note, and no error."""
        make = getattr(kind_module(source.name), SCENE, None)
        if make is None:
            return
        try:
            shown = make(source.config, folder=self.system.folder, values=values)
        except InputError:
            raise
        except Exception as error:
            found = f"{type(error).__name__}: {error}"
            message = f"the scene of kind '{source.name}' failed with {found}"
            raise InputError.single(" ".join(message.split()), "") from error
        if not isinstance(shown, Shown):
            message = f"the scene of kind '{source.name}' is a {type(shown).__name__}, not a Shown"
            raise InputError.single(message, "")
        self.shown[name] = shown

    def _add_model(self, name: str, source: ModelFile, values: Mapping[str, float]) -> None:
        model = load_model(source.path)
        scene = scene_of_model(model, name, values, most=MOST_TRIANGLES)
        first = sum(len(one.bodies) for one in self.models)
        for k, body in enumerate(scene.bodies):
            if getattr(model.bodies[body.name.removeprefix(f"{name}.")], "shape", None):
                self.shaped.add(first + k)
        self.models.append(shifted(scene, first))

    def scene(self) -> Scene | None:
        """All of it, with the hulls on the bodies that they belong to."""
        bodies = [body for one in self.models for body in one.bodies]
        for name, shown in self.shown.items():
            for hull in shown.hulls:
                self._add_hull(bodies, name, hull)
        ropes = [rope for one in self.models for rope in one.ropes]
        for name, shown in self.shown.items():
            for k, rope in enumerate(shown.ropes):
                aside = k - (len(shown.ropes) - 1) / 2
                ropes.append(self._rope(bodies, name, rope, aside))
        cables = tuple(
            self._cable(name, cable)
            for name, shown in self.shown.items() for cable in shown.cables
        )  # fmt: skip
        if not bodies and not cables:
            return None
        floors = [shown.floor for shown in self.shown.values() if shown.floor is not None]
        return Scene(
            title=self.system.name,
            description=" ".join(self.system.description.split()),
            planar=not any(isinstance(body.motion[Y], Followed) for body in bodies),
            bodies=tuple(bodies),
            hinges=tuple(hinge for one in self.models for hinge in one.hinges),
            axes=tuple(axis for one in self.models for axis in one.axes),
            ropes=tuple(ropes),
            cables=cables,
            water=next(self._waters(), None),
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
        motion = tuple(self._value(component, f"{hull.name}.{part}") for part in COORDINATES)
        for k, body in enumerate(bodies):
            if body.motion == motion:
                if k not in self.shaped:
                    others = body.surfaces if k in self.in_water else ()
                    bodies[k] = replace(body, surfaces=(*others, hull.surface))
                    self.in_water.add(k)
                return
        self.in_water.add(len(bodies))
        bodies.append(Body(name, motion, (hull.surface,)))

    def _value(self, component: str, variable: str) -> Value:
        """The variable that an input follows; of one without a link the start value, else 0."""
        link = self.sources.get(Port(component, variable))
        if link is not None:
            return Followed(str(link.source), link.factor, link.offset)
        return self.starts[component].get(variable, 0.0)

    def _place(self, component: str, end: End) -> Place:
        if not isinstance(end, str):
            return end
        x, y, z = (self._value(component, f"{end}.{axis}") for axis in "xyz")
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
            tuple(f"{component}.{name}" for name in cable.tensions),
        )

    def _waters(self) -> Iterator[Water]:
        """The waters of all components, those with waves first; gauges by their full names."""
        waters = {name: one.water for name, one in self.shown.items() if one.water is not None}
        for name, water in sorted(waters.items(), key=lambda item: not item[1].trains):
            yield replace(water, gauge=f"{name}.{water.gauge}" if water.gauge else "")


def _starts(component: Component, description: Description) -> dict[str, float]:
    """Values of the Reals of a component at the start, by name, in their units."""
    real = {name: v for name, v in description.variables.items() if v.type == "Real"}
    starts = {name: float(v.start) for name, v in real.items() if v.start is not None}
    given = start_values(component, description)
    return starts | {name: float(value) for name, value in given.items() if name in real}
