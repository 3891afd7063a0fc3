"""Line systems in waves, as the mooring FMU makes them."""

from __future__ import annotations

from m4e_adapters.hydrodynamics.seas.system_seas import water_program
from m4e_adapters.hydrodynamics.seas.water.moving_water import MovingWater
from m4e_adapters.moordyn import Mooring, MooringConfig, mooring
from m4e_adapters.moordyn.line_system import LineSystem
from m4e_adapters.moordyn.water_course import WaterCourse
from m4e_fmi.files.document import Document
from m4e_fmi.program.python_form import load_python


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


def line_system(text: str) -> LineSystem:
    """The lines of a mooring section."""
    config = Document.parse(text).validate(MooringConfig)
    made = mooring(config)
    return LineSystem(
        made.text,
        fairleads=[None if f.moves_in_space else f.y for f in made.fairleads],
        lines=list(made.lines),
        time_step=made.time_step,
        net=made.net,
        bed=made.bed,
        course=course(made, in_space=config.dimensions == 3),
    )
