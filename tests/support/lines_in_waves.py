"""Line systems in waves, as the mooring FMU makes them."""

from __future__ import annotations

from typing import Any

from m4e_adapters.hydrodynamics.seas.system_seas import water_program
from m4e_adapters.hydrodynamics.seas.water.moving_water import MovingWater
from m4e_adapters.moordyn import Mooring, MooringConfig, mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.water_course import WaterCourse
from m4e_fmi.files.document import Document
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime.library import library_path

ROPE = """\
water: {density: 0, depth: 1000}
line_types:
  rope: {diameter: 1.0e-3, mass_per_length: 1.0e-3, axial_stiffness: 1.0e+9, axial_damping: 0,
         drag_coefficient: 0, added_mass_coefficient: 0}
anchors: {top: [0, 0]}
fairleads: [bob]
lines:
  rope: {type: rope, from: top, to: bob, unstretched_length: 100.5, segments: 1}
"""
"""One segment that hangs from the origin, 1e9 N stiff."""


def course(made: Mooring, *, in_space: bool) -> WaterCourse | None:
    """The motion of the water around these lines; None if it stands still."""
    sea = made.sea
    if sea is None:
        return None
    program = water_program(sea.waves, sea.current, depth=sea.depth, in_space=in_space)
    water = MovingWater(
        load_python(program),
        counts=[len(system.omega) for system in sea.waves],
        current=sea.current is not None,
        depth=sea.depth,
        gravity=sea.gravity,
        stretching=sea.stretching,
    )
    water.set([v.start for v in program.parameters])
    return WaterCourse(water)


def mooring_of(text: str) -> Mooring:
    """The mooring of a section of a system file."""
    return mooring(Document.parse(text).validate(MooringConfig))


def line_system(text: str) -> LineSystem:
    """The lines of a mooring section."""
    return lines_of(mooring_of(text))


def lines_of(made: Mooring, **more: Any) -> LineSystem:
    """The lines of a mooring; `more` as `LineSystem` has it."""
    in_space = any(f.moves_in_space for f in made.fairleads)
    given = {
        **made.described(),
        "files": made.files,
        "runtime": library_path(),
        "course": course(made, in_space=in_space),
    }
    return LineSystem(made.text, **{**given, **more})


def started(made: Mooring, **more: Any) -> LineSystem:
    """The lines of a mooring, started with the fairleads at their places, at rest."""
    lines, places = lines_of(made, **more), [f.place for f in made.fairleads]
    lines.start(places, [(0.0,) * len(place) for place in places])
    return lines
