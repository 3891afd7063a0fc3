"""A MoorDyn v2 input file that somebody else wrote, as a mooring.

Everything that would abort the process, be ignored silently, or make a state that cannot be saved
and restored is refused. The physics of an accepted file is not touched; its output switches are
turned off, its internal step is written out, and what is taken otherwise is in the mooring's notes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.moordyn.line_file import MOVING_WATER, QUIET, RELAXATION, header
from m4e_adapters.moordyn.mooring import (
    Fairlead,
    Mooring,
    NetData,
    Sea,
    fastest_water,
    internal_step,
    net_line,
)
from m4e_adapters.moordyn.ready_files.attachments import BODY, COUPLED, Attachments, ends_of
from m4e_adapters.moordyn.ready_files.checks import SEGMENTS, check, check_places
from m4e_adapters.moordyn.ready_files.read_file import (
    TABLES,
    ReadFile,
    Row,
    has_force,
    option_name,
)
from m4e_adapters.moordyn.stability import (
    SCHEMES,
    SPEED,
    Segment,
    clear_of_seabed,
    damping_of_ratio,
)
from m4e_fmi.errors import InputError

SEABED = {"kbot": 3.0e6, "cbot": 3.0e5}  # MoorDyn's own, Pa/m and Pa·s/m
WATER = {"rho": 1025.0, "g": 9.80665}  # MoorDyn's own
FRICTION_DAMPING = 200.0  # MoorDyn's own FricDamp
REPLACED = {"cfl", "writeunits", "dtout", "fileic", "wavekin"}
"""Options that have no effect or are answered otherwise."""


def ready_mooring(
    path: str | Path,
    *,
    fairleads: Mapping[str, tuple[float, ...] | None],
    sea: Callable[[float, float], Sea | None] = lambda *_: None,
) -> Mooring:
    """The mooring of a MoorDyn file; its moved points are the fairleads, in file order.

    `sea` gives the water's motion for its depth [m] and gravity [m/s2].

    Moved are coupled points and the points of coupled bodies. `fairleads` names them and may give
    their start (x, z) or (x, y, z) [m]; empty: fairlead_1, fairlead_2, …
    Lines are line_1, line_2, … InputError with every problem.
    """
    file = ReadFile(Path(path))
    check(file)
    InputError.raise_for(file.problems)
    attached = Attachments(file)
    attached.check()
    check_places(file, {row.words[0]: attached.place(row) for row in file.rows("points")})
    points = _fairleads(file, attached, fairleads)
    InputError.raise_for(file.problems)
    moved = sea(file.depth, file.option("g", WATER["g"]))
    segments = _segments(file, attached, speed=SPEED + (moved.speed if moved else 0.0))
    moving = _with_moving_nodes(file, attached, segments)
    scheme, step, notes = _integration(file, moving)
    notes = (*notes, *_notes(file, simple=attached.simple(), still=moved is None))
    InputError.raise_for(file.problems)
    net = _net(file, attached, segments) if attached.simple() else None
    integration = [(repr(step), "dtM"), (scheme, "tScheme")]
    if moved:
        integration.append(MOVING_WATER)
    return Mooring(
        text=_text(file, attached, integration, known=bool(net)),
        fairleads=points,
        lines=tuple(segments),
        time_step=step,
        net=net,
        at_rest=file.option("tmaxic", 1.0) > 0,
        bed=-file.depth,
        scheme=scheme,
        drawn=_fairleads(file, attached, dict.fromkeys(fairleads)),
        notes=notes,
        sea=moved,
        fastest=fastest_water(moving, scheme=scheme, step=step),
    )


def _fairleads(
    file: ReadFile, attached: Attachments, given: Mapping[str, tuple[float, ...] | None]
) -> tuple[Fairlead, ...]:
    """The moved points, under the names of `given` if there are any."""
    rows = [row for row in file.rows("points") if attached.moved(row)]
    names = list(given) or [f"fairlead_{k + 1}" for k in range(len(rows))]
    if not rows:
        remedy = "give the points that a body moves the type 'Coupled'"
        file.wrong(None, "there is no coupled point, nor one on a coupled body", remedy)
    elif len(names) != len(rows):
        message = f"{len(rows)} coupled points, but {len(names)} names in 'fairleads'"
        file.wrong(rows[0], message, "name each coupled point, in the order of the file")
    if file.problems:
        return ()
    found = []
    for name, row in zip(names, rows, strict=True):
        x, y, z = attached.place(row)
        place = given.get(name) or (x, y, z)
        found.append(Fairlead(name, place[0], place[1] if len(place) == 3 else y, place[-1]))
    return tuple(found)


def _integration(
    file: ReadFile, segments: dict[str, Segment]
) -> tuple[str, float, tuple[str, ...]]:
    """Scheme and internal step [s], and what of them is not as the file says.

    dtM goes before CFL, as in MoorDyn; a dtM that is unstable is a problem. A step by CFL, or for a
    scheme without a stability bound here, is shortened where it is too long.
    """
    row = file.options.get("tscheme")
    asked = row.words[0].upper() if row else "RK2"
    scheme = asked if asked in SCHEMES else "RK4"
    changed = f"the time scheme {asked.lower()} of the file is replaced by {scheme}"
    notes = () if scheme == asked else (changed,)
    step, wanted = file.options.get("dtm"), file.option("dtm", 0.0) or None
    if wanted is None and "cfl" in file.options and segments:
        step = file.options["cfl"]
        wanted = file.option("cfl", 0.0) * min(
            2 * math.pi * s.length * math.sqrt(s.mass_per_length / s.axial_stiffness)
            for s in segments.values()
        )
    try:
        chosen = internal_step(segments, scheme=scheme, wanted=None)
        if wanted is not None and ((not notes and "dtm" in file.options) or wanted <= chosen):
            chosen = internal_step(segments, scheme=scheme, wanted=wanted)
    except InputError as error:
        for problem in error.problems:
            file.wrong(step, problem.message, problem.remedy)
        return scheme, 0.0, ()
    if step is not None and wanted is not None and chosen < wanted:
        name = " ".join(step.words[:2])
        notes = (*notes, f"{name} of the file would be {wanted:.3g} s: steps are of {chosen:.3g} s")
    return scheme, chosen, notes


def _notes(file: ReadFile, *, simple: bool, still: bool) -> list[str]:
    notes = []
    if still and file.option("wavekin", 0.0) == 1:
        notes.append(
            "WaveKin 1 of the file: nothing gives water kinematics, lines are in still water: "
            "the section `waves` of the component moves it"
        )
    row = file.options.get("fileic")
    if row and row.words[0] != "0" and not simple:
        message = f"{row.words[1]} {row.words[0]}: initial conditions from files are not supported"
        remedy = f"set {row.words[1]} to 0; without rods and free bodies it would not be needed"
        file.wrong(row, message, remedy)
    elif row and row.words[0] != "0":
        notes.append(
            f"the initial state {row.words[0]} of the file is not used: lines start at rest"
        )
    return notes


def _segments(file: ReadFile, attached: Attachments, *, speed: float) -> dict[str, Segment]:
    """A segment of every line, at most at `speed` [m/s] in the water."""
    types = {row.words[0]: row.words for row in file.rows("line types")}
    held = {r.words[0]: float(r.words[4]) for r in file.rows("points") if attached.held(r)}
    friction = file.option("frictioncoefficient", 0.0) * file.option("fricdamp", FRICTION_DAMPING)
    found = {}
    for k, row in enumerate(file.rows("lines")):
        ends, length, count = ends_of(row), float(row.words[4]), int(float(row.words[5]))
        d, m, ea, ba, ei, cd, ca, cdax, caax = (float(w) for w in types[row.words[1]][1:10])
        piece = length / count
        anchors = [held[end] for end in ends if end in held]
        clear = clear_of_seabed(anchors, length=length, depth=file.depth)
        ratio = damping_of_ratio(-ba, length=piece, mass_per_length=m, axial=ea)
        found[f"line_{k + 1}"] = Segment(
            length=piece,
            diameter=d,
            mass_per_length=m,
            axial_stiffness=ea,
            damping=ba if ba >= 0 else ratio,
            bending_stiffness=ei,
            seabed_stiffness=0.0 if clear else file.option("kbot", SEABED["kbot"]),
            seabed_damping=0.0 if clear else file.option("cbot", SEABED["cbot"]),
            water_density=file.option("rho", WATER["rho"]),
            drag_coefficient=cd,
            added_mass_coefficient=ca,
            axial_drag_coefficient=cdax,
            axial_added_mass_coefficient=caax,
            friction=friction,
            speed=speed,
        )
    return found


def _with_moving_nodes(
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


def _net(file: ReadFile, attached: Attachments, segments: dict[str, Segment]) -> NetData:
    """Points and lines for their static equilibrium, see `statics.Net`."""
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
        known = {"name": f"point {row.words[0]}", "anchor": attached.held(row), "buoyancy": lift}
        points.append({"position": attached.place(row), "force": force, **known})
    pairs = zip(file.rows("lines"), segments.values(), strict=True)
    lines = [
        net_line(
            segment,
            ends=tuple(int(end) - 1 for end in ends_of(row)),
            count=int(float(row.words[5])),
            length=float(row.words[4]),
            gravity=gravity,
        )
        for row, segment in pairs
    ]
    return {
        "points": points,
        "fairleads": [k for k, row in enumerate(file.rows("points")) if attached.moved(row)],
        "lines": lines,
        "bed": -file.depth,
        "bed_stiffness": file.option("kbot", SEABED["kbot"]),
    }


def _text(
    file: ReadFile, attached: Attachments, integration: list[tuple[str, str]], *, known: bool
) -> str:
    """The file for MoorDyn: without blank lines, outputs, and coupled bodies.

    Where the equilibrium is not known otherwise, MoorDyn looks for it as the file says.
    """
    lines = ["MoorDyn v2 input file, after " + file.path.name]
    for section in TABLES:
        rows = [_row(section, row, attached) for row in file.rows(section)]
        if rows:
            lines += [header(section.upper()), "-", "-", *rows]
    ours = [*QUIET, *(RELAXATION if known else ()), *integration]
    replaced = REPLACED | {name.lower() for _, name in ours}
    kept = [r.words[:2] for r in file.rows("options") if option_name(r) not in replaced]
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
    return " ".join(words)
