"""Sections of the component: water, bodies and points of them, frequencies, loads."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from m4e_adapters.hydrodynamics.config.numbers import (
    Depth,
    NotNegative,
    Order,
    Place,
    Positive,
)
from m4e_adapters.hydrodynamics.config.shapes import NO_SHAPE, Shape
from m4e_fmi.files.document import Section, rejected


class Drift(Section):
    """Slowly varying second-order forces of the waves, from a `file` beside the system file.

    Mean drift, for Newman's approximation: WAMIT's .7, .8 or .9, or CSV with columns omega [rad/s],
    direction [deg], surge, sway [N/m2], yaw [N.m/m2]. Full difference-frequency QTFs: WAMIT's .10d,
    .11d or .12d. `body` is the number of the body in a WAMIT file; `length_scale` [m] is its ULEN.
    `reference_point` [x, z], [x, y, z] in space, [m] is where the origin of the file's axes lies in
    the reference pose, about which its moments are; default: the centre of gravity.
    """

    file: str
    body: Annotated[int, Field(ge=1)] = 1
    length_scale: Positive = 1.0
    reference_point: Place | None = None


class LinearDrag(Section):
    """Linear drag: `surge`, `sway`, `heave` in N/(m/s), `roll`, `pitch`, `yaw` in N.m/(rad/s)."""

    surge: NotNegative = 0.0
    sway: NotNegative = 0.0
    heave: NotNegative = 0.0
    roll: NotNegative = 0.0
    pitch: NotNegative = 0.0
    yaw: NotNegative = 0.0


class Drag(LinearDrag):
    """Quadratic drag F = −c |v| v at the centre of gravity, and `linear` drag −c v.

    `surge`, `sway`, `heave` in N/(m/s)2, `roll`, `pitch`, `yaw` in N.m/(rad/s)2. Default 0: none.
    Sway, roll and yaw are motions of space. With `water: moving` v is the velocity relative to the
    water, waves and current, at the centre of gravity in the reference pose; rotations stay
    relative to water at rest. With `water: still` it is that of the body. Default: moving, if there
    is a current, otherwise still.
    """

    linear: LinearDrag = LinearDrag()
    water: Literal["still", "moving"] | None = None

    @property
    def feels_current(self) -> bool:
        """True of drag in a horizontal motion, in moving water."""
        slows = any((self.surge, self.sway, self.linear.surge, self.linear.sway))
        return slows and self.water != "still"


NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"


class Water(Section):
    """`density` [kg/m3], `depth` [m] or `deep` (default), `gravity` [m/s2]."""

    density: Positive = 1025.0
    depth: Depth = math.inf
    gravity: Positive = 9.81


class Body(Section):
    """A rigid body: `shape`, `center_of_gravity` [x, z] [m] in the reference pose, [x, y, z] in
    space.

    `panels` is about how many panels the wetted surface of a built-in shape gets; `drag` is
    quadratic; `drift` is of second order. A body that is `fixed` does not move: it stands in the
    way of waves and has no variables, `center_of_gravity`, `drag` or `drift`. It may stand on the
    sea bed. With `coefficients` of a file a body has no shape, and its center_of_gravity may be
    left out where the file has it. `reference_point` [m], the point that the motions in the file
    are about (default: the centre of gravity), and the displaced `volume` [m3] are given where the
    file lacks them. `weight_at` [m] is where the weight acts in the hydrostatic stiffness of the
    file (default: the centre of gravity of the file, else the one given here); for a stiffness
    without weight it is the point that the motions are about. A body that `slides_on` another has a
    wall in common with it, and no water gets in between.
    """

    shape: Shape = NO_SHAPE
    center_of_gravity: Place = ()
    panels: Annotated[int, Field(ge=48, le=20000)] = 600
    drag: Drag = Drag()
    drift: Drift | None = None
    fixed: bool = False
    reference_point: Place | None = None
    weight_at: Place | None = None
    volume: Positive | None = None
    slides_on: str | None = None


class Frequencies(Section):
    """Angular frequencies at which the potential flow is solved: `count`, equally spaced, from
    `minimum` to `maximum` [rad/s].

    Defaults: `count` 40; `maximum` sqrt(4.5 g / a), above which radiation is negligible: a is the
    radius of the half-ball of the smallest displacement or of its waterplane, for a submerged body
    plus the depth of its highest point; `minimum` = maximum / count, more in shallow water. Without
    a `maximum`, frequencies at twice the spacing follow where the waves need more (regular: their
    frequency; irregular: 2.5 peak frequencies). A `maximum` that is given is the last frequency:
    waves that need more are an error, irregular ones only where it is below its default. Above the
    last one excitation falls as 1/omega^3.
    """

    minimum: Positive | None = None
    maximum: Positive | None = None
    count: Annotated[int, Field(ge=12, le=400)] = 40


class Radiation(Section):
    """The radiation memory of each group of coupled motions: a passive `state_space` (default) with
    `order` poles, or the `convolution` with the memory that the damping has.

    `order: auto` (default) takes the smallest of 4 to 16 that reaches the accuracy, and 20
    where all of these are poor.
    """

    order: Order = None
    memory: Literal["state_space", "convolution"] = "state_space"

    @model_validator(mode="after")
    def _of_its_memory(self) -> Radiation:
        if self.memory == "convolution" and "order" in self.model_fields_set:
            text = "'order' has no effect on a convolution"
            raise rejected(text, "remove it, or memory: convolution")
        return self


class Loads(Section):
    """Parts of the load; one that is `none` acts not, or is left to another component.

    `froude_krylov` is the force of the undisturbed waves, `diffraction` that of the waves which the
    body scatters; `radiation` includes the added mass; `drag` is that of the bodies. Froude-Krylov
    and diffraction are those of the waves at the `reference` place of each body, or with
    `excitation_at: displaced` where it is.
    """

    hydrostatics: Literal["linear", "none"] = "linear"
    froude_krylov: Literal["linear", "none"] = "linear"
    diffraction: Literal["linear", "none"] = "linear"
    radiation: Literal["linear", "none"] = "linear"
    drag: Literal["quadratic", "none"] = "quadratic"
    excitation_at: Literal["reference", "displaced"] = "reference"

    @property
    def displaced(self) -> bool:
        """True if the excitation is that where the bodies are."""
        return self.excitation_at == "displaced"

    @property
    def excitation(self) -> tuple[str, ...]:
        """The parts of the excitation that act."""
        given = {"froude_krylov": self.froude_krylov, "diffraction": self.diffraction}
        return tuple(name for name, law in given.items() if law != "none")
