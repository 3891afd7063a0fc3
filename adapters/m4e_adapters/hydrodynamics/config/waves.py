"""Waves of a component: still water, or one or several systems of waves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator
from pydantic_core import InitErrorDetails

from m4e_adapters.hydrodynamics.config.numbers import Coordinate, Finite, NotNegative, Positive
from m4e_fmi.files.document import Section, rejected, rejected_at

MOST_ROWS = 100

Rows = tuple[tuple[Coordinate, Finite], ...]
"""[z, speed] [m, m/s]."""


def _from_bed_to_surface(rows: Rows) -> Rows:
    if not 2 <= len(rows) <= MOST_ROWS:
        text = f"a table of {len(rows)} rows, expected 2 to {MOST_ROWS}"
        raise rejected(text, "write [[z, speed], …]; one speed for all z is 'profile: uniform'")
    heights = [z for z, _ in rows]
    if len(set(heights)) < len(heights):
        raise rejected("the table has two speeds at one z", "give each z [m] once")
    return tuple(sorted(rows))


def _kind_of_current(profile: object) -> str:
    if isinstance(profile, (list, tuple)):
        return "table"
    return "word" if isinstance(profile, str) else "exponent"


Profile = Annotated[
    Annotated[Literal["uniform"], Tag("word")]
    | Annotated[Annotated[float, Field(gt=0, le=1)], Tag("exponent")]
    | Annotated[Annotated[Rows, AfterValidator(_from_bed_to_surface)], Tag("table")],
    Discriminator(_kind_of_current),
]


class Current(Section):
    """A steady, horizontal current that flows to `direction` [deg]: 0 is +X, in space the angle
    from +X towards +Y, in the plane 0 or 180.

    `speed` [m/s] is that at the still-water level z = 0. `profile` is `uniform` (default); or the
    exponent of a power law, speed·((z + h)/h)^exponent in water of depth h (1/7 is usual for
    tides); or a table [[z, speed], …] [m, m/s] in place of `speed`, linear between its rows and
    constant beyond. Above z = 0 the current is that of z = 0.
    """

    speed: NotNegative | None = None
    direction: Finite = 0.0
    profile: Profile = "uniform"

    @model_validator(mode="after")
    def _one_speed(self) -> Current:
        if isinstance(self.profile, tuple) == (self.speed is not None):
            if self.speed is None:
                raise rejected("a current needs a 'speed' [m/s]", "add the speed at the surface")
            raise rejected("'speed' has no effect: the table has speeds", "remove one of the two")
        return self


def current_problems(
    current: Current | None, *, depth: float, dimensions: int
) -> Iterator[tuple[tuple[str, ...], str, str]]:
    """Place, message and remedy of what does not suit water of `depth` [m], or the dimensions."""
    if current is None:
        return
    if dimensions == 2 and current.direction not in (0.0, 180.0):
        text = f"current direction {current.direction:g} deg leaves the X-Z plane"
        remedy = "write 0 (it flows to +X), 180 (to -X), or 'dimensions: 3' on top"
        yield ("current", "direction"), text, remedy
    if isinstance(current.profile, float) and math.isinf(depth):
        text = "a power law needs a depth: its speed is 0 at the bed"
        yield ("current", "profile"), text, "give water.depth, or a table [[z, speed], …]"
    if isinstance(current.profile, tuple) and (below := current.profile[0][0]) < -depth:
        text = f"the table begins {-depth - below:g} m below the sea bed"
        yield ("current", "profile"), text, "z = 0 is the still-water level"


PEAK_ENHANCEMENT = (1.0, 10.0)
MOST_SPREAD = (0.5, 500.0)
MOST_COMPONENTS = 1000


class _Waves(Section):
    """Direction and ramp, which all waves have."""

    direction: Finite = 0.0
    ramp_time: NotNegative | None = None


class Spreading(Section):
    """Directions about the mean one: density in proportion to cos^2s(Δ/2), s the `exponent` [1].

    The form of Longuet-Higgins, Cartwright and Smith (1963): wind sea has about 5 to 15, swell 25
    and more. The standard deviation of the directions is √(2/(1 + s)) rad.
    """

    exponent: Annotated[float, Field(ge=MOST_SPREAD[0], le=MOST_SPREAD[1])]


class _Spectral(_Waves):
    seed: Annotated[int, Field(ge=0)] = 0
    components: Annotated[int, Field(ge=10, le=1000)] = 300
    amplitudes: Literal["fixed", "random"] = "fixed"
    spreading: Spreading | None = None


class _Irregular(_Spectral):
    significant_height: Positive
    peak_period: Positive


class Jonswap(_Irregular):
    """JONSWAP sea: `significant_height` [m], `peak_period` [s], `peak_enhancement` γ [1].

    `seed` chooses frequencies and phases, of which `components` there are so many. `amplitudes`
    that are `fixed` give each sea exactly its height; `random` ones, Rayleigh's, give it on the
    average, and records that scatter as real ones of any length. `direction` [deg] is 0 (waves
    travel towards +X) or 180, in space any angle from +X towards +Y, there with or without
    `spreading`. The sea grows smoothly from nothing within `ramp_time` [s], default two peak
    periods.
    """

    spectrum: Literal["jonswap"]
    peak_enhancement: Annotated[float, Field(ge=PEAK_ENHANCEMENT[0], le=PEAK_ENHANCEMENT[1])] = 3.3


class PiersonMoskowitz(_Irregular):
    """Pierson-Moskowitz sea in Bretschneider's form of two parameters, by either name.

    `significant_height` [m], `peak_period` [s]; `seed`, `components`, `amplitudes`, `spreading`,
    `direction` [deg] and `ramp_time` [s] as of JONSWAP.
    """

    spectrum: Literal["pierson_moskowitz", "bretschneider"]


class SpectrumTable(_Spectral):
    """A spectrum of one's own: a CSV `file` with columns `omega` or `frequency`, and `density`.

    Either `omega` [rad/s] with densities in m2.s/rad, or `frequency` [Hz] with densities in m2/Hz;
    they ascend. Densities are linear between rows, 0 beyond. With a `significant_height` [m] they
    are scaled to it. Other keys as of JONSWAP: `direction` [deg], `ramp_time` [s], default two
    periods of the peak.
    """

    spectrum: Literal["table"]
    file: str
    significant_height: Positive | None = None


class Component(Section):
    """A regular wave of `amplitude` [m] and `period` [s] or `omega` [rad/s].

    `phase` [rad] at x = y = 0 and t = 0, without one at random; `direction` [deg], without one that
    of the system.
    """

    amplitude: Positive
    period: Positive | None = None
    omega: Positive | None = None
    phase: Finite | None = None
    direction: Finite | None = None

    @model_validator(mode="after")
    def _one_frequency(self) -> Component:
        if (self.period is None) == (self.omega is None):
            raise rejected("a component has a 'period' [s] or an 'omega' [rad/s]", "write one")
        return self


class ComponentWaves(_Waves):
    """Components of one's own: under `components`, or in a CSV `file`.

    The file has columns `amplitude` [m] and `period` [s] or `omega` [rad/s], with or without
    `phase` [rad] and `direction` [deg]. Phases that are not given are those of the `seed`. A sea of
    the `direction` [deg] grows from nothing within `ramp_time` [s], default two periods of the
    highest component.
    """

    spectrum: Literal["components"]
    components: tuple[Component, ...] | None = None
    file: str | None = None
    seed: Annotated[int, Field(ge=0)] = 0

    @model_validator(mode="after")
    def _once(self) -> ComponentWaves:
        if (self.components is None) == (self.file is None):
            raise rejected("components are listed here or in a file", "write one of the two keys")
        count = 1 if self.components is None else len(self.components)
        if not 1 <= count <= MOST_COMPONENTS:
            raise rejected(f"{count} components, expected 1 to {MOST_COMPONENTS}")
        return self


class Record(_Waves):
    """A measured elevation: a CSV `file` with columns `time` [s], in equal steps, and `elevation`.

    Elevation [m] was measured at `place` [x] or [x, y] [m], in waves that travel to `direction`
    [deg]. The record without its mean repeats itself; its ends are tapered to 0. `ramp_time` [s] is
    0 by default.
    """

    spectrum: Literal["record"]
    file: str
    place: Annotated[tuple[Coordinate, ...], Field(min_length=1, max_length=2)] = (0.0,)


class Regular(_Waves):
    """One wave: elevation at x = 0 is `height`/2·cos(2π t/`period` + `phase`), in m, s, rad.

    `direction` [deg] is 0 or 180, in space any; `ramp_time` [s] is two periods by default.
    """

    spectrum: Literal["regular"]
    height: Positive
    period: Positive
    phase: Finite = 0.0


class Still(Section):
    """No waves."""

    spectrum: Literal["still"]


WaveSection = Jonswap | PiersonMoskowitz | SpectrumTable | ComponentWaves | Record | Regular
"""One system of waves."""
AnySection = Annotated[WaveSection | Still, Discriminator("spectrum")]
MOST_SYSTEMS = 9


def _of_waves(sections: tuple[WaveSection | Still, ...]) -> tuple[WaveSection | Still, ...]:
    if any(isinstance(section, Still) for section in sections):
        raise rejected("still water is no system of waves", "leave it out of the list")
    if not 1 <= len(sections) <= MOST_SYSTEMS:
        count = f"a list of {len(sections)} systems of waves"
        raise rejected(f"{count}, expected 1 to {MOST_SYSTEMS}", "write {spectrum: still} for none")
    return sections


def _kind(waves: object) -> str:
    return "systems" if isinstance(waves, (list, tuple)) else "system"


Waves = Annotated[
    Annotated[AnySection, Tag("system")]
    | Annotated[
        Annotated[tuple[AnySection, ...], AfterValidator(_of_waves)],
        Tag("systems"),
    ],
    Discriminator(_kind),
]
AnyWaves = WaveSection | Still | Sequence[WaveSection | Still]


def wave_sections(waves: AnyWaves) -> tuple[WaveSection, ...]:
    """The systems of waves, none of still water."""
    every = waves if isinstance(waves, Sequence) else (waves,)
    return tuple(section for section in every if not isinstance(section, Still))


def flow_problems(
    waves: Waves, current: Current | None, *, depth: float, dimensions: int
) -> Iterator[InitErrorDetails]:
    """Waves and a current that do not suit water of `depth` [m], or the dimensions."""
    for problem in current_problems(current, depth=depth, dimensions=dimensions):
        yield rejected_at(*problem)
    if dimensions == 2:
        for place, message, remedy in waves_beyond_the_plane(waves):
            yield rejected_at(("waves", *place), message, remedy)


def waves_beyond_the_plane(waves: AnyWaves) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
    """Place, message and remedy of waves that are of space, or travel against others."""
    space = "or 'dimensions: 3' on top"
    either = f"write 0 (waves travel towards +X), 180 (towards -X), {space}"
    sections = wave_sections(waves)
    for k, section in enumerate(sections):
        place = (k, section.spectrum) if isinstance(waves, Sequence) else (section.spectrum,)
        if section.direction not in (0.0, 180.0):
            text = f"wave direction {section.direction:g} deg leaves the X-Z plane"
            yield (*place, "direction"), text, either
        elif section.direction != sections[0].direction:
            text = "waves against others: in the X-Z plane all travel in one direction"
            yield (*place, "direction"), text, f"write the same everywhere, {space}"
        if isinstance(section, Jonswap | PiersonMoskowitz | SpectrumTable) and section.spreading:
            text = "'spreading' leaves the X-Z plane"
            yield (*place, "spreading"), text, f"remove it, {space}"
        listed = section.components if isinstance(section, ComponentWaves) else ()
        for i, component in enumerate(listed or ()):
            if component.direction not in (None, section.direction):
                text = f"wave direction {component.direction:g} deg is not that of the others"
                yield (*place, "components", i, "direction"), text, f"remove it, {space}"
