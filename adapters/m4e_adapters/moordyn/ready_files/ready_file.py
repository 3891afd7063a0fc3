"""A MoorDyn v2 input file that somebody else wrote, as a mooring.

Everything that would abort the process or be ignored silently is refused. The physics of an
accepted file is not touched; its output switches are turned off, its internal step is written out,
its failures are left to the adapter, and what is taken otherwise is in the mooring's notes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from m4e_adapters.moordyn.line_file import MOVING_WATER, QUIET, RELAXATION, header, table
from m4e_adapters.moordyn.mooring import (
    Failure,
    Fairlead,
    Mooring,
    NetData,
    Sea,
    internal_step,
    kinds_of,
)
from m4e_adapters.moordyn.ready_files.attachments import (
    BODY,
    COUPLED,
    ENDS,
    Attachments,
    Place,
    end_name,
    ends_of,
)
from m4e_adapters.moordyn.ready_files.checks import ELSEWHERE, SEGMENTS, check, check_places
from m4e_adapters.moordyn.ready_files.named_files import SYROPE, NamedFiles, Slopes
from m4e_adapters.moordyn.ready_files.read_file import (
    TABLES,
    ReadFile,
    Row,
    has_force,
    number,
)
from m4e_adapters.moordyn.stability import (
    FLOW,
    MARGIN,
    SCHEMES,
    STRAIN,
    Segment,
    clear_of_seabed,
    damping_of_ratio,
)
from m4e_fmi.errors import InputError

SEABED = {"kbot": 3.0e6, "cbot": 3.0e5}  # MoorDyn's own, Pa/m and Pa·s/m
WATER = {"rho": 1025.0, "g": 9.80665}  # MoorDyn's own
FRICTION_DAMPING = 200.0  # MoorDyn's own FricDamp
GIVEN = {"depth": "wtrdpth", "density": "rho", "gravity": "g"}  # by `water` of a component
REPLACED = {"cfl", "writeunits", "dtout", "fileic", *ELSEWHERE}
"""Options that have no effect or are answered otherwise."""
FREE_STEP = 0.01  # [s] internal step of bodies and rods without lines
DRAG_AREA = 7  # word of a point without a force; its added mass is the next
LIFT = 10  # word of a line type: its lift coefficient


def ready_mooring(
    path: str | Path,
    *,
    fairleads: Mapping[str, tuple[float, ...] | None],
    sea: Callable[[float, float], Sea | None] = lambda *_: None,
    water: Mapping[str, float] = MappingProxyType({}),
    in_space: bool = False,
) -> Mooring:
    """The mooring of a MoorDyn file; what it moves from outside has fairleads, in MoorDyn's order.

    `sea` gives the water's motion for its depth [m] and gravity [m/s2]. `water` may give depth [m],
    density [kg/m³] and gravity that the file leaves out.

    Moved are coupled points and those of coupled bodies, both ends of coupled rods and of rods on
    coupled bodies, and the point where a coupled body or rod is pinned; pinned bodies come first,
    then rods, then points. `fairleads` names them and may give their start (x, z) or (x, y, z) [m];
    empty: fairlead_1, fairlead_2, …, of rods fairlead_1_a and fairlead_1_b.
    They move along Y, too, if they are `in_space`. Lines are line_1, line_2, …, and fixed and free
    points at which they end point_1, … by their numbers. InputError with every problem.
    """
    file = ReadFile(Path(path), {GIVEN[key]: value for key, value in water.items()})
    named = NamedFiles(file)
    check(file, named)
    InputError.raise_for(file.problems)
    attached = Attachments(file)
    attached.check()
    check_places(file, {row.words[0]: attached.place(row) for row in file.rows("points")})
    moved = list(attached.coupled())
    points = _fairleads(file, moved, fairleads, in_space=in_space)
    failures = tuple(_failure(file, row) for row in file.rows("failure"))
    inert = len(moved) > sum(row in file.rows("points") for row, _ in moved)
    if failures and inert:
        remedy = "let points of the body hold the lines"
        file.wrong(file.rows("failure")[0], "lines of coupled rods and pins do not fail", remedy)
    InputError.raise_for(file.problems)
    around = sea(file.depth, file.option("g", WATER["g"]))
    sloped = "seafloorfile" in file.options
    shallowest = 0.0 if sloped else file.depth
    lines = [f"line_{k + 1}" for k in range(len(file.rows("lines")))]
    segments = segments_of(file, attached, named, lines=lines, depth=shallowest)
    moving = with_moving_nodes(file, attached, segments)
    scheme, step = _integration(file, moving)
    _note(file, around)
    InputError.raise_for(file.problems)
    ropes = [word for row in file.rows("line types") for word in row.words[3:6]]
    level = file.option("currents", 0.0) == 0 and not sloped
    plain = level and bool(segments) and attached.simple() and all(map(number, ropes))
    net = net_of(file, attached, segments) if plain else None
    integration = [(repr(step), "dtM"), (scheme, "tScheme")]
    if around:
        integration.append(MOVING_WATER)
    return Mooring(
        text=text_of(file, attached, integration, known=bool(net)),
        fairleads=points,
        lines=tuple(segments),
        time_step=step,
        net=net,
        at_rest=file.option("tmaxic", 1.0) > 0,
        bed=-file.depth,
        drawn=_fairleads(file, moved, dict.fromkeys(fairleads), in_space=in_space),
        notes=tuple(file.notes),
        sea=around,
        scheme=scheme,
        kinds=kinds_of(segments, moving, bed=-shallowest),
        files=named.contents,
        ends=tuple(len(places) for _, places in moved),
        axes=tuple(_axis(places) for _, places in moved),
        inert=inert,
        moving=file.option("wavekin", 0.0) > 1 or file.option("currents", 0.0) > 0,
        failures=failures,
        no_way_back=_no_way_back(file),
        anchors=_named(file, attached.held),
        points=_named(file, attached.free),
    )


def _fairleads(
    file: ReadFile,
    moved: list[tuple[Row, tuple[Place, ...]]],
    given: Mapping[str, tuple[float, ...] | None],
    *,
    in_space: bool,
) -> tuple[Fairlead, ...]:
    """The fairleads of what is `moved`, under the names of `given` if there are any."""
    known = [
        (f"fairlead_{k + 1}{end}", place)
        for k, (_, places) in enumerate(moved)
        for end, place in zip(("_a", "_b") if len(places) > 1 else ("",), places, strict=True)
    ]
    names = list(given) or [name for name, _ in known]
    if len(names) != len(known):
        message = f"{len(known)} coupled points and ends of rods, but {len(names)} names in"
        remedy = "name each of them, in the order of MoorDyn: bodies, ends of rods, points"
        file.wrong(moved[0][0] if moved else None, f"{message} 'fairleads'", remedy)
        return ()
    found = []
    for name, (_, (x, y, z)) in zip(names, known, strict=True):
        place = given.get(name) or (x, y, z)
        y = place[1] if len(place) == 3 else y
        found.append(Fairlead(name, place[0], y, place[-1], moves_in_space=in_space))
    return tuple(found)


def _named(file: ReadFile, fits: Callable[[Row], bool]) -> dict[str, int]:
    """Names and numbers of points that fit, at which lines end."""
    used = {end for row in file.rows("lines") for end in ends_of(row)}
    numbers = [row.words[0] for row in file.rows("points") if fits(row) and row.words[0] in used]
    return {f"point_{number}": int(number) for number in numbers}


def _axis(places: tuple[Place, ...]) -> Place:
    """The direction from end A of a coupled rod to its end B; 0 of what has one fairlead."""
    x, y, z = np.subtract(places[-1], places[0]) / (math.dist(places[-1], places[0]) or 1.0)
    return float(x), float(y), float(z)


def _failure(file: ReadFile, row: Row) -> Failure:
    """A failure, of which a time or tension of 0 is never; unknown lines are problems."""
    _, point, names, time, tension = (*row.words[:5], *["0"] * (5 - len(row.words)))
    ends: list[tuple[int, int]] = []
    lines = {line.words[0]: (k, ends_of(line)) for k, line in enumerate(file.rows("lines"))}
    for name in names.split(","):
        k, at = lines.get(name, (0, []))
        ends += [(k, end) for end, where in enumerate(at) if where == end_name(point)]
        if end_name(point) not in at:
            file.wrong(row, f"line {name} does not end at {point}", "name one that does")
    return Failure(tuple(ends), float(time) or None, float(tension) or None)


def _integration(file: ReadFile, segments: dict[str, Segment]) -> tuple[str, float]:
    """Scheme and internal step [s]; what of them is not as the file says is noted.

    dtM goes before CFL, as in MoorDyn. A step that is not stable is shortened.
    """
    row = file.options.get("tscheme")
    asked = row.words[0].upper() if row else "RK2"
    scheme = asked if asked in SCHEMES else "RK4"
    if scheme != asked:
        file.notes.append(f"the time scheme {asked.lower()} of the file is replaced by {scheme}")
    step, wanted = file.options.get("dtm"), file.option("dtm", 0.0) or None
    if wanted is None and "cfl" in file.options and segments:
        step = file.options["cfl"]
        wanted = file.option("cfl", 0.0) * min(
            2 * math.pi * s.length * math.sqrt(s.mass_per_length / s.axial_stiffness)
            for s in segments.values()
        )
    longest = internal_step(segments, scheme=scheme, wanted=None) if segments else FREE_STEP
    if wanted is None or not segments or wanted <= longest / MARGIN:
        return scheme, wanted or longest
    name = " ".join(step.words[:2]) if step else ""
    file.notes.append(f"{name} of the file would be {wanted:.3g} s: steps are of {longest:.3g} s")
    return scheme, longest


def _no_way_back(file: ReadFile) -> str:
    """Why MoorDyn cannot go back in time: what of its state it does not save."""
    types = [row.words for row in file.rows("line types")]
    lost = {
        "the largest tensions of ropes of the Syrope model": any(
            words[3].startswith(SYROPE) for words in types
        ),
        "the oscillation of lines with a lift coefficient Cl": any(
            float(word) != 0 for words in types for word in words[LIFT : LIFT + 1]
        ),
    }
    return next((f"MoorDyn does not save {name}" for name, there in lost.items() if there), "")


def _note(file: ReadFile, around: Sea | None) -> None:
    """Note what is not as the file says, or needs to be known."""
    waves, currents = (file.option(key, 0.0) for key in ("wavekin", "currents"))
    if around and (waves > 1 or currents):
        row = file.options["wavekin" if waves > 1 else "currents"]
        message = f"{row.words[1]} {row.words[0]}, but the component moves the water as well"
        file.wrong(row, message, "leave out `waves` and `current` of the component, or set it to 0")
    if waves == 1 and not around:
        file.notes.append(
            "WaveKin 1 of the file: nothing gives water kinematics, lines are in still water: "
            "the section `waves` of the component moves it"
        )
    if waves > 1 or currents > 1:
        file.notes.append("waves and currents of the file begin with the run, at any start time")
    row = file.options.get("fileic")
    if row and row.words[0] != "0":
        file.notes.append(
            f"the initial state {row.words[0]} of the file is not used: lines start at rest"
        )


def segments_of(
    file: ReadFile,
    attached: Attachments,
    named: NamedFiles,
    *,
    lines: Iterable[str],
    depth: float,
    winches: Container[int] = (),
) -> dict[str, Segment]:
    """A segment of every line, under their names in `lines`.

    `depth` [m] is the least one of the seabed; the length of lines numbered in `winches` changes.
    """
    types = {row.words[0]: row.words for row in file.rows("line types")}
    held = {r.words[0]: float(r.words[4]) for r in file.rows("points") if attached.held(r)}
    friction = file.option("frictioncoefficient", 0.0) * file.option("fricdamp", FRICTION_DAMPING)
    found = {}
    points = {row.words[0]: row for row in file.rows("points") if attached.free(row)}
    for k, (name, row) in enumerate(zip(lines, file.rows("lines"), strict=True)):
        ends, length, count = ends_of(row), float(row.words[4]), int(float(row.words[5]))
        words = types[row.words[1]]
        d, m, cd, ca, cdax, caax = (float(words[k]) for k in (1, 2, 6, 7, 8, 9))
        ea, least, ba, rate = _rope(words, named)
        piece = length / count
        anchors = [held[end] for end in ends if end in held]
        clear = k not in winches and clear_of_seabed(anchors, length=length, depth=depth)
        density = file.option("rho", WATER["rho"])
        rates = [_decay(points[end], density, m * piece) for end in ends if end in points]
        ratio = damping_of_ratio(-ba, length=piece, mass_per_length=m, axial=ea)
        found[name] = Segment(
            length=piece,
            diameter=d,
            mass_per_length=m,
            axial_stiffness=ea,
            damping=ba if ba >= 0 else ratio,
            bending_stiffness=_slopes(words[5], named)[0],
            seabed_stiffness=0.0 if clear else file.option("kbot", SEABED["kbot"]),
            seabed_damping=0.0 if clear else file.option("cbot", SEABED["cbot"]),
            water_density=density,
            drag_coefficient=cd,
            added_mass_coefficient=ca,
            axial_drag_coefficient=cdax,
            axial_added_mass_coefficient=caax,
            friction=0.0 if clear else friction,
            decay=max(rate, *rates, 0.0),
            least_stiffness=least,
        )
    return found


def _decay(point: Row, density: float, mass: float) -> float:
    """Decay rate [1/s] of a free point by its drag, half a segment of `mass` [kg] at it."""
    k = DRAG_AREA + 3 * has_force(point)
    own, volume, area, added = (float(point.words[at]) for at in (5, 6, k, k + 1))
    whole = own + density * volume * added + mass / 2
    return density * area * FLOW / whole


def _rope(words: tuple[str, ...], named: NamedFiles) -> tuple[float, float, float, float]:
    """Largest and least stiffness [N] of a line type, its damping [N·s] and own decay rate [1/s].

    A viscoelastic rope has two elements in line, each a spring and damper beside each other. In
    fast motion both dampers are in line, and the stiffness is the dynamic one. The stretch of the
    slow element decays as both springs over both dampers (Line.cpp, `getStateDeriv`).
    """
    (slow, *fast), (damper, *second) = words[3].split("|"), words[4].split("|")
    (ea, least, largest), ba = _slopes(slow, named), float(damper)
    if not fast:
        return ea, least, ba, 0.0
    dynamic = float(fast[0])
    if len(fast) > 1:  # grows with the tension
        dynamic += float(fast[1]) * (largest or ea * STRAIN)
    both = ba + float((second or ["0"])[0])
    rate = (dynamic + ea * dynamic / max(abs(dynamic - ea), 1e-9 * ea)) / both if both else math.inf
    return max(ea, dynamic), least, ba * (both - ba) / both if both else 0.0, rate


def _slopes(word: str, named: NamedFiles) -> Slopes:
    """The slopes of a number or a curve of a line type."""
    return named.curves.get(word.removeprefix(SYROPE)) or (float(word), float(word), 0.0)


def with_moving_nodes(
    file: ReadFile, attached: Attachments, segments: dict[str, Segment]
) -> dict[str, Segment]:
    """Those of lines that have nodes, or an end, which MoorDyn moves."""
    fixed = {r.words[0] for r in file.rows("points") if attached.simple() and not attached.free(r)}
    pairs = zip(segments.items(), file.rows("lines"), strict=True)
    return {
        name: segment
        for (name, segment), row in pairs
        if int(float(row.words[5])) > 1 or not fixed.issuperset(ends_of(row))
    }


def net_of(
    file: ReadFile,
    attached: Attachments,
    segments: dict[str, Segment],
    names: Mapping[str, str] = MappingProxyType({}),
) -> NetData:
    """Points and lines for their static equilibrium, see `statics.Net`.

    `names` are those of points in warnings, by their number.
    """
    density, gravity = (file.option(key, value) for key, value in WATER.items())
    points = []
    for row in file.rows("points"):
        force, lift = None, 0.0
        if attached.free(row):
            mass, volume = (float(word) for word in row.words[5:7])
            load = [0.0, 0.0, 0.0]  # what stands behind drag and added mass may be a comment
            if has_force(row):
                load = [float(word) for word in row.words[7:10]]
            lift = gravity * volume * density
            force = (load[0], load[1], load[2] + lift - gravity * mass)
        name = names.get(row.words[0], f"point {row.words[0]}")
        known = {"name": name, "anchor": attached.held(row), "buoyancy": lift}
        points.append({"position": attached.place(row), "force": force, **known})
    lines = [
        {
            "ends": tuple(int(end) - 1 for end in ends_of(row)),
            "segments": int(float(row.words[5])),
            "length": float(row.words[4]),
            "stiffness": s.axial_stiffness,
            "bending": s.bending_stiffness,
            "weight": s.mass_per_length * gravity,
            "buoyancy": density * gravity * math.pi * s.diameter**2 / 4,
            "diameter": s.diameter,
            "drag": 0.5 * density * s.diameter * s.drag_coefficient,
            "axial_drag": 0.5 * density * s.diameter * math.pi * s.axial_drag_coefficient,
        }
        for row, s in zip(file.rows("lines"), segments.values(), strict=True)
    ]
    return {
        "points": points,
        "fairleads": [k for k, row in enumerate(file.rows("points")) if attached.moved(row)],
        "lines": lines,
        "bed": -file.depth,
        "bed_stiffness": file.option("kbot", SEABED["kbot"]),
    }


def text_of(
    file: ReadFile, attached: Attachments, integration: list[tuple[str, str]], *, known: bool
) -> str:
    """The file for MoorDyn: without blank lines, outputs, and coupled bodies.

    `integration` are values and names of options that go before those of the file.
    Where the equilibrium is not known otherwise, MoorDyn looks for it as the file says.
    """
    lines = ["MoorDyn v2 input file, after " + file.path.name]
    for section in TABLES:
        lines += table(section, [_row(section, row, attached) for row in file.rows(section)])
    ours = [*QUIET, *(RELAXATION if known else ()), *integration]
    replaced = REPLACED | {name.lower() for _, name in ours}
    if file.option("wavekin", 0.0) <= 1:
        replaced.add("wavekin")
    if "fileic" in file.options:  # without it the dynamic method may begin too far off
        replaced.add("icgendynamic")
    kept = [(row.words[0], key) for key, row in file.options.items() if key not in replaced]
    lines += [header("OPTIONS"), *(f"{value} {key}" for value, key in (*ours, *kept))]
    return "\n".join([*lines, header("OUTPUTS"), header("END"), ""])


def _row(section: str, row: Row, attached: Attachments) -> str:
    words = list(row.words)
    if section == "bodies" and words[1].upper() in COUPLED:
        words[1] = "Fixed"  # nothing is on it any more; the numbers of the others stay
    if section in SEGMENTS:  # MoorDyn reads 2e1 as 2
        k = SEGMENTS[section]
        words[k:] = [str(int(float(words[k]))), "-"]
    if section == "points" and BODY.fullmatch(words[1].upper()) and attached.moved(row):
        words[1:5] = ["Coupled", *map(repr, attached.place(row))]
    if section == "rods" and BODY.fullmatch(words[2].upper()) and attached.moved(row, 2):
        words[2] = "CoupledPinned" if attached.hinged(row) else "Coupled"
        words[ENDS] = [repr(c) for place in attached.rod_ends(row) for c in place]
    return " ".join(words)
