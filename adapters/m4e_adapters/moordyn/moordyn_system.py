"""One system in MoorDyn's memory: created, stepped, saved, freed.

Travels inside the FMU: imports NumPy and its neighbours that travel as well. SI units; positions,
velocities and forces are in the world frame, Z up, x, y, z of one fairlead after the other.
MoorDyn's C functions and the loop over them (`lines.c` of the runtime) are called by ctypes;
`import moordyn` only finds them.

MoorDyn 2.7.2 has habits that this module answers:

- `Serialize` turns numbers below 2e-308 (as of a line that leaves its plane by rounding) into
  numbers of 1e300; they are made 0.
- What breaks a line cannot be taken back: a system with parted lines is another one, with ends on
  points of their own, that gets the state of the old one.
- It writes to the console whatever its options say, and a file beside its input.
"""

import contextlib
import ctypes
import importlib.util
import os
import re
import sys
import tempfile
from array import array
from ctypes import byref, c_double, c_int, c_int32, c_size_t, c_uint32, c_void_p
from functools import cache
from itertools import chain
from math import hypot, isfinite, nan
from pathlib import Path

import numpy as np

from .rest import with_points

INSTALL = "pip install moordyn==2.7.2"
REPORT_LENGTH = 6  # lines of MoorDyn's own report that go into an error message
FIRST_GUESS = "Catenary initial profile"  # of no interest where the equilibrium is known
WARNING = re.compile(r"^WRN |warning", re.IGNORECASE)  # a line of MoorDyn's report that warns
SOURCE_PLACE = re.compile(r"^(ERR|WRN) \S+:\d+ \w+\(\): ")  # of MoorDyn's own source files
# an exponent below -1022 that became negative has the bits of a large one
DENORMAL, SMALL_NEGATIVE = 0xFCD << 52, 2**64 - 2**31
START_STEP = 1e-12  # [s] length of the call that evaluates the forces at the start
SILENT = 0xFFFF  # log level of no messages
RELAXED = 3  # internal steps of MoorDyn's relaxation in the longest one: lines go slack, and land
CLOCK = 3  # numbers of the state before those of fairleads
FAILURES = {
    1: "MoorDyn reports an error",
    2: "a force or a place is not a finite number",
    3: "the motion of the water is not known",
}


class MooringError(RuntimeError):
    """MoorDyn could not do what was asked; the text says what, when and what to try."""


class Lines(ctypes.Structure):
    """`m4e_lines` of lines.h."""

    _fields_ = [
        *((name, c_void_p) for name in (
            "step", "set_dt", "set_water", "node_position", "node_velocity", "node_force",
            "node_tension", "set_length", "set_rate", "sample", "system", "line", "segments",
            "ends", "axes", "fixed", "winch", "kinds", "lengths",
        )),
        *((name, c_uint32) for name in ("lines", "fairleads", "objects", "winches", "nodes")),
        *((name, c_int32) for name in ("inert", "moving")),
        ("order", c_uint32),
        *((name, c_double) for name in ("share", "longest", "interval")),
        *((name, c_void_p) for name in ("water", "state", "work")),
    ]  # fmt: skip


_CALLED = {
    "step": "Step",
    "set_dt": "SetDt",
    "set_water": "ExternalWaveKinSet",
    "node_position": "GetLineNodePos",
    "node_velocity": "GetLineNodeVel",
    "node_force": "GetLineNodeForce",
    "node_tension": "GetLineNodeTen",
    "set_length": "SetLineUnstretchedLength",
    "set_rate": "SetLineUnstretchedLengthVel",
}
"""Field of `Lines` → MoorDyn's function."""
_SAMPLE = ctypes.CFUNCTYPE(c_int, c_double, c_double)
_UNSIGNED, _VECTOR = c_uint32, c_double * 3
_RESULTS = {"Create": c_void_p, "GetLine": c_void_p}
_ARGUMENTS = {
    "Create": (ctypes.c_char_p,),
    **dict.fromkeys(("Init", "Init_NoIC"), (c_void_p, c_void_p, c_void_p)),
    **dict.fromkeys(("SaveState", "LoadState"), (c_void_p, ctypes.c_char_p)),
    "Close": (c_void_p,),
    "SetDt": (c_void_p, c_double),
    "SetVerbosity": (c_void_p, c_int),
    "GetLine": (c_void_p, _UNSIGNED),
    "GetLineN": (c_void_p, c_void_p),
    "GetLineUnstretchedLength": (c_void_p, c_void_p),
    "Serialize": (c_void_p, c_void_p, c_void_p),
    "Deserialize": (c_void_p, ctypes.c_char_p),
    **dict.fromkeys(
        ("GetLineNodePos", "GetLineNodeVel", "GetLineNodeForce", "GetLineNodeTen"),
        (c_void_p, _UNSIGNED, c_void_p),
    ),
    "ExternalWaveKinInit": (c_void_p, c_void_p),
    "ExternalWaveKinGetCoordinates": (c_void_p, c_void_p),
}

_LOOP = {
    **dict.fromkeys(("evaluate", "settle"), (ctypes.POINTER(Lines), c_void_p)),
    "advance": (ctypes.POINTER(Lines), c_double, c_double, c_void_p, c_void_p, c_void_p),
    "nodes": (ctypes.POINTER(Lines), c_uint32, c_void_p),
}


@cache
def moordyn():
    """MoorDyn's library; MooringError if it is not installed."""
    found = importlib.util.find_spec("moordyn")
    folder = Path(found.origin).parents[1] if found and found.origin else Path()
    places = [*folder.glob("moordyn.libs/*moordyn*"), *folder.glob("moordyn/.dylibs/*moordyn*")]
    if not places:
        raise MooringError(f"MoorDyn is not installed for {sys.executable}: {INSTALL}")
    return _library(places[0], "MoorDyn_", _ARGUMENTS)


@cache
def _runtime(path):
    """The runtime's library at `path`, kept for the process: the folder may go."""
    return _library(path, "m4e_lines_", _LOOP)


def _library(path, prefix, arguments):
    library = ctypes.CDLL(str(path))
    for name, types in arguments.items():
        function = getattr(library, prefix + name)
        function.argtypes, function.restype = types, _RESULTS.get(name, c_int)
    return library


class MoorDynSystem:
    """Lines and fairleads in MoorDyn's memory, from `create` to `close`.

    Parameters
    ----------
    files
        Name and content of the files that input texts name.
    runtime
        Path of the runtime's library.
    ends
        Of each coupled object in MoorDyn's order 1, or 2 for a rod, whose ends are two fairleads.
    axes
        Of each coupled object the direction (x, y, z) of a rod as drawn.
    inert
        True if coupled objects have masses of their own (rods, pinned ends).
    moving
        True if the water moves.
    lines
        The number of lines.
    fixed
        The fixed y coordinate [m] of each fairlead, None of those that move in space.
    winches
        Numbers, from 0, of the lines whose length is set.
    time_step, share
        The longest internal step [s], and the longest part of a stable one.
    order
        Of MoorDyn's Runge-Kutta method, 2 or 4.
    kinds
        Of each line the 15 numbers of `m4e_line_kind`, see `stability.kind`.
    place
        The folder for MoorDyn's files; the system's temporary one if it is None or cannot be
        used.
    course
        The motion of the water at the nodes, a `water_course.WaterCourse`; None if it stands
        still, or moves as the text says.

    Attributes
    ----------
    lengths, segments
        Unstretched length [m] and number of segments of each line.
    forces, end_forces, end_places
        Forces [N] on fairleads, and of ends A and B of each line on what holds them, and the places
        [m] of these ends: flat.
    """

    def __init__(self, *, files, runtime, ends, axes, inert, moving, lines, fixed,
                 winches, time_step, share, order, kinds, course, place=None):  # fmt: skip
        self._files, self._place = files, place
        self._winches, self._library = list(winches), _runtime(runtime)
        self._system = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self.lengths, self.segments = [], []
        self._size = c_size_t()  # bytes of a saved state
        self.course = course
        self._failure: Exception | None = None  # of the motion of the water
        count = 3 * len(fixed)
        room = CLOCK + 6 * count + 12 * lines
        self.state = (c_double * (room + len(self._winches)))()
        sizes = ctypes.sizeof(c_double)
        view = (c_double * count).from_buffer
        self.forces = view(self.state, (CLOCK + 3 * count) * sizes)
        self.position = view(self.state, CLOCK * sizes)
        self.end_forces = (c_double * (6 * lines)).from_buffer(
            self.state, (CLOCK + 6 * count) * sizes
        )
        self.end_places = (c_double * (6 * lines)).from_buffer(
            self.state, (CLOCK + 6 * count + 6 * lines) * sizes
        )
        self._arrays = {
            "line": (c_void_p * lines)(),
            "segments": (c_uint32 * lines)(),
            "ends": (c_uint32 * len(ends))(*ends),
            "axes": (c_double * (3 * len(ends)))(*chain.from_iterable(axes)),
            "fixed": (c_double * len(fixed))(*[nan if y is None else y for y in fixed]),
            "winch": (c_uint32 * len(self._winches))(*self._winches),
            "state": self.state,
            "kinds": (c_double * (15 * lines))(*chain.from_iterable(kinds)),
            "lengths": (c_double * lines)(),
        }
        self._sample = _SAMPLE(self._sampled)
        self._lines = Lines(
            lines=lines,
            fairleads=len(fixed),
            objects=len(ends),
            winches=len(self._winches),
            inert=inert,
            moving=moving,
            longest=time_step,
            interval=course.longest if course else float("inf"),
            order=order,
            share=share,
            sample=ctypes.cast(self._sample, c_void_p),
            **{name: ctypes.cast(values, c_void_p) for name, values in self._arrays.items()},
            **{
                field: ctypes.cast(getattr(moordyn(), f"MoorDyn_{name}"), c_void_p)
                for field, name in _CALLED.items()
            },
        )

        self._at = byref(self._lines)
        given = c_double * (count - sum(y is not None for y in fixed))
        self._position, self._velocity = given(), given()
        self._winch = (c_double * (2 * len(self._winches)))()

    @property
    def running(self):
        """True between `create` and `close`."""
        return self._system is not None

    def create(self, text, position, *, search=False, change=None):
        """Make the system of `text` with fairleads at these places [m]; return what MoorDyn wrote.

        With `search` MoorDyn looks for the equilibrium of the lines; else they begin straight, or
        with the state file that `change` makes of that one's. MooringError if that fails.
        """
        self.close()
        # a .out file appears beside the input, so every system has a folder of its own
        self._folder = _new_folder(self._place)
        folder = Path(self._folder.name)
        (folder / "lines.txt").write_text(text, encoding="utf-8")
        for name, content in self._files.items():
            (folder / name).write_bytes(content)
        with console_kept() as console:
            failed = self._made(folder, position, search)
            if not failed and change:
                path = folder / "lines.state"
                path.write_bytes(change(self._state_file(path)))
                moordyn().MoorDyn_LoadState(self._system, str(path).encode())
        if failed:
            self.close()
            raise MooringError(_not_started(position, *console))
        self._connect()
        return "".join(console)

    def begin(self, position, lengths, t):
        """Take the forces at rest at t [s]: fairleads at `position`, winches at `lengths` [m]."""
        self.state[:] = [0.0] * len(self.state)
        self.state[:2] = t, START_STEP
        self.position[:] = position
        self.state[len(self.state) - len(self._winches) :] = lengths
        if self.course:
            self.course.be_calm(self)
        self.evaluate()

    def replace(self, text, points):
        """Go on as the system of `text`, which has free points more, at (position, velocity).

        Its other objects are where they are; `points` are flat, [m] and [m/s].
        """
        with tempfile.TemporaryDirectory() as folder, console_kept():
            old = self._state_file(Path(folder) / "lines.state")
        extended = with_points(old, points, self._lines.lines)
        self.create(text, list(self.position), change=lambda _: extended)
        if self.course:
            self.course.begin(self, self.state[0])
        count = len(self.position)
        self.evaluate(self.state[CLOCK + 5 * count : CLOCK + 6 * count])

    def recreate(self, text, state):
        """Begin anew with `text`, at the fairleads of a `state`, for `take_back`."""
        self.state[:] = array("d", state)
        self.create(text, list(self.position))
        self.state[1] = START_STEP
        self.evaluate()  # before its first step MoorDyn would write a time that it has not set

    def _state_file(self, path):
        """The bytes of a state file of the system as it is, which is `path`."""
        moordyn().MoorDyn_SaveState(self._system, str(path).encode())
        return path.read_bytes()

    def end_motion(self, line, end):
        """(x, y, z) [m] and velocity [m/s] of end A (0) or B (1) of a line: six numbers."""
        node = end * self.segments[line]
        return [*self.node_position(line, node), *self.node_velocity(line, node)]

    def length(self, line):
        """Unstretched length [m] of a line now, by its number from 0."""
        if line in self._winches:
            return self.state[len(self.state) - len(self._winches) + self._winches.index(line)]
        return self.lengths[line]

    def _made(self, folder, position, search):
        """Let MoorDyn begin there; True if it fails."""
        library = moordyn()
        with contextlib.chdir(folder) if self._files else contextlib.nullcontext():
            # it looks for the file of the seabed where the program runs
            self._system = library.MoorDyn_Create(str(folder / "lines.txt").encode())
        if not self._system:
            return True
        if search:
            library.MoorDyn_SetDt(self._system, self._lines.longest / RELAXED)
        initialise = library.MoorDyn_Init if search else library.MoorDyn_Init_NoIC
        at = self._poses(position)
        return initialise(self._system, at, (c_double * len(at))()) != 0

    def _poses(self, position):
        """MoorDyn's motion vector of fairleads at `position`: rods are as drawn, where they are."""
        at, n = [], 0
        for count in self._arrays["ends"]:
            at += [*position[n : n + 3], *([0.0] * 3 if count == 2 else [])]
            n += 3 * count
        return (c_double * max(1, len(at)))(*at)

    def _connect(self):
        """Let the loop know the system and its lines."""
        library, lines = moordyn(), self._lines
        library.MoorDyn_SetVerbosity(self._system, SILENT)
        if os.name == "posix" and self._folder:  # open files need no name, and a kill leaves none
            self._folder.cleanup()
        self.lengths = []
        for k in range(lines.lines):
            line = library.MoorDyn_GetLine(self._system, k + 1)
            count, length = c_uint32(), c_double()
            library.MoorDyn_GetLineN(line, byref(count))
            library.MoorDyn_GetLineUnstretchedLength(line, byref(length))
            self._arrays["line"][k], self._arrays["segments"][k] = line, count.value
            self.lengths.append(length.value)
        self.segments, self._arrays["lengths"][:] = list(self._arrays["segments"]), self.lengths
        room = 33 * lines.fairleads + 6 * (max(self.segments, default=0) + 1)
        self._arrays["work"] = (c_double * room)()
        lines.work = ctypes.addressof(self._arrays["work"])
        lines.system = self._system
        self._size = c_size_t()
        if self.course:
            nodes = c_uint32()
            library.MoorDyn_ExternalWaveKinInit(self._system, byref(nodes))
            lines.nodes = nodes.value
            water = self.course.room(nodes.value)
            lines.water = ctypes.addressof(water)

    def evaluate(self, velocity=None):
        """Take the forces with fairleads where they are, at this velocity [m/s] or at rest."""
        given = (c_double * len(self.position))(*(velocity or ()))
        self._done(self._library.m4e_lines_evaluate(self._at, given))
        # before its first step MoorDyn would write a time that it has not set, and may never end
        if not self._size.value:
            moordyn().MoorDyn_Serialize(self._system, byref(self._size), None)

    def settle(self, velocity):
        """Let the fairleads have this velocity [m/s] now, if it is another than was given last.

        Forces follow: the axial damping of a line and the drag on its end depend on it.
        """
        self._velocity[:] = [*chain(*velocity)]
        self._done(self._library.m4e_lines_settle(self._at, self._velocity))

    def step(self, t, h, position, velocity, winch):
        """A step as of `LineSystem.advance`."""
        self._position[:], self._velocity[:] = [*chain(*position)], [*chain(*velocity)]
        self._winch[:] = winch
        given = self._position, self._velocity, self._winch
        self._done(self._library.m4e_lines_advance(self._at, t, h, *given))

    def _done(self, status):
        if status:
            if self._failure is not None:
                failure, self._failure = self._failure, None
                raise failure
            raise MooringError(self._broken(FAILURES[status]))

    def _sampled(self, t, end):
        """The loop asks for the motion of the water from t to `end` [s]; 0 if it has it."""
        try:
            self.course.sample(self, t, end)
        except Exception as error:  # noqa: BLE001  no exception crosses the loop
            self._failure = error
            return 1
        return 0

    def _broken(self, reason):
        """Error message of a step that failed, with the place that failed first."""
        where = ""
        for k, count in enumerate(self.segments):
            lost = [n for n in range(1, count) if not all(map(isfinite, self.node_position(k, n)))]
            if lost:
                middle = lost[len(lost) // 2]
                where += f", line {k + 1} at segment {middle} of {count}"
        return (
            f"MoorDyn failed after t = {self.state[0]:.9g} s ({reason}{where}): fairleads that "
            f"jump, or an internal step that is too long; try a smaller communication step or a "
            f"solver time_step of {self._lines.longest / 2:.3g} s"
        )

    def nodes(self):
        """Places [m] and velocities [m/s] where the water's motion is wanted: flat, (x, y, z).

        All nodes of the lines come first, then rods, points and bodies, whose velocity is 0 here.
        """
        places = (c_double * (3 * self._lines.nodes))()
        moordyn().MoorDyn_ExternalWaveKinGetCoordinates(self._system, places)
        nodes = ((k, n) for k, last in enumerate(self.segments) for n in range(last + 1))
        speeds = [*chain.from_iterable(self.node_velocity(*node) for node in nodes)]
        return places, speeds + [0.0] * (len(places) - len(speeds))

    def _read(self, what, line, node):
        """(x, y, z) of a node of a line, both from 0; nan where MoorDyn has no number."""
        value = _VECTOR()
        failed = getattr(moordyn(), f"MoorDyn_{what}")(self._arrays["line"][line], node, value)
        return (nan,) * 3 if failed else tuple(value)

    def inner_forces(self):
        """The largest force [N] on an inner node of each line; 0 if it has none."""
        return [
            max(
                (hypot(*self._read("GetLineNodeForce", line, k)) for k in range(1, last)),
                default=0.0,
            )
            for line, last in enumerate(self.segments)
        ]

    def node_position(self, line, node):
        """(x, y, z) [m] of a node of a line, both by their numbers from 0."""
        return self._read("GetLineNodePos", line, node)

    def along(self, line):
        """x, y, z [m] and tension [N] at each node of a line, by its number from 0: flat.

        The tension is the mean of the segments beside it, with their damping.
        """
        rows = (c_double * (4 * self.segments[line] + 4))()
        self._library.m4e_lines_nodes(self._at, line, rows)
        return rows[:]

    def node_velocity(self, line, node):
        """(x, y, z) [m/s] of a node of a line."""
        return self._read("GetLineNodeVel", line, node)

    def saved(self):
        """All of MoorDyn's state, as bytes."""
        library = moordyn()
        words = np.frombuffer(bytearray(self._size.value), "u8")
        library.MoorDyn_Serialize(self._system, None, words.ctypes.data)
        words[(words >= DENORMAL) & (words < SMALL_NEGATIVE)] = 0
        return words.tobytes()

    def take_back(self, system, state):
        """Go back to `system` that `saved` returned, and the `state` of that time.

        MooringError if its size is that of other lines.
        """
        # MoorDyn reads beyond the end of bytes that are too few
        if len(system) != self._size.value or len(state) != ctypes.sizeof(self.state):
            raise MooringError("the saved state is not one of these lines")
        moordyn().MoorDyn_Deserialize(self._system, system)
        self.state[:] = array("d", state)

    def close(self):
        """Free MoorDyn's memory and files; the system can be created again."""
        if self._system:
            moordyn().MoorDyn_Close(self._system)
        self._system = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None


def with_free_ends(text, groups):
    """A MoorDyn input text with each group of (line, end) at a free point of its own."""
    rows = text.splitlines()
    points, lines = _table(rows, "POINTS"), _table(rows, "LINES")
    last = len(points)
    for n, group in enumerate(groups, last + 1):
        for line, end in group:
            words = rows[lines[line]].split()
            words[2 + end] = str(n)
            rows[lines[line]] = " ".join(words)
    free = [f"{last + n} Free 0 0 {-n} 0 0 0 0" for n in range(1, len(groups) + 1)]
    rows[points.stop : points.stop] = free
    return "\n".join([*rows, ""])


def _table(rows, title):
    """Numbers of the rows of a table, below names and units."""
    opening = [k for k, row in enumerate(rows) if "---" in row]
    begin = next(k for k in opening if rows[k].strip("- ") == title)
    return range(begin + 3, next(k for k in opening if k > begin))


def warnings_in(report, *, equilibrium_known):
    """Warnings in what MoorDyn wrote while it started, without the places in its source."""
    lines = [line.strip() for line in report.splitlines() if WARNING.search(line)]
    lines = [line for line in lines if not (equilibrium_known and FIRST_GUESS in line)]
    return [f"MoorDyn: {SOURCE_PLACE.sub('', line)}" for line in lines]


def _new_folder(place):
    """A temporary folder in `place`, with which it goes if this process is killed."""
    options = {"prefix": "m4e_mooring_", "ignore_cleanup_errors": True}
    if place is not None and str(place).isascii():  # MoorDyn takes no other paths on Windows
        with contextlib.suppress(OSError):  # as where the FMU's files cannot be changed
            return tempfile.TemporaryDirectory(dir=place, **options)
    return tempfile.TemporaryDirectory(**options)


def _not_started(position, report):
    """Error message with the end of what MoorDyn wrote, without the places in its source."""
    points = [position[k : k + 3] for k in range(0, len(position), 3)]
    places = ", ".join(f"({', '.join(f'{c:.6g}' for c in point)})" for point in points)
    lines = [line for line in report.splitlines() if line.strip()]
    tail = "\n".join(SOURCE_PLACE.sub("", line) for line in lines[-REPORT_LENGTH:])
    return (
        f"MoorDyn cannot start with the fairleads at {places} m: check these positions "
        f"against the anchors and the lengths of the lines. It reports:\n{tail}"
    )


@contextlib.contextmanager
def console_kept():
    """Keep the process's standard output and error, C++ included; a list that gets them at last."""
    with tempfile.TemporaryFile() as file:
        console = []
        _flush_c_streams()
        saved = []
        try:
            for descriptor in (1, 2):
                with contextlib.suppress(OSError):  # closed, as in a program without a console
                    saved.append((descriptor, os.dup(descriptor)))
                    os.dup2(file.fileno(), descriptor)
            yield console
        finally:
            _flush_c_streams()
            for descriptor, copy in saved:
                os.dup2(copy, descriptor)
                os.close(copy)
            file.seek(0)
            console.append(file.read().decode("utf-8", "replace"))


def _flush_c_streams():
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)
