"""Keys of a mooring section of a system file.

Either the lines are described here, or `file` names a ready MoorDyn v2 input file.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import (
    Discriminator,
    Field,
    StringConstraints,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, ValidationError

from m4e_adapters.hydrodynamics.config import Current, Still, Waves
from m4e_adapters.hydrodynamics.config.waves import (
    AnyWaves,
    WaveSection,
    wave_sections,
    waves_beyond_the_plane,
)
from m4e_adapters.hydrodynamics.seas.water.kinematics import Stretching
from m4e_adapters.moordyn.mooring import SHORTEST
from m4e_fmi.errors import suggestion
from m4e_fmi.files.document import Section, rejected, rejected_at

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Positive = Annotated[float, Field(gt=0, le=1e15, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, le=1e15, allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7, allow_inf_nan=False)]
Load = Annotated[float, Field(ge=-1e15, le=1e15, allow_inf_nan=False)]
Place = tuple[Coordinate, ...]
"""(x, z), or (x, y, z) where `dimensions` is 3."""


def _is_word(waves: object) -> str:
    return "word" if isinstance(waves, str) else "waves"


WavesOrNone = Annotated[
    Annotated[Literal["none"], Tag("word")] | Annotated[Waves, Tag("waves")],
    Discriminator(_is_word),
]
DESCRIBED = (
    "line_types",
    "anchors",
    "points",
    "lines",
    "seabed",
    "solver",
    "static_equilibrium",
)


class Water(Section):
    """Density [kg/m³], depth [m] of a flat seabed at z = −depth, gravity [m/s²]."""

    density: NonNegative = 1025.0
    depth: Positive
    gravity: Positive = 9.80665


class LineType(Section):
    """Properties of a kind of line.

    diameter [m] (that of a rod of the same displacement), mass_per_length [kg/m] in air,
    axial_stiffness EA [N], bending_stiffness EI [N·m²]. Damping either as axial_damping BA [N·s]
    or as axial_damping_ratio, that of the fastest mode of a segment (1: critical).
    drag_coefficient and added_mass_coefficient are those of Morison's equation, across the line;
    axial_drag_coefficient (which refers to the area π·d·l) and axial_added_mass_coefficient along.
    breaking_strength [N]: the tension at an end that such a line holds.
    """

    diameter: Positive
    mass_per_length: Positive
    axial_stiffness: Positive
    axial_damping: NonNegative | None = None
    axial_damping_ratio: NonNegative | None = None
    bending_stiffness: NonNegative = 0.0
    drag_coefficient: NonNegative
    added_mass_coefficient: NonNegative
    axial_drag_coefficient: NonNegative = 0.0
    axial_added_mass_coefficient: NonNegative = 0.0
    breaking_strength: Positive | None = None

    @model_validator(mode="after")
    def _one_damping(self) -> LineType:
        if (self.axial_damping is None) == (self.axial_damping_ratio is None):
            raise rejected(
                "axial damping must be given in one way",
                "drop one of 'axial_damping' and 'axial_damping_ratio'"
                if self.axial_damping is not None
                else "add 'axial_damping_ratio: 1.0' (usual), or 'axial_damping: …' in N·s",
            )
        return self


class Line(Section):
    """A line of `type` from an anchor, a free point or a fairlead to a fairlead or a free point.

    unstretched_length [m]; segments: how many pieces it is divided into. winch: true if its length
    and the rate of it are inputs. breaks: true if it parts at the end `to` once the tension there
    exceeds the breaking strength of its type.
    """

    type: str
    from_: str = Field(alias="from")
    to: str
    unstretched_length: Positive
    segments: int = Field(ge=1, le=1000)
    winch: bool = False
    breaks: bool = False


class FreePoint(Section):
    """A point that lines alone hold: a buoy, a clump weight, or a joint of lines.

    position (x, z), in space (x, y, z) [m]: where the search for its equilibrium begins. Weight of
    its mass [kg] and buoyancy of its volume [m³], all of it, above the water too. drag_area [m²]:
    area times drag coefficient; added_mass_coefficient [1], of the volume; force: a constant one
    with the components of a position [N], world frame.
    """

    position: Place
    mass: NonNegative = 0.0
    volume: NonNegative = 0.0
    drag_area: NonNegative = 0.0
    added_mass_coefficient: NonNegative = 0.0
    force: tuple[Load, ...] | None = None


class Seabed(Section):
    """Normal stiffness [Pa/m] and damping [Pa·s/m] of the seabed, per projected area d·l.

    friction: the coefficient of it [1], the same in all directions; friction_damping: force over
    speed of a node of a line, times that coefficient, up to where it slides [N·s/m]. bathymetry:
    rows of a bed that is not flat, (x, depth) or (x, y, depth) [m] of a grid, or a CSV file with
    these columns; linear between its lines and constant beyond.
    """

    stiffness: NonNegative = 3.0e6
    damping: NonNegative = 3.0e5
    friction: NonNegative = 0.0
    friction_damping: NonNegative = 200.0
    bathymetry: str | list[Place] | None = None


class Solver(Section):
    """MoorDyn's internal integration: `time_step` [s] is the longest step, of `scheme`.

    Steps are shortened where a line needs it. Without `scheme` the cheaper one is taken: RK2 for
    damped lines, RK4 for lines without axial damping.
    """

    scheme: Literal["RK2", "RK4"] | None = None
    time_step: Annotated[float, Field(ge=SHORTEST, allow_inf_nan=False)] | None = None


class MooringConfig(Section):
    """The keys of a component of `kind: mooring`, without `kind` and `start`.

    fairleads: a list of names, or names with the (x, z) [m] where they are unless a connection or a
    start value says otherwise. anchors: names with their fixed (x, z) [m]; points: names of those
    that lines alone hold. World frame. With `dimensions` 3 places are (x, y, z), and fairleads move
    along Y, too.
    static_equilibrium: true if lines start where they rest; else straight, or as a catenary.
    waves: those that move the water around the lines, as of hydrodynamics, continued up to the
    surface by `stretching`; default is still water. `none` says that lines stay in still water
    where others have waves. current: a steady one, in which lines are at rest. Beside a `file`,
    `water` gives what the file leaves out.
    """

    file: str | None = None
    dimensions: Literal[2, 3] = 2
    water: Water | None = None
    waves: WavesOrNone = Still(spectrum="still")
    current: Current | None = None
    stretching: Stretching = "linear"
    seabed: Seabed = Seabed()
    fairleads: dict[Name, Place | None] = Field(default_factory=dict)
    line_types: dict[Name, LineType] = Field(default_factory=dict)
    anchors: dict[Name, Place] = Field(default_factory=dict)
    points: dict[Name, FreePoint] = Field(default_factory=dict)
    solver: Solver = Solver()
    static_equilibrium: bool = True
    lines: dict[Name, Line] = Field(default_factory=dict)

    @field_validator("waves")
    @classmethod
    def _waves_fit(
        cls, value: AnyWaves | Literal["none"], info: ValidationInfo
    ) -> AnyWaves | Literal["none"]:
        if value != "none" and info.data.get("dimensions", 2) == 2:
            found = waves_beyond_the_plane(value)
            _raise("waves", [rejected_at(place, text, remedy) for place, text, remedy in found])
        return value

    @property
    def moves_water(self) -> bool:
        """True if there are waves or a current."""
        return bool(self.systems) or self.current is not None

    def in_still_water(self) -> MooringConfig:
        """The same without waves."""
        return self.model_copy(update={"waves": "none"})

    @property
    def systems(self) -> tuple[WaveSection, ...]:
        """The systems of waves; none in still water."""
        return () if self.waves == "none" else wave_sections(self.waves)

    @field_validator("fairleads", mode="before")
    @classmethod
    def _names_only(cls, value: object) -> object:
        if not isinstance(value, list):
            return value
        if not all(isinstance(name, str) for name in value):
            raise rejected(
                "a list of fairleads contains names only", "write 'fairleads: [bow, stern]'"
            )
        twice = sorted({str(name) for name in value if value.count(name) > 1})
        if twice:
            raise rejected(f"{', '.join(twice)} is listed twice", "give each fairlead its name")
        return dict.fromkeys(value)

    @field_validator("fairleads")
    @classmethod
    def _fairleads_fit(
        cls, value: dict[str, Place | None], info: ValidationInfo
    ) -> dict[str, Place | None]:
        places = {name: place for name, place in value.items() if place}
        _raise("fairleads", _misplaced("fairlead", places, info))
        return value

    @field_validator("anchors")
    @classmethod
    def _anchors_fit(cls, value: dict[str, Place], info: ValidationInfo) -> dict[str, Place]:
        _raise("anchors", _misplaced("anchor", value, info) + _named_twice("anchor", value, info))
        return value

    @field_validator("points")
    @classmethod
    def _points_fit(cls, value: dict[str, FreePoint], info: ValidationInfo) -> dict[str, FreePoint]:
        places = {name: point.position for name, point in value.items()}
        wrong = _misplaced("point", places, info) + _named_twice("point", value, info)
        dimensions = info.data.get("dimensions", 2)
        for name, point in value.items():
            if point.force is not None and len(point.force) != dimensions:
                text = f"{name}: a force has {dimensions} components, got {len(point.force)}"
                wrong.append(rejected_at((name, "force"), text, "as many as the position has"))
        _raise("points", wrong)
        return value

    @field_validator("lines")
    @classmethod
    def _lines_fit(cls, value: dict[str, Line], info: ValidationInfo) -> dict[str, Line]:
        keys = ("line_types", "anchors", "fairleads", "points")
        if not info.data.keys() >= {*keys}:  # one of them is wrong itself
            return value
        types, anchors, fairleads, points = (info.data[key] for key in keys)
        wrong = []
        more = " or point" if points else ""
        for name, line in value.items():
            for key, noun, names in (
                ("type", "line type", types),
                ("to", f"fairlead{more}", {*fairleads, *points}),
                ("from", f"anchor or fairlead{more}", {*anchors, *fairleads, *points}),
            ):
                given = line.from_ if key == "from" else getattr(line, key)
                if given not in names:
                    text = f"{name}: there is no {noun} {given!r}"
                    remedy = suggestion(given, names, "points" if key == "from" else f"{noun}s")
                    wrong.append(rejected_at((name, key), text, remedy))
            if line.from_ == line.to:
                text = f"{name} begins and ends at {line.to!r}"
                wrong.append(rejected_at((name, "from"), text, "let it begin at an anchor"))
            if line.breaks and line.type in types and not types[line.type].breaking_strength:
                text = f"{name} breaks, but its type {line.type!r} has no breaking strength"
                wrong.append(rejected_at((name, "breaks"), text, "add 'breaking_strength: …' in N"))
        used = {end for line in value.values() for end in (line.from_, line.to)}
        for noun, names in (("fairlead", fairleads), ("point", points)):
            idle = [name for name in names if name not in used] if value else []
            if idle and not wrong:
                text = f"no line ends at {noun} {', '.join(map(repr, idle))}"
                remedy = f"add a line with 'to: …', or remove the {noun}"
                wrong.append(rejected_at((), text, remedy))
        _raise("lines", wrong)
        return value

    @model_validator(mode="after")
    def _file_or_description(self) -> MooringConfig:
        given = [key for key in DESCRIBED if key in self.model_fields_set]
        if self.file is not None:
            if given:
                raise rejected(
                    f"'file' and {', '.join(map(repr, given))} cannot be combined",
                    "write it in the MoorDyn file, or describe the lines here without 'file'",
                )
            return self
        needed = ("water", "line_types", *([] if self.points else ["fairleads"]), "lines")
        missing = [key for key in needed if not getattr(self, key)]
        if missing:
            raise rejected(
                f"a mooring needs {', '.join(map(repr, missing))}",
                "add them, or name a ready MoorDyn file with 'file: …'",
            )
        return self


def _misplaced(noun: str, places: dict[str, Place], info: ValidationInfo) -> list[InitErrorDetails]:
    """A problem for each place with another number of coordinates, or below the seabed."""
    dimensions, water = info.data.get("dimensions", 2), info.data.get("water")
    form = "[x, z]" if dimensions == 2 else "[x, y, z]"
    flat = info.data.get("seabed", Seabed()).bathymetry is None
    wrong = []
    for name, place in places.items():
        if len(place) != dimensions:
            remedy = f"write {form}; numbers have a decimal point"
            if dimensions == 2:
                remedy += ", and places in space need 'dimensions: 3'"
            text = f"{name}: expected {form}, got {len(place)} entries"
            wrong.append(rejected_at((name,), text, remedy))
        elif water and flat and place[-1] < -water.depth:
            text = (
                f"{noun} {name!r} at z = {place[-1]:g} m lies below the seabed at "
                f"{-water.depth:g} m"
            )
            remedy = f"use z >= {-water.depth:g}, or a larger depth"
            wrong.append(rejected_at((name,), text, remedy))
    return wrong


def _named_twice(noun: str, names: Iterable[str], info: ValidationInfo) -> list[InitErrorDetails]:
    """A problem for each name that an anchor or a fairlead has already."""
    return [
        rejected_at((n,), f"{n!r} is also the name of {other}", f"give the {noun} another name")
        for n in names
        for other, key in (("a fairlead", "fairleads"), ("an anchor", "anchors"))
        if n in info.data.get(key, ())
    ]


def in_space(place: Place) -> tuple[float, float, float]:
    """(x, y, z) of a place; y is 0 in the plane."""
    return place[0], place[1] if len(place) == 3 else 0.0, place[-1]


def _raise(title: str, wrong: list[InitErrorDetails]) -> None:
    """All that is wrong with a field at once, each at its own place below it."""
    if wrong:
        raise ValidationError.from_exception_data(title, wrong)
