"""One system in MoorDyn's memory: created, stepped, saved, freed.

Travels inside the FMU: imports the standard library, `moordyn` and its neighbours that travel as
well. SI units; positions, velocities and forces are in the world frame, Z up.

MoorDyn 2.7.2 has habits that this module answers:

- `Deserialize`, `SaveState` and `LoadState` release a reference to `None` that they do not own; it
  is taken again.
- `Serialize` turns numbers below 2e-308 (as of a line that leaves its plane by rounding) into
  numbers of 1e300; they are made 0.
- With water that moves, a node that is not a number ends the process; nodes are looked at.
- It writes to the console whatever its options say, and a file beside its input.
"""

import contextlib
import ctypes
import os
import re
import sys
import tempfile
from array import array
from math import hypot, isfinite
from pathlib import Path

from .rest import with_nodes

INSTALL = "pip install moordyn==2.7.2"
DENORMAL, SMALL_NEGATIVE = 0xFCD << 52, 2**64 - 2**31  # words from the first on; whole numbers
REPORT_LENGTH = 6  # lines of MoorDyn's own report that go into an error message
FIRST_GUESS = "Catenary initial profile"  # of no interest where the equilibrium is known
WARNING = re.compile(r"^WRN |warning", re.IGNORECASE)  # a line of MoorDyn's report that warns
SOURCE_PLACE = re.compile(r"^(ERR|WRN) \S+:\d+ \w+\(\): ")  # of MoorDyn's own source files


class MooringError(RuntimeError):
    """MoorDyn could not do what was asked; the text says what, when and what to try."""


class _NotInstalled:
    """Stand-in for MoorDyn that raises where it is used: an import error would end the host."""

    def __getattr__(self, _):
        raise MooringError(f"MoorDyn is not installed for {sys.executable}: {INSTALL}")


try:
    import cmoordyn
    import moordyn
except ImportError:
    moordyn = cmoordyn = _NotInstalled()


class MoorDynSystem:
    """Lines and fairleads in MoorDyn's memory, from `create` to `close`.

    Parameters
    ----------
    text
        MoorDyn v2 input file; its coupled objects are points only.
    y
        The fixed y coordinate [m] of each coupled point, in MoorDyn's order, None of one that moves
        in space: its positions, velocities and forces have three components, others two (x, z).
    lines
        The number of lines.
    place
        The folder for MoorDyn's files; the system's temporary one if it is None or cannot be
        used.
    moving_water
        True if the water moves as `set_water` says: then `text` has WaveKin 1.

    Attributes
    ----------
    lengths, segments
        Unstretched length [m] and number of segments of each line.
    """

    def __init__(self, text, *, y, lines, place, moving_water=False):
        self._text, self._y, self._count, self._place = text, y, lines, place
        self._moving_water = moving_water
        self._system = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._lines, self.lengths, self.segments = [], [], []
        self._size = 0  # bytes of a saved state

    @property
    def running(self):
        """True between `create` and `close`."""
        return self._system is not None

    def create(self, position, *, search, net=None):
        """Make the system with fairleads at these places [m]; return what MoorDyn wrote.

        With `search` MoorDyn looks for the equilibrium of the lines; else they begin straight, or
        with their nodes as in `net`. MooringError if that fails.
        """
        initialise = moordyn.Init if search else moordyn.Init_NoIC
        self.close()
        # a .out file appears beside the input, so every system has a folder of its own
        self._folder = _new_folder(self._place)
        path = Path(self._folder.name) / "lines.txt"
        path.write_text(self._text, encoding="utf-8")
        with console_kept() as console:
            try:
                self._system = moordyn.Create(str(path))
                at, rest = self._vector(position), [0.0] * (3 * len(self._y))
                failed = initialise(self._system, at, rest) != 0
                if net is not None:
                    self._put_nodes(path.with_suffix(".state"), net)
            except (RuntimeError, ValueError) as error:
                failed = True
                console.write(f"\n{error}\n".encode())
        if failed:
            self.close()
            raise MooringError(_not_started(position, console.text))
        if os.name == "posix":  # open files need no name, and a kill leaves none
            self._folder.cleanup()
        moordyn.SetVerbosity(self._system, moordyn.LEVEL_NONE)
        self._lines = [moordyn.GetLine(self._system, k + 1) for k in range(self._count)]
        self.segments = [moordyn.GetLineN(line) for line in self._lines]
        self.lengths = [moordyn.GetLineUnstretchedLength(line) for line in self._lines]
        self._size = 0
        if self._moving_water:
            moordyn.ExternalWaveKinInit(self._system)
        return console.text

    def _put_nodes(self, path, net):
        moordyn.SaveState(self._system, str(path))
        path.write_bytes(with_nodes(path.read_bytes(), net))
        moordyn.LoadState(self._system, str(path))
        for _ in range(2):
            _take_none()

    def step(self, position, velocity, t, h):
        """Forces [N] (x, y, z of one fairlead after the other) of a step from t over h [s].

        Fairleads are at `position` [m] at its start and keep the `velocity` [m/s]. MooringError if
        MoorDyn fails or a force is not finite.
        """
        try:
            force = moordyn.Step(
                self._system, self._vector(position), self._vector(velocity, 0.0), t, h
            )
        except (RuntimeError, ValueError) as error:
            raise MooringError(_broken(t, str(error))) from None
        if not all(map(isfinite, force)):
            raise MooringError(_broken(t, "a force is not finite"))
        if self._moving_water:
            self._look_at_nodes(t)
        # before its first step MoorDyn would write a time that it has not set, and never ends with
        # an infinite one
        if not self._size:
            self._size = len(moordyn.Serialize(self._system))
        return force

    def _look_at_nodes(self, t):
        """MooringError if a node is not a number, as MoorDyn itself says."""
        try:
            for line, last in zip(self._lines, self.segments, strict=True):
                for k in range(1, last):
                    moordyn.GetLineNodePos(line, k)
        except RuntimeError as error:
            raise MooringError(_broken(t, str(error))) from None

    def _vector(self, places, y=None):
        ys = self._y if y is None else [y] * len(self._y)
        pairs = zip(places, ys, strict=True)
        return [c for place, y in pairs for c in in_space(place, y)]

    def nodes(self):
        """Places [m] and velocities [m/s] where the water's motion is wanted: flat, (x, y, z).

        All nodes of the lines come first, then rods, points and bodies, whose velocity is 0 here.
        """
        places = moordyn.ExternalWaveKinGetCoordinates(self._system)
        speeds = [
            moordyn.GetLineNodeVel(line, k)
            for line, last in zip(self._lines, self.segments, strict=True)
            for k in range(last + 1)
        ]
        return places, speeds + [(0.0, 0.0, 0.0)] * (len(places) - len(speeds))

    def set_water(self, velocity, acceleration):
        """Let the water have these at the places of `nodes` until it is set again: flat lists."""
        cmoordyn.ext_wave_set(self._system, velocity, acceleration, 0.0)

    def end_tensions(self):
        """Magnitudes [N] of the forces at end A, and at end B, of every line."""
        ends = zip(self._lines, self.segments, strict=True)
        found = [(_node_force(line, 0), _node_force(line, last)) for line, last in ends]
        return [a for a, _ in found], [b for _, b in found]

    def end_force(self, line, end):
        """Force [N] of end A (0) or B (1) of a line, counted from 0, on what holds it; (3,)."""
        return moordyn.GetLineNodeForce(self._lines[line], end * self.segments[line])

    def inner_forces(self):
        """The largest force [N] on an inner node of each line; 0 if it has none."""
        return [
            max((_node_force(line, k) for k in range(1, last)), default=0.0)
            for line, last in zip(self._lines, self.segments, strict=True)
        ]

    def end_position(self, line, end):
        """(x, y, z) [m] of end A (0) or B (1) of a line, by its number from 0."""
        return self.node_position(line, end * self.segments[line])

    def node_position(self, line, node):
        """(x, y, z) [m] of a node of a line, both by their numbers from 0."""
        return moordyn.GetLineNodePos(self._lines[line], node)

    def state(self):
        """All of MoorDyn's state, as bytes."""
        return without_denormals(bytes(moordyn.Serialize(self._system)))

    def set_state(self, state):
        """Go back to what `state` returned; MooringError if its size is that of other lines."""
        # MoorDyn reads beyond the end of bytes that are too few
        if len(state) != self._size:
            raise MooringError("the saved state is not one of these lines")
        moordyn.Deserialize(self._system, state)
        _take_none()

    def close(self):
        """Free MoorDyn's memory and files; the system can be created again."""
        self._lines, self.lengths, self.segments = [], [], []
        if self._system is not None:
            system, self._system = self._system, None
            moordyn.Close(system)
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None


def without_denormals(state):
    """The bytes of a state with 0 in place of what MoorDyn made of denormal numbers.

    Words of 8 bytes: the exponent of such a number, below −1022, became negative, which has the
    bits of a large one.
    """
    if max(state[7::8], default=0) < DENORMAL >> 56:
        return state
    words = (0 if DENORMAL <= word < SMALL_NEGATIVE else word for word in array("Q", state))
    return array("Q", words).tobytes()


def in_space(place, y):
    """(x, y, z) of (x, y, z), or of (x, z) and a fixed y."""
    return tuple(place) if len(place) == 3 else (place[0], y, place[1])


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


def _take_none():
    """Take the reference to `None` that MoorDyn has released without owning it."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(None))


def _node_force(line, node):
    return hypot(*moordyn.GetLineNodeForce(line, node))


def _not_started(position, report):
    """Error message with the end of what MoorDyn wrote, without the places in its source."""
    places = ", ".join(f"({', '.join(f'{c:.6g}' for c in place)})" for place in position)
    lines = [line for line in report.splitlines() if line.strip()]
    tail = "\n".join(SOURCE_PLACE.sub("", line) for line in lines[-REPORT_LENGTH:])
    return (
        f"MoorDyn cannot start with the fairleads at {places} m: check these positions "
        f"against the anchors and the lengths of the lines. It reports:\n{tail}"
    )


def _broken(t, reason):
    return (
        f"MoorDyn failed in the step from t = {t:.9g} s ({reason}): fairleads that jump, or an "
        "internal step that is too long; try a smaller communication step or solver time_step"
    )


class Console:
    """Collects what is written to file descriptors 1 and 2."""

    def __init__(self, file):
        self._file = file
        self.text = ""

    def write(self, data):
        """Add these bytes."""
        os.write(self._file.fileno(), data)

    def finish(self):
        """Make `text` of all that was written."""
        self._file.seek(0)
        self.text = self._file.read().decode("utf-8", "replace")


@contextlib.contextmanager
def console_kept():
    """Keep the process's standard output and error, C++ included, in a file meanwhile."""
    with tempfile.TemporaryFile() as file:
        console = Console(file)
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
            console.finish()


def _flush_c_streams():
    if os.name == "posix":
        ctypes.CDLL(None).fflush(None)
