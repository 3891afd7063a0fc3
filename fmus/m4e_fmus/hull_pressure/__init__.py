"""The FMU of `kind: hull_pressure`: pressure of the water on hulls at their true pose.

`KIND.build` turns the section of a system file into the source of a Python slave; what that
computes is said in README.md. `slave.py` and the modules of `TRAVELS` travel in the FMU.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics import pressure
from m4e_adapters.hydrodynamics.config import wave_sections
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, Motion, point_in_space
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.pressure.closed_hull import closed_hulls
from m4e_adapters.hydrodynamics.pressure.config import HullPressureConfig
from m4e_adapters.hydrodynamics.pressure.hull_load import HullData, HullLoad, PressureData
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.shown_water import shown_sea
from m4e_adapters.hydrodynamics.seas.system_seas import wave_data
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource
from m4e_fmi.report.animation.shown import Shown
from m4e_fmus.water import kind_in_water

TRAVELS = ("hull_load.py",)


def _build(
    config: HullPressureConfig, *, name: str, folder: Path, progress: Callable[[str], None] = print
) -> PythonSource:
    """The source of the FMU called `name`; mesh files in `config` are relative to `folder`."""
    hulls = closed_hulls(config, folder)
    water = config.water
    systems = wave_systems(config.waves, depth=water.depth, gravity=water.gravity, folder=folder)
    for text in (text for system in systems for text in system.doubts({})):
        progress(f"warning: {text}")
    bodies = [_data(name, hull, config) for name, hull in hulls.items()]
    for body in bodies:
        mass = body["neutral_mass"]
        progress(
            f"body {body['name']!r}: displaces {mass / config.water.density:.6g} m3 in the "
            f"reference pose, neutral mass {mass:.6g} kg, {len(body['triangles'])} triangles"
        )
    here, travels = Path(__file__).parent, Path(pressure.__file__).parent
    data = PressureData(
        bodies=bodies,
        weight=config.water.density * config.water.gravity,
        dimensions=config.dimensions,
        depth=config.water.depth,
        waves=wave_data(systems),
    )
    text = f"hydrostatic and wave pressure on {', '.join(config.bodies)}"
    return PythonSource(
        description=ModelDescription(name, text, tuple(_variables(config))),
        slave="slave:HullPressureSlave",
        modules={"slave.py": here / "slave.py", **{file: travels / file for file in TRAVELS}},
        data={"hulls.json": json.dumps(data).encode()},
    )


def _scene(config: HullPressureConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """The hulls and the water; `values` are those of parameters at the start."""
    hulls = drawn_hulls(config.bodies, folder)
    return shown_sea(config.water, config.waves, folder=folder, values=values, hulls=hulls)


def _data(name: str, hull: Panels, config: HullPressureConfig) -> HullData:
    """A body as `slave.py` reads it."""
    center = config.bodies[name].center_of_gravity
    vertices, triangles = hull.vertices - np.array(point_in_space(center)), hull.triangle_faces
    still = HullLoad(vertices.tolist(), triangles.tolist(), weight=1.0, waves=None)
    load = still.at(point_in_space(center), (0.0, 0.0, 0.0), 0.0)
    return HullData(
        name=name,
        vertices=vertices.tolist(),
        triangles=triangles.tolist(),
        neutral_mass=config.water.density * load.wetted_volume,
        y=point_in_space(center)[1],
    )


def _variables(config: HullPressureConfig) -> Iterator[FmuVariable]:
    motions, waves = MOTIONS[config.dimensions], bool(wave_sections(config.waves))
    for body, section in config.bodies.items():
        text = f"mass of the water that {body} displaces in the reference pose"
        yield FmuVariable(
            f"{body}.neutral_mass",
            "kg",
            text,
            causality="calculatedParameter",
            variability="fixed",
            initial="calculated",
        )
        yield from _inputs(body, motions, section.center_of_gravity)
        pose = [motion.position for motion in motions]
        level = tuple(f"{body}.{name}" for name in pose if name in "xy")
        turned = tuple(f"{body}.{name}" for name in pose if name not in "xy")
        whole = f"of the water's pressure on {body} about its centre of gravity, world frame"
        given = (*level, *turned) if waves else turned
        yield from _wrench(body, "", whole, motions, given)
        still = f"part of {body}'s: pressure of still water at its pose"
        yield from _wrench(body, "hydrostatic_", still, motions, turned)
        if waves:
            added = f"part of {body}'s: what the undisturbed waves add at its pose"
            yield from _wrench(body, "froude_krylov_", added, motions, given)
            text = "height of the undisturbed surface at the centre of gravity's place"
            yield _output(f"{body}.water_level", "m", text, level)
        text = f"volume of {body} below the undisturbed surface"
        yield _output(f"{body}.wetted_volume", "m3", text, given)
    if waves:
        text = "elevation of the undisturbed water at x = y = 0"
        yield _output("wave.elevation", "m", text, ())


def _inputs(
    body: str, motions: tuple[Motion, ...], center: tuple[float, ...]
) -> Iterator[FmuVariable]:
    starts: dict[str, float] = dict(zip("xyz", point_in_space(center), strict=True))
    in_space = len(motions) == 6
    for motion in motions:
        text = f"{motion.position} of the centre of gravity, world frame"
        if motion.is_rotation:
            text = f"{motion.name} angle, world frame"
            if in_space:
                text += ", R = R_z(psi) R_y(theta) R_x(phi) from body to world axes"
        yield FmuVariable(
            f"{body}.{motion.position}",
            motion.unit,
            text,
            causality="input",
            start=starts.get(motion.position, 0.0),
        )
    for motion in motions:
        text = f"rate of {body}.{motion.position}, world frame; without effect on the pressure"
        if motion.is_rotation and in_space:
            axis = "XYZ"[motions.index(motion) - 3]
            text = f"angular velocity about +{axis}, world frame; without effect on the pressure"
        yield FmuVariable(
            f"{body}.{motion.velocity}", f"{motion.unit}/s", text, causality="input", start=0.0
        )


def _wrench(
    body: str, part: str, text: str, motions: tuple[Motion, ...], given: tuple[str, ...]
) -> Iterator[FmuVariable]:
    nothing = ("force_x", "force_y", "moment_z") if part == "hydrostatic_" else ()
    for motion in motions:
        name = f"{body}.{part}{motion.force}"
        of = () if motion.force in nothing else given
        yield _output(name, motion.force_unit, f"{motion.force} {text}", of)


def _output(name: str, unit: str, text: str, given: tuple[str, ...]) -> FmuVariable:
    """An output that follows its `given` inputs at once."""
    return FmuVariable(
        name,
        unit,
        text,
        causality="output",
        initial="calculated",
        dependencies=given,
        initial_dependencies=given,
    )


KIND = kind_in_water(HullPressureConfig, build=_build, scene=_scene)
