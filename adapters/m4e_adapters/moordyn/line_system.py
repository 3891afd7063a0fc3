"""One MoorDyn system: fairlead motion in, forces on the bodies out.

Travels inside the FMU: imports the standard library, `moordyn` and its neighbours that travel as
well. World frame, X right and Z up, SI units; the y of every fairlead is fixed.

MoorDyn 2.7.2 has habits that this module answers:

- `Step` returns the force of its last internal stage, which for RK2 lies half an internal step
  before the end, and 0 before the first step. Every step here ends with a vanishing one, so the
  force belongs to the end of the step, and to the start of the run.
- `Deserialize` takes a reference of `None` that it does not own; it is given back.
- During `Step` fairleads keep one velocity, and a jump of it rings in the line's stiff segments.
  Their path is therefore a parabola, taken in pieces of a few internal steps.
- It writes to the console whatever its options say, and a file beside its input.
- Its static solution is often none. Lines start in the equilibrium that `rest` knows; where that
  finds none, as with free bodies, MoorDyn looks for one, and what is left is told.
"""

import contextlib
import ctypes
import os
import re
import sys
import tempfile
from math import ceil, hypot, inf, isfinite
from operator import sub
from pathlib import Path

from .console import console_kept
from .placement import below_seabed, misplaced, unplaced
from .plausibility import above_water, coarse_lines, high_anchors, light_lines, stretched_lines
from .rest import away_from, left_over, net_at, too_long, with_nodes

START_STEP = 1e-12  # [s] length of the step that evaluates the forces at the start
LAST_PART = 1e-9  # the part of each step that is left to the evaluation of its end
PIECE = 4  # internal steps of MoorDyn during which fairleads keep their velocity, at most
SWITCHED_OFF = "the input switches the static equilibrium off (static_equilibrium, or TmaxIC 0)"
NOT_FOUND = "the static equilibrium was not found, and lines start in MoorDyn's own solution"
LATER = "start the run before the time that counts"
OTHER = (
    "try MoorDyn's other method (1 ICgenDynamic, with threshIC 1e-4, dtIC 10 and TmaxIC 500); "
    f"else {LATER}"
)
FOLLOWED = (1e-6, 1000.0)  # threshIC, TmaxIC [s] that LONGER asks for
LONGER = (  # of a file with rods or free bodies, where TmaxIC alone changes nothing
    "give MoorDyn a smaller threshIC (1e-6) and more time (TmaxIC 1000), or its other method "
    f"(1 ICgenDynamic, with threshIC 1e-4, dtIC 10 and TmaxIC 500); else {LATER}"
)
LARGE_STRAIN = 0.2  # a line stretched by more than this deserves a warning
START_STRAIN = 0.002  # at the start, by this: steel yields there
INSTALL = "pip install moordyn==2.7.2"
REPORT_LENGTH = 6  # lines of MoorDyn's own report that go into an error message
FIRST_GUESS = "Catenary initial profile"  # of no interest where the equilibrium is known
WARNING = re.compile(r"^WRN |warning", re.IGNORECASE)  # a line of MoorDyn's report that warns
SOURCE_PLACE = re.compile(r"^(ERR|WRN) \S+:\d+ \w+\(\): ")  # of MoorDyn's own source files


class MooringError(RuntimeError):
    """MoorDyn could not do what was asked; the text says what, when and what to try."""


class _NotInstalled:
    """In place of MoorDyn: tells what to do when it is used. Earlier, it would end the host."""

    def __getattr__(self, _):
        raise MooringError(f"MoorDyn is not installed for {sys.executable}: {INSTALL}")


try:
    import moordyn
except ImportError:
    moordyn = _NotInstalled()


class LineSystem:
    """Mooring lines between fairleads that are moved from outside, and anchors.

    Parameters
    ----------
    text
        MoorDyn v2 input file; its coupled objects are points only.
    fairleads
        The fixed y coordinate [m] of each coupled point, in MoorDyn's order.
    lines
        The names of the lines, in MoorDyn's order.
    time_step
        MoorDyn's internal step [s], as in `text`.
    net
        Points and lines as `rest.net_at` takes them; None if MoorDyn alone knows their equilibrium.
    at_rest
        Whether lines start in their static equilibrium, else as `text` has MoorDyn begin.
    names, placed
        The names of the fairleads, and those that have a place of their own.
    bed
        z [m] of the seabed, None if it is not known.
    drawn
        Name, x and z [m] of the fairleads in a file that somebody else wrote, in its order.
    notes
        What is told at every start.
    place
        The folder in which MoorDyn's own is, as long as it needs one; that of the system for
        temporary files if it is None, or cannot be used.

    Attributes
    ----------
    force
        (F_x, F_z) [N] of the lines on the body at each fairlead.
    fairlead_tension, anchor_tension
        Magnitude [N] of the force that ends B and A of each line exert on what holds them.
        Second order accurate in the segment length, because the weight of half a segment is in it.
    warnings
        What was odd about the last start.
    """

    def __init__(
        self,
        text,
        *,
        fairleads,
        lines,
        time_step,
        net=None,
        at_rest=True,
        names=None,
        placed=None,
        bed=None,
        drawn=(),
        notes=(),
        place=None,
    ):
        self._text = text
        self._y = [float(y) for y in fairleads]
        self._names = list(lines)
        self._fairleads = names or [f"fairlead_{k + 1}" for k in range(len(self._y))]
        self._placed = self._fairleads if placed is None else placed
        self._bed = -inf if bed is None else bed
        self._piece = PIECE * time_step
        self._net = net
        self._at_rest = at_rest
        self._drawn = drawn
        self._notes = list(notes)
        self._place = place
        self._system = None
        self._folder = None
        self._ends = []
        self._size = 0  # bytes of a saved state
        self._motion: dict = {}
        self.force = []
        self.fairlead_tension = []
        self.anchor_tension = []
        self.warnings = []
        self._lengths = []
        self._stretched = set()  # the lines that were too long when last looked at
        self._surfaced = set()  # the free points that were above the water then

    @property
    def running(self):
        """Whether there is a MoorDyn system, between `start` and `close`."""
        return self._system is not None

    def start(self, position, velocity):
        """Begin with the fairleads at (x, z) [m] with velocity (vx, vz) [m/s], lines at rest."""
        position = [tuple(p) for p in position]
        velocity = [tuple(v) for v in velocity]
        net, found = None, False
        if self._net is not None and all(map(isfinite, self._vector(position))):
            places = [(x, y, z) for (x, z), y in zip(position, self._y, strict=True)]
            net = net_at(self._net, places)
            found = net.settle()
        if found and self._at_rest:
            report = self._create(position, moordyn.Init_NoIC, net)
        else:
            report = self._create(position, moordyn.Init)
        # MoorDyn's static solution would let fairleads with a velocity drift away
        rest = [(0.0, 0.0) for _ in position]
        self._motion = {"position": position, "velocity": rest, "age": 0.0, "given": rest}
        self._motion |= {"time": 0.0, "last": START_STEP}
        self._evaluate(rest)
        self.warnings = [
            *self._notes,
            *unplaced(self._fairleads, position, self._placed),
            *below_seabed(self._fairleads, position, self._bed),
            *(too_long(net, self._names) if net is not None else ()),
            *self._unrest(net if found else None),
            *self._implausible(net if found and self._at_rest else None),
            *_own_warnings(report, found),
        ]
        self.settle(velocity)
        self._measure()
        self.warnings += misplaced(self._drawn, position, shortest=min(self._lengths))
        remedy = "check the initial positions of its fairleads, and its length"
        self.warnings += self._beyond(START_STRAIN, remedy).values()
        self._stretched = set(self._beyond(LARGE_STRAIN, remedy))

    def advance(self, t, h, position, velocity):
        """Advance from t over h [s]: fairleads end at position + velocity·h.

        `position` [m] is meant at t, `velocity` [m/s] is the mean of the step. Where MoorDyn's
        fairlead is elsewhere at t, its velocity is adjusted so that the end coincides. The path is
        a parabola, from the velocity that was given at t by `settle`, else from the mean of the
        step before in its middle; the velocity at the end is then its own.
        """
        motion, starts = self._motion, self._motion["position"]
        ends = [(x + u * h, z + w * h) for (x, z), (u, w) in zip(position, velocity, strict=True)]
        mean = _each(lambda start, end: (end - start) / h, starts, ends)
        # from what was the velocity `age` before the start, to the mean in the middle of the step
        lead = h / 2 + motion["age"]
        bend = _each(lambda mean, before: (mean - before) / lead, mean, motion["velocity"])
        last, count = LAST_PART * h, max(1, ceil(h / self._piece))
        bounds = [h * k / count for k in range(count)] + [h - last]
        way = [
            _each(lambda x, u, a, s=s: x + u * s - a / 2 * s * (h - s), starts, mean, bend)
            for s in bounds
        ]
        for k in range(count):
            size = bounds[k + 1] - bounds[k]
            chord = _each(lambda start, end, size=size: (end - start) / size, way[k], way[k + 1])
            self._step(way[k], chord, t + bounds[k], size)
        self._motion = {"position": ends, "velocity": mean, "age": h / 2, "time": t + h}
        self._motion |= {"last": last, "given": [tuple(v) for v in velocity]}
        self._evaluate(_each(lambda u, a: u + a * h / 2, mean, bend))

    def settle(self, velocity):
        """Let the fairleads have this velocity [m/s] now, if it is another than was given last.

        Forces follow: the axial damping of a line and the drag on its end depend on it.
        """
        velocity = [tuple(v) for v in velocity]
        if velocity != self._motion["given"]:
            self._motion |= {"velocity": velocity, "age": 0.0, "given": velocity}
            self._evaluate(velocity)

    def save(self):
        """Everything that the future depends on, as JSON values and bytes."""
        return {
            "system": bytes(moordyn.Serialize(self._system)),
            "motion": {key: _copied(value) for key, value in self._motion.items()},
            "force": _copied(self.force),
            "fairlead_tension": list(self.fairlead_tension),
            "anchor_tension": list(self.anchor_tension),
        }

    def restore(self, saved):
        """Take back what `save` returned, here or in another instance of the same lines."""
        if self._system is None:
            position = saved["motion"]["position"]
            self._create(position, moordyn.Init_NoIC)
            self._step(position, [(0.0, 0.0) for _ in position], 0.0, START_STEP)
            self._measure()
        # MoorDyn reads beyond the end of bytes that are too few
        if len(saved["system"]) != self._size:
            raise MooringError("the saved state is not one of these lines")
        moordyn.Deserialize(self._system, saved["system"])
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(None))
        self._motion = {key: _copied(value) for key, value in saved["motion"].items()}
        self.force = _copied(saved["force"])
        self.fairlead_tension = list(saved["fairlead_tension"])
        self.anchor_tension = list(saved["anchor_tension"])

    def close(self):
        """Free MoorDyn's memory and files; the object can be started again."""
        self._ends = []
        if self._system is not None:
            system, self._system = self._system, None
            moordyn.Close(system)
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None

    def _create(self, position, initialise, net=None):
        """Make the MoorDyn system, with nodes as in `net`; what it wrote to the console."""
        self.close()
        # a .out file appears beside the input, so every system has a folder of its own
        self._folder = _new_folder(self._place)
        path = Path(self._folder.name) / "lines.txt"
        path.write_text(self._text, encoding="utf-8")
        places = ", ".join(f"({x:.6g}, {z:.6g})" for x, z in position)
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
        report = console.text
        if failed:
            self.close()
            raise MooringError(
                f"MoorDyn cannot start with the fairleads at {places} m: check these positions "
                f"against the anchors and the lengths of the lines. It reports:\n{_tail(report)}"
            )
        if os.name == "posix":  # open files need no name, and a kill leaves none
            self._folder.cleanup()
        moordyn.SetVerbosity(self._system, moordyn.LEVEL_NONE)
        lines = [moordyn.GetLine(self._system, k + 1) for k in range(len(self._names))]
        self._ends = [(line, moordyn.GetLineN(line)) for line in lines]
        self._lengths = [moordyn.GetLineUnstretchedLength(line) for line in lines]
        return report

    def _measure(self):
        """Note the size of a state. Before its first step MoorDyn would write a time that it has
        not set: of an infinite number it never comes to the end."""
        self._size = len(moordyn.Serialize(self._system))

    def _vector(self, pairs, y=None):
        ys = self._y if y is None else [y] * len(self._y)
        return [c for (x, z), y in zip(pairs, ys, strict=True) for c in (x, y, z)]

    def _step(self, position, velocity, t, h):
        try:
            force = moordyn.Step(
                self._system, self._vector(position), self._vector(velocity, 0.0), t, h
            )
        except (RuntimeError, ValueError) as error:
            raise MooringError(_broken(t, str(error))) from None
        if not all(map(isfinite, force)):
            raise MooringError(_broken(t, "a force is not finite"))
        return force

    def _evaluate(self, velocity):
        """Take the last part of the step, with this velocity, and read the forces at its end."""
        t, h, ends = (self._motion[key] for key in ("time", "last", "position"))
        begins = _each(lambda end, speed: end - speed * h, ends, velocity)
        force = self._step(begins, velocity, t - h, h)
        self.force = [(force[k], force[k + 2]) for k in range(0, len(force), 3)]
        self.anchor_tension = [_end_force(line, 0) for line, _ in self._ends]
        self.fairlead_tension = [_end_force(line, last) for line, last in self._ends]

    def _put_nodes(self, path, net):
        moordyn.SaveState(self._system, str(path))
        path.write_bytes(with_nodes(path.read_bytes(), net))
        moordyn.LoadState(self._system, str(path))
        for _ in range(2):  # both take a reference of None, as Deserialize does
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(None))

    def _unrest(self, net):
        """A text for each line that does not start at rest; `net` is its equilibrium, if known."""
        tensions = list(zip(self.anchor_tension, self.fairlead_tension, strict=True))
        if net is not None:
            cause = "MoorDyn finds other forces than m4e_fmi" if self._at_rest else SWITCHED_OFF
            return away_from(net, self._names, tensions, cause)
        forces = [
            max((_end_force(line, k) for k in range(1, last)), default=0.0)
            for line, last in self._ends
        ]
        counts = [last for _, last in self._ends]
        remedy = self._longer() if self._net is None else LATER
        texts = left_over(self._names, forces, tensions, counts, remedy)
        if not texts and self._net is not None and self._at_rest:
            worst = max(zip(forces, self._names, strict=True))
            return [f"{NOT_FOUND}: it leaves {worst[0]:.3g} N on a node of {worst[1]}"]
        return texts

    def _longer(self):
        """The remedy where MoorDyn alone looks for the equilibrium."""
        if self._option("ICgenDynamic|genDynamicIC", 0.0):
            return LATER
        least, most = FOLLOWED
        done = self._option("threshIC|ICthresh", 1.0) <= least
        return OTHER if done and self._option("TmaxIC|ICTmax", 0.0) >= most else LONGER

    def _option(self, names, otherwise):
        """The value of an option in MoorDyn's input, the last one if there are several."""
        found = re.findall(rf"^(\S+) (?:{names})$", self._text, re.IGNORECASE | re.MULTILINE)
        return float(found[-1]) if found else otherwise

    def _implausible(self, net):
        """Texts of what can hardly be meant; `net` is the equilibrium, if lines start in it."""
        if self._net is None:
            return []
        tensions = list(zip(self.anchor_tension, self.fairlead_tension, strict=True))
        buoys = self._above_water()
        self._surfaced = set(buoys)
        return [
            *high_anchors(self._net["points"], self._net["bed"]),
            *light_lines(self._net["lines"], self._names),
            *(coarse_lines(net, self._names, tensions) if net is not None else ()),
            *(stretched_lines(net, self._names) if net is not None else ()),
            *buoys.values(),
        ]

    def _above_water(self):
        """A text, by number, for each buoyant free point that is above the water."""
        if self._net is None:
            return {}
        heights = {}
        for line, (handle, last) in zip(self._net["lines"], self._ends, strict=True):
            for point, node in zip(line["ends"], (0, last), strict=True):
                if self._net["points"][point]["force"] is not None:
                    heights[point] = moordyn.GetLineNodePos(handle, node)[2]
        return above_water(self._net["points"], heights)

    def surfaced(self):
        """A text for each free point that is above the water with its buoyancy, and was not."""
        found = self._above_water()
        texts = [text for k, text in found.items() if k not in self._surfaced]
        self._surfaced = set(found)
        return texts

    def overstretched(self, remedy="check its length and stiffness, and what holds the body"):
        """A text for each line that is stretched far beyond its length, and was not before."""
        found = self._beyond(LARGE_STRAIN, remedy)
        texts = [text for k, text in found.items() if k not in self._stretched]
        self._stretched = set(found)
        return texts

    def _beyond(self, strain, remedy):
        """A text for each line whose ends are so much further apart than it is long, by number."""
        texts = {}
        for k, (line, last) in enumerate(self._ends):
            a, b = moordyn.GetLineNodePos(line, 0), moordyn.GetLineNodePos(line, last)
            distance, length = hypot(*map(sub, a, b)), self._lengths[k]
            if distance > (1 + strain) * length:
                texts[k] = (
                    f"the ends of {self._names[k]} are {distance:.6g} m apart, "
                    f"{100 * (distance / length - 1):.3g} % beyond its unstretched length of "
                    f"{length:.6g} m, and it pulls {self.fairlead_tension[k]:.3g} N: {remedy}"
                )
        return texts


def _new_folder(place):
    """A temporary folder in `place`, with which it goes if this process is killed."""
    options = {"prefix": "m4e_mooring_", "ignore_cleanup_errors": True}
    if place is not None and str(place).isascii():  # MoorDyn takes no other paths on Windows
        with contextlib.suppress(OSError):  # as where the FMU's files cannot be changed
            return tempfile.TemporaryDirectory(dir=place, **options)
    return tempfile.TemporaryDirectory(**options)


def _own_warnings(report, known):
    """Warnings of MoorDyn while it starts, without the places in its source."""
    lines = [line.strip() for line in report.splitlines() if WARNING.search(line)]
    lines = [line for line in lines if not (known and FIRST_GUESS in line)]
    return [f"MoorDyn: {SOURCE_PLACE.sub('', line)}" for line in lines]


def _each(formula, *pairs):
    """`formula` for each coordinate of each fairlead."""
    return [tuple(map(formula, *of_one)) for of_one in zip(*pairs, strict=True)]


def _end_force(line, node):
    return hypot(*moordyn.GetLineNodeForce(line, node))


def _tail(report):
    """The end of what MoorDyn wrote, without the places in its source."""
    lines = [line for line in report.splitlines() if line.strip()]
    return "\n".join(SOURCE_PLACE.sub("", line) for line in lines[-REPORT_LENGTH:])


def _copied(value):
    return [tuple(item) for item in value] if isinstance(value, list) else value


def _broken(t, reason):
    return (
        f"MoorDyn failed in the step from t = {t:.9g} s ({reason}): fairleads that jump, or an "
        "internal step that is too long; try a smaller communication step or solver time_step"
    )
