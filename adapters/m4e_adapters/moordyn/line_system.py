"""One MoorDyn system: fairlead motion in, forces on the bodies out.

Travels inside the FMU: imports the standard library and `moordyn` only. World frame, X right and
Z up, SI units; the y of every fairlead is fixed.

MoorDyn 2.7.2 has habits that this module answers:

- `Step` returns the force of its last internal stage, which for RK2 lies half an internal step
  before the end, and 0 before the first step. Every step here ends with a vanishing one, so the
  force belongs to the end of the step, and to the start of the run.
- `Deserialize` takes a reference of `None` that it does not own; it is given back.
- It writes to the console whatever its options say, and a file beside its input.
"""

import contextlib
import ctypes
import os
import re
import sys
import tempfile
from math import hypot, isfinite
from pathlib import Path

START_STEP = 1e-12  # [s] length of the step that evaluates the forces at the start
LAST_PART = 1e-9  # the part of each step that is left to the evaluation of its end
LARGE_STRAIN = 0.2  # a line stretched by more than this at the start deserves a warning
INSTALL = "pip install moordyn==2.7.2"
REPORT_LENGTH = 6  # lines of MoorDyn's own report that go into an error message
RESIDUAL = re.compile(r"Remaining error after (\S+) s = (\S+) m/s2")
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
    static_duration
        The longest time [s] that the static solution may take; 0 if there is none.

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

    def __init__(self, text, *, fairleads, lines, static_duration=0.0):
        self._text = text
        self._y = [float(y) for y in fairleads]
        self._names = list(lines)
        self._static_duration = static_duration
        self._system = None
        self._folder = None
        self._ends = []
        self._size = 0  # bytes of a saved state
        self._motion = {}
        self.force = []
        self.fairlead_tension = []
        self.anchor_tension = []
        self.warnings = []

    @property
    def running(self):
        """Whether there is a MoorDyn system, between `start` and `close`."""
        return self._system is not None

    def start(self, position, velocity):
        """Begin with the fairleads at (x, z) [m] with velocity (vx, vz) [m/s], lines at rest."""
        # MoorDyn's static solution would let fairleads with a velocity drift away
        report = self._create(position, moordyn.Init)
        position = [tuple(p) for p in position]
        velocity = [tuple(v) for v in velocity]
        self._motion = {"position": position, "velocity": velocity, "step": 0.0}
        self._evaluate(0.0, START_STEP, velocity)
        self.warnings = [*self._residual_warning(report), *self._strain_warnings()]

    def advance(self, t, h, position, velocity):
        """Advance from t over h [s]: fairleads end at position + velocity·h.

        `position` [m] is meant at t, `velocity` [m/s] is the mean of the step. Where MoorDyn's
        fairlead is elsewhere at t, its velocity is adjusted so that the end coincides.
        """
        motion, ends, mean = self._motion, [], []
        for (x, z), (u, w), (x0, z0) in zip(position, velocity, motion["position"], strict=True):
            ends.append((x + u * h, z + w * h))
            mean.append(((ends[-1][0] - x0) / h, (ends[-1][1] - z0) / h))
        last = LAST_PART * h
        self._step(motion["position"], mean, t, h - last)
        # damping needs the velocity at the end: extrapolated from the means of two steps
        ratio = h / (h + motion["step"])
        final = [
            (u + (u - u0) * ratio, w + (w - w0) * ratio)
            for (u, w), (u0, w0) in zip(mean, motion["velocity"], strict=True)
        ]
        self._motion = {"position": ends, "velocity": mean, "step": h}
        self._evaluate(t + h, last, final)

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
            self._create(saved["motion"]["position"], moordyn.Init_NoIC)
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

    def _create(self, position, initialise):
        """Make the MoorDyn system; returns what it wrote to the console."""
        self.close()
        # a .out file appears beside the input, so every system has a folder of its own
        self._folder = tempfile.TemporaryDirectory(
            prefix="m4e_mooring_", ignore_cleanup_errors=True
        )
        path = Path(self._folder.name) / "lines.txt"
        path.write_text(self._text, encoding="utf-8")
        places = ", ".join(f"({x:.6g}, {z:.6g})" for x, z in position)
        with _console_kept() as console:
            try:
                self._system = moordyn.Create(str(path))
                at, rest = self._vector(position), [0.0] * (3 * len(self._y))
                failed = initialise(self._system, at, rest) != 0
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
        moordyn.SetVerbosity(self._system, moordyn.LEVEL_NONE)
        lines = [moordyn.GetLine(self._system, k + 1) for k in range(len(self._names))]
        self._ends = [(line, moordyn.GetLineN(line)) for line in lines]
        self._size = len(moordyn.Serialize(self._system))
        return report

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

    def _evaluate(self, t, h, velocity):
        """Take the last `h` seconds before `t` and read the forces there."""
        ends = self._motion["position"]
        begins = [(x - u * h, z - w * h) for (x, z), (u, w) in zip(ends, velocity, strict=True)]
        force = self._step(begins, velocity, t - h, h)
        self.force = [(force[k], force[k + 2]) for k in range(0, len(force), 3)]
        self.anchor_tension = [_end_force(line, 0) for line, _ in self._ends]
        self.fairlead_tension = [_end_force(line, last) for line, last in self._ends]

    def _residual_warning(self, report):
        for time, residual in RESIDUAL.findall(report):
            if 0 < self._static_duration <= float(time):
                return [
                    f"the static solution was stopped after {time} s with an acceleration of "
                    f"{residual} m/s2: the lines will move at first; give it a longer duration"
                ]
        return []

    def _strain_warnings(self):
        warnings = []
        for name, (line, last) in zip(self._names, self._ends, strict=True):
            a, b = moordyn.GetLineNodePos(line, 0), moordyn.GetLineNodePos(line, last)
            distance = hypot(*(p - q for p, q in zip(a, b, strict=True)))
            length = moordyn.GetLineUnstretchedLength(line)
            if distance > (1 + LARGE_STRAIN) * length:
                warnings.append(
                    f"the ends of {name} start {distance:.6g} m apart, its unstretched length is "
                    f"{length:.6g} m: check the initial positions of its fairleads"
                )
        return warnings


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


class _Console:
    """Collects what is written to file descriptors 1 and 2."""

    def __init__(self, file):
        self._file = file
        self.text = ""

    def write(self, data):
        os.write(self._file.fileno(), data)

    def finish(self):
        self._file.seek(0)
        self.text = self._file.read().decode("utf-8", "replace")


@contextlib.contextmanager
def _console_kept():
    """Keep the process's standard output and error, C++ included, in a file meanwhile."""
    with tempfile.TemporaryFile() as file:
        console = _Console(file)
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
