"""The mooring FMU: MoorDyn lines between fairleads and anchors.

`KIND.build` turns a mooring section of a system file into the source of a Python slave; what that
computes is said in README.md. Imports the moordyn adapter and m4e_fmi.fmu; `slave.py` travels in
the FMU.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_adapters import moordyn
from m4e_adapters.hydrodynamics.seas.system_seas import lines_on, water_program
from m4e_adapters.hydrodynamics.seas.water import moving_water
from m4e_adapters.moordyn import Failure, Fairlead, Mooring, MooringConfig
from m4e_adapters.moordyn.mooring import Sea
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, describe, runtime_files
from m4e_fmi.model import Sphere
from m4e_fmi.model.expression import Values
from m4e_fmi.program.python_form import python_source
from m4e_fmi.report.animation.shown import End, Shown, ShownCable, ShownHull
from m4e_fmi.report.drawing.hulls import shape_hull
from m4e_fmus.water import kind_in_water
from m4e_fmus.water.surroundings import is_of

if TYPE_CHECKING:
    from m4e_fmi.analysis.mooring_data import MooringData

TRAVELS = (
    "line_system.py",
    "moordyn_system.py",
    "node_forces.py",
    "plausibility.py",
    "rest.py",
    "statics.py",
)

LIGHT = 0.3
"""Weight of a line over that of the water it displaces, below which that is doubted."""
SOFT = 0.05
"""Strain of a hanging line by its own weight in water, above which that is doubted."""
SHORT = 1e-4
"""Internal step [s] below which lines take hours."""
FILE = "file_"
"""Of a file that MoorDyn's input names, with its number: its name in the FMU."""
MOST_PIECES = 40
"""Of a line between the nodes whose places are outputs."""


def _build(
    config: MooringConfig, *, name: str, folder: Path, progress: Callable[[str], None] = print
) -> PythonSource:
    """The source of the mooring FMU called `name`; files in `config` are relative to `folder`."""
    mooring = _that_parts(moordyn.mooring(config, folder=folder))
    progress(
        f"{_counted(len(mooring.lines), 'line')} at "
        f"{_counted(len(mooring.fairleads), 'fairlead')}, "
        f"internal time step up to {mooring.time_step:.3g} s"
    )
    for text in _doubts(mooring):
        progress(f"warning: {text}")
    if mooring.no_way_back:
        progress(f"note: it cannot go back to an earlier state: {mooring.no_way_back}")
    here, adapter = Path(__file__).parent, Path(moordyn.__file__).parent
    system = {
        **mooring.described(),
        "parting": _parting(mooring),  # of every line that can part the number of its failure
        "nodes": {line: _nodes(mooring, line) for line in mooring.lines},
        "anchors": {name: mooring.ends_at(point) for name, point in mooring.anchors.items()},
        "points": {name: mooring.ends_at(point) for name, point in mooring.points.items()},
        "strengths": dict(mooring.strengths),
        "flat": mooring.flat,
        "looked_up": [v.name for v in _looked_up(mooring, ())],
        "files": list(mooring.files),
    }
    source = PythonSource(
        description=ModelDescription(
            name,
            f"mooring lines {', '.join(mooring.lines)} by MoorDyn",
            _variables(mooring),
            goes_back=not mooring.no_way_back,
        ),
        slave="slave:MooringSlave",
        modules={
            "slave.py": here / "slave.py",
            **{name: adapter / name for name in TRAVELS},
        },
        data={
            "lines.txt": mooring.text.encode(),
            "mooring.json": json.dumps(system).encode(),
            **{f"{FILE}{k}": content for k, content in enumerate(mooring.files.values())},
            **runtime_files(),
        },
    )
    if mooring.sea is None:
        return source
    for line in lines_on(mooring.sea.waves):
        progress(line)
    return _in_moving_water(source, mooring.sea, in_space=config.dimensions == 3)


def _doubts(mooring: Mooring) -> Iterator[str]:
    """Values of lines that can hardly be meant, before anything is computed with them."""
    lines = [] if mooring.net is None else mooring.net["lines"]
    for name, line in zip(mooring.lines, lines, strict=False):
        if line["weight"] < LIGHT * line["buoyancy"]:
            yield (
                f"{name} weighs {line['weight']:.4g} N/m, and the water that it displaces "
                f"{line['buoyancy']:.4g} N/m: check its diameter, "
                f"{line['diameter']:g} m (not mm), and its mass per length in kg/m"
            )
        weight = abs(line["weight"] - line["buoyancy"]) * line["length"]
        if weight > 2 * SOFT * line["stiffness"]:
            yield (
                f"{name}, hanging, is stretched by {50 * weight / line['stiffness']:.3g} % by its "
                f"own weight: check its axial stiffness EA, {line['stiffness']:.4g} N (not kN)"
            )
    if mooring.time_step < SHORT:
        yield (
            f"MoorDyn makes {1 / mooring.time_step:,.0f} internal steps a second: check mass per "
            "length, axial stiffness and damping, or take fewer segments"
        )


def _in_moving_water(source: PythonSource, sea: Sea, *, in_space: bool) -> PythonSource:
    """`source` with what moves the water of a sea: its parameters, and code in the FMU."""
    program = water_program(sea.waves, sea.current, depth=sea.depth, in_space=in_space)
    parameters = [v for v in describe(program).variables if v.causality == "parameter"]
    variables = [
        replace(v, initial_dependencies=None) if v.causality == "output" else v
        for v in source.description.variables
    ]
    water = {
        "parameters": [v.name for v in parameters],
        "counts": [len(system.omega) for system in sea.waves],
        "current": sea.current is not None,
        "depth": sea.depth,
        "gravity": sea.gravity,
        "stretching": sea.stretching,
    }
    adapter, seas = Path(moordyn.__file__).parent, Path(moving_water.__file__).parent
    return replace(
        source,
        description=replace(source.description, variables=(*variables, *parameters)),
        modules={
            **source.modules,
            "water_course.py": adapter / "water_course.py",
            **{name: seas / name for name in ("moving_water.py", "kinematics.py")},
        },
        data={
            **source.data,
            "water.py": python_source(program).encode(),
            "water.json": json.dumps(water).encode(),
        },
    )


def _variables(mooring: Mooring) -> tuple[FmuVariable, ...]:
    inputs = [v for fairlead in mooring.fairleads for v in _of_fairlead(fairlead)]
    inputs += [v for line in mooring.winches for v in _of_winch(mooring, line)]
    names = tuple(v.name for v in inputs)
    text = "force of the lines on the body at {} along {}, world frame"
    outputs = [
        _output(f"{fairlead.name}.force_{axis}", text.format(fairlead.name, axis), names)
        for fairlead in mooring.fairleads
        for axis in _axes(fairlead)
    ]
    text = "tension of {} at its {} (the end given with '{}')"
    tensions = [
        _output(f"{line}.{end}_tension", text.format(line, end, where), names)
        for line in mooring.lines
        for end, where in (("fairlead", "to"), ("anchor", "from"))
    ]
    text = "1 parts {} from what it holds, for good"
    parted = [
        FmuVariable(
            f"{line}.parted",
            "1",
            text.format(line),
            causality="parameter",
            variability="tunable",
            initial="exact",
            start=0.0,
            minimum=0.0,
            maximum=1.0,
        )
        for line in _parting(mooring)
    ]
    return (*inputs, *outputs, *tensions, *parted, *_looked_up(mooring, names))


def _that_parts(mooring: Mooring) -> Mooring:
    """The same with every line parting at its fairlead when somebody says so."""
    if mooring.inert:  # a new system would take their motion for a blow
        return mooring
    known = {failure.ends[0][0] for failure in mooring.failures if len(failure.ends) == 1}
    more = [
        Failure(((k, _moved_end(mooring, k)),)) for k in range(len(mooring.lines)) if k not in known
    ]
    return replace(mooring, failures=(*mooring.failures, *more))


def _moved_end(mooring: Mooring, line: int) -> int:
    """The end, 0 (A) or 1 (B), that is at a fairlead; B where both or none are."""
    moved = [end in mooring.moved for end in mooring.at_lines[line]]
    return 0 if moved == [True, False] else 1


def _parting(mooring: Mooring) -> dict[str, int]:
    """Of the lines that part alone the number of their failure."""
    return {
        mooring.lines[failure.ends[0][0]]: k
        for k, failure in enumerate(mooring.failures)
        if len(failure.ends) == 1
    }


def _scene(config: MooringConfig, *, folder: Path, **_: object) -> Shown:
    """Lines, but for those at rods and bodies, free points with a volume as spheres, and the bed.

    Places depend on no parameter.
    """
    mooring = moordyn.mooring(config, folder=folder)
    at: dict[str, End] = {
        row[0]: (float(row[2]), float(row[3]), float(row[4]))
        for row in mooring.rows("POINTS")
        if not row[1].upper().startswith("BODY")
    }
    at |= {word: fairlead.name for word, fairlead in mooring.moved.items()}
    at |= {str(number): name for name, number in mooring.points.items()}
    cables = [
        ShownCable(name, (at[a], at[b]), len(_nodes(mooring, name)))
        for name, (a, b) in zip(mooring.lines, mooring.at_lines, strict=True)
        if a in at and b in at
    ]
    radii = {name: (0.75 * p.volume / math.pi) ** (1 / 3) for name, p in config.points.items()}
    hulls = [
        ShownHull(name, shape_hull(Sphere(radius=radius), Values({}), 0))
        for name, radius in radii.items()
        if radius
    ]
    return Shown(tuple(hulls), tuple(cables), floor=mooring.bed)


def _nodes(mooring: Mooring, line: str) -> list[int]:
    """Numbers of the nodes of a line that are outputs, both ends among them."""
    last = int(mooring.rows("LINES")[mooring.lines.index(line)][5])
    count = min(last, MOST_PIECES)
    return [round(last * k / count) for k in range(count + 1)]


def _looked_up(mooring: Mooring, inputs: tuple[str, ...]) -> Iterator[FmuVariable]:
    """Outputs that are computed if they are read: of lines, free points and anchors.

    All but places of nodes are declared to depend on all inputs, so that they are read once a row.
    """

    def output(name: str, text: str, unit: str = "N") -> FmuVariable:
        return replace(_output(name, text, inputs), unit=unit, dependencies=inputs)

    places = tuple(n for n in inputs if n.rpartition(".")[2] in ("x", "y", "z", "length"))
    for line in mooring.lines:
        for axis in "xyz":
            for number, node in enumerate(_nodes(mooring, line), start=1):
                text = f"{axis} of node {node} of {line}, counted from the end given with 'from'"
                found = output(f"{line}.node_{axis}[{number}]", text, "m")
                yield replace(found, dependencies=(), initial_dependencies=places)
        for number, node in enumerate(_nodes(mooring, line), start=1):
            text = f"tension within {line} at node {node}; at its ends of its last segments"
            yield output(f"{line}.tension[{number}]", text)
        if mooring.flat:
            text = f"unstretched length of {line} on the seabed, from the end given with 'from'"
            yield output(f"{line}.touchdown", text, "m")
        if line in mooring.strengths:
            text = f"strength of {line}, {mooring.strengths[line]:g} N, over its larger end tension"
            yield output(f"{line}.safety_factor", text, "1")
    for point in mooring.points:
        for axis in "xyz":
            yield output(f"{point}.{axis}", f"{axis} of {point}, world frame", "m")
    for anchor in mooring.anchors:
        for axis in "xyz":
            text = f"force of the lines on {anchor} along {axis}, world frame"
            yield output(f"{anchor}.force_{axis}", text)
        text = f"angle of the lines' pull at {anchor} above the horizontal; 0 if it is downwards"
        yield output(f"{anchor}.uplift_angle", text, "rad")


def _of_fairlead(fairlead: Fairlead) -> Iterator[FmuVariable]:
    """Inputs of the motion of a fairlead, along the axes on which it moves."""
    for axis, start in zip(_axes(fairlead), fairlead.place, strict=True):
        where = f"{fairlead.name}.{axis}"
        yield FmuVariable(
            where, "m", f"{axis} of {fairlead.name}, world frame", causality="input", start=start
        )
        yield FmuVariable(
            f"{fairlead.name}.v{axis}",
            "m/s",
            f"velocity of {fairlead.name} along {axis}, world frame; of a step, its mean",
            causality="input",
            start=0.0,
            derivative_of=where,
        )


def _of_winch(mooring: Mooring, line: int) -> Iterator[FmuVariable]:
    """Inputs of the length of a line with a winch."""
    name, length = mooring.lines[line], float(mooring.rows("LINES")[line][4])
    text = f"unstretched length of {name}"
    least = length / 100
    yield FmuVariable(f"{name}.length", "m", text, causality="input", start=length, minimum=least)
    yield FmuVariable(
        f"{name}.length_rate",
        "m/s",
        f"rate of the unstretched length of {name}; of a step, its mean",
        causality="input",
        start=0.0,
        derivative_of=f"{name}.length",
    )


def _axes(fairlead: Fairlead) -> str:
    return "xyz" if fairlead.moves_in_space else "xz"


def _output(name: str, text: str, inputs: tuple[str, ...]) -> FmuVariable:
    """An output of the lines' state, initially made from the inputs, and the present velocities."""
    return FmuVariable(
        name,
        "N",
        text,
        causality="output",
        initial="calculated",
        dependencies=tuple(name for name in inputs if name.rpartition(".")[2].startswith("v")),
        initial_dependencies=inputs,
    )


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _calm(
    config: MooringConfig, start: Mapping[str, object]
) -> tuple[MooringConfig, dict[str, object]]:
    """The configuration and the start values without waves."""
    return config.in_still_water(), {n: v for n, v in start.items() if not is_of(n, "waves")}


def _statics(config: MooringConfig, *, folder: Path) -> object:
    """The outputs of lines at rest, by their inputs."""
    from m4e_fmus.mooring.statics import statics  # of SciPy

    return statics(config, folder=folder, shown=_nodes)


def _mooring(config: MooringConfig, **asked: Any) -> MooringData:
    """The lines at rest, for a report."""
    from m4e_fmus.mooring.statics import mooring_data

    return mooring_data(config, **asked)


def _config_of_file(path: Path, **_: object) -> MooringConfig:
    """The configuration for a MoorDyn file."""
    return MooringConfig(file=path.name)


KIND = kind_in_water(
    MooringConfig,
    build=_build,
    scene=_scene,
    at_rest=_calm,
    statics=_statics,
    mooring=_mooring,
    config_of_file=_config_of_file,
)
