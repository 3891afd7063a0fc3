"""Mooring lines between fairleads that are moved from outside: motion in, forces out.

Travels inside the FMU: imports the standard library and its neighbours that travel as well. World
frame, X right and Z up, SI units. Positions, velocities and forces of fairleads are (x, z), with a
fixed y, or (x, y, z).

MoorDyn 2.7.2 has habits that this module answers:

- `Step` returns the force of its last internal stage, which for RK2 lies half an internal step
  before the end, and 0 before the first step. Every step here ends with a vanishing one, so the
  force belongs to the end of the step, and to the start of the run.
- During `Step` fairleads keep one velocity, and a jump of it rings in the line's stiff segments.
  Their path is therefore a parabola, taken in pieces of a few internal steps.
- Its static solution is often wrong. Lines start in the equilibrium that `rest` finds; where it
  finds none, as with free bodies, MoorDyn looks for one, and warnings tell how far it is off.
"""

from math import ceil, hypot, inf, isfinite
from operator import sub

from .moordyn_system import MoorDynSystem, in_space, warnings_in
from .plausibility import (
    above_water,
    below_seabed,
    high_anchors,
    misplaced,
    unplaced,
)
from .rest import LATER, MORE_TIME, away_from, left_over, net_at, too_long

START_STEP = 1e-12  # [s] length of the step that evaluates the forces at the start
LAST_PART = 1e-9  # the part of each step that is left to the evaluation of its end
PIECE = 4  # internal steps of MoorDyn during which fairleads keep their velocity, at most
SWITCHED_OFF = "the input switches the static equilibrium off (static_equilibrium, or TmaxIC 0)"
NOT_FOUND = "the static equilibrium was not found, and lines start in MoorDyn's own solution"
LARGE_STRAIN = 0.2  # a line stretched by more than this deserves a warning
START_STRAIN = 0.002  # at the start, by this: steel yields there


class LineSystem:
    """Mooring lines between fairleads that are moved from outside, and anchors.

    Parameters
    ----------
    text
        MoorDyn v2 input file; its coupled objects are points only.
    fairleads
        The fixed y coordinate [m] of each coupled point, in MoorDyn's order; None of those that
        move in space.
    lines
        The names of the lines, in MoorDyn's order.
    time_step
        MoorDyn's internal step [s], as in `text`.
    net
        Points and lines as `rest.net_at` takes them; None if MoorDyn alone knows their equilibrium.
    at_rest
        True: lines start in their static equilibrium; False: as `text` has MoorDyn begin.
    names, placed
        The names of the fairleads, and those that have a place of their own.
    bed
        z [m] of the seabed, None if it is not known.
    drawn
        Name and place [m] of the fairleads in a file that somebody else wrote, in its order.
    notes
        Warnings of every start.
    course
        The motion of the water at the nodes, a `water_course.WaterCourse`; None if it stands still.
    parting
        Ends of lines that may part from a fairlead: number of the line, end (0 for A, 1 for B), and
        number of the fairlead.
    place
        The folder for MoorDyn's files; the system's temporary one if it is None or cannot be
        used.

    Attributes
    ----------
    force
        Force [N] of the lines on the body at each fairlead, (F_x, F_z) or (F_x, F_y, F_z).
    fairlead_tension, anchor_tension
        Magnitude [N] of the force that ends B and A of each line exert on what holds them.
        Second order accurate in the segment length, because the weight of half a segment is in it.
    warnings
        Those of the last start.
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
        parting=(),
        course=None,
        place=None,
    ):
        self._y = [None if y is None else float(y) for y in fairleads]
        self._course = course
        self._moordyn = MoorDynSystem(
            text, y=self._y, lines=len(lines), place=place, moving_water=course is not None
        )
        self._names = list(lines)
        self._fairleads = names or [f"fairlead_{k + 1}" for k in range(len(self._y))]
        self._placed = self._fairleads if placed is None else placed
        self._bed = -inf if bed is None else bed
        self._piece = PIECE * time_step
        self._net = net
        self._at_rest = at_rest
        self._drawn = drawn
        self._notes = list(notes)
        self._parting = list(parting)
        self._pulls = []  # forces [N] of the ends that may part
        self._motion: dict = {}
        self.force: list = []
        self.fairlead_tension = []
        self.anchor_tension = []
        self.warnings = []
        self._stretched = set()  # the lines that were too long when last looked at
        self._surfaced = set()  # the free points that were above the water when last looked at

    @property
    def running(self):
        """True between `start` and `close`."""
        return self._moordyn.running

    def start(self, position, velocity, t=0.0):
        """Begin at t [s] with the fairleads at `position` [m] with `velocity` [m/s].

        Lines are at rest, in the equilibrium without waves. MooringError if MoorDyn cannot start
        there.
        """
        position = [tuple(p) for p in position]
        velocity = [tuple(v) for v in velocity]
        net, found = None, False
        if self._net is not None and all(isfinite(c) for place in position for c in place):
            places = [in_space(place, y) for place, y in zip(position, self._y, strict=True)]
            net = net_at(self._net, places)
            found = net.settle_in(self._course.current) if self._course else net.settle()
        if found and self._at_rest:
            report = self._moordyn.create(position, search=False, net=net)
        else:
            report = self._moordyn.create(position, search=True)
        # MoorDyn's static solution would let fairleads with a velocity drift away
        rest = _still(position)
        self._motion = {"position": position, "velocity": rest, "age": 0.0, "given": rest}
        self._motion |= {"time": 0.0, "last": START_STEP}
        if self._course:
            self._course.be_calm(self._moordyn)
        self._evaluate(rest)
        self.warnings = [
            *self._notes,
            *unplaced(self._fairleads, position, self._placed),
            *below_seabed(self._fairleads, position, self._bed),
            *(too_long(net, self._names) if net is not None else ()),
            *self._unrest(net if found else None),
            *(high_anchors(self._net["points"], self._net["bed"]) if self._net else ()),
            *warnings_in(report, equilibrium_known=found),
        ]
        if self._course:
            self._course.begin(self._moordyn, t)
            self._evaluate(rest)
        self.settle(velocity)
        shortest = min(self._moordyn.lengths)
        self.warnings += misplaced(self._drawn, position, shortest=shortest)
        remedy = "check the initial positions of its fairleads, and its length"
        self.warnings += self._beyond(START_STRAIN, remedy).values()
        self._stretched = set(self._beyond(LARGE_STRAIN, remedy))
        self._surfaced = set()

    def advance(self, t, h, position, velocity):
        """Advance from t over h [s]: fairleads end at position + velocity·h. MooringError.

        `position` [m] is meant at t, `velocity` [m/s] is the mean of the step. Where MoorDyn's
        fairlead is elsewhere at t, its velocity is adjusted so that the end coincides. The path is
        a parabola, from the velocity that was given at t by `settle`, else from the mean of the
        step before in its middle; the velocity at the end is then its own.
        """
        motion, starts = self._motion, self._motion["position"]
        ends = _each(lambda x, u: x + u * h, position, velocity)
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
        times = [t + bound for bound in bounds]
        for k in range(count):
            size = bounds[k + 1] - bounds[k]
            chord = _each(lambda start, end, size=size: (end - start) / size, way[k], way[k + 1])
            if self._course:
                self._course.apply(self._moordyn, times, k)
            self._moordyn.step(way[k], chord, t + bounds[k], size)
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

    def without(self, parted):
        """Forces, fairlead tensions and anchor tensions with some lines parted.

        `parted` has the share by which a line has parted, by its number: 1 is all of it.
        """
        force, tensions = list(self.force), (self.fairlead_tension, self.anchor_tension)
        for (line, _, fairlead), pull in zip(self._parting, self._pulls, strict=True):
            if line in parted:
                force[fairlead] = tuple(
                    f - parted[line] * p for f, p in zip(force[fairlead], pull, strict=True)
                )
        left = [1 - parted.get(line, 0.0) for line in range(len(self._names))]
        return force, *([a * x for a, x in zip(left, one, strict=True)] for one in tensions)

    def node_position(self, line, node):
        """(x, y, z) [m] of a node of a line, both by their numbers from 0."""
        return self._moordyn.node_position(line, node)

    def save(self):
        """All that later results depend on, as JSON values and bytes."""
        return {
            "system": self._moordyn.state(),
            "motion": {key: _copied(value) for key, value in self._motion.items()},
            "force": _copied(self.force),
            "fairlead_tension": list(self.fairlead_tension),
            "anchor_tension": list(self.anchor_tension),
            "pulls": _copied(self._pulls),
            "water": self._course.now if self._course else [],
        }

    def restore(self, saved):
        """Go back to what `save` returned, here or in another instance of the same lines.

        MooringError if it is of other lines.
        """
        if not self._moordyn.running:
            position = saved["motion"]["position"]
            self._moordyn.create(position, search=False)
            self._moordyn.step(position, _still(position), 0.0, START_STEP)
        self._moordyn.set_state(saved["system"])
        self._motion = {key: _copied(value) for key, value in saved["motion"].items()}
        self.force = _copied(saved["force"])
        self.fairlead_tension = list(saved["fairlead_tension"])
        self.anchor_tension = list(saved["anchor_tension"])
        self._pulls = _copied(saved["pulls"])
        if self._course:
            self._course.now = saved["water"]

    def close(self):
        """Free MoorDyn's memory and files; the object can be started again."""
        self._moordyn.close()

    def _evaluate(self, velocity):
        """Take the last part of the step, with this velocity, and read the forces at its end."""
        t, h, ends = (self._motion[key] for key in ("time", "last", "position"))
        begins = _each(lambda end, speed: end - speed * h, ends, velocity)
        if self._course:
            self._moordyn.set_water(*self._course.now)
        force = self._moordyn.step(begins, velocity, t - h, h)
        forces = [tuple(force[k : k + 3]) for k in range(0, len(force), 3)]
        self.force = [self._seen(k, whole) for k, whole in enumerate(forces)]
        self.anchor_tension, self.fairlead_tension = self._moordyn.end_tensions()
        self._pulls = [
            self._seen(fairlead, self._moordyn.end_force(line, end))
            for line, end, fairlead in self._parting
        ]

    def _seen(self, fairlead, force) -> tuple:
        """The components of a force (3,) that a fairlead has."""
        x, y, z = force
        return (x, y, z) if self._y[fairlead] is None else (x, z)

    def _unrest(self, net):
        """A text for each line that does not start at rest; `net` is its equilibrium, if known."""
        tensions = list(zip(self.anchor_tension, self.fairlead_tension, strict=True))
        if net is not None:
            cause = "MoorDyn finds other forces than m4e_fmi" if self._at_rest else SWITCHED_OFF
            return away_from(net, self._names, tensions, cause)
        forces, counts = self._moordyn.inner_forces(), self._moordyn.segments
        remedy = MORE_TIME if self._net is None else LATER
        texts = left_over(self._names, forces, tensions, counts, remedy)
        if not texts and self._net is not None and self._at_rest:
            worst = max(zip(forces, self._names, strict=True))
            return [f"{NOT_FOUND}: it leaves {worst[0]:.3g} N on a node of {worst[1]}"]
        return texts

    def surfaced(self):
        """A text for each buoyant free point that came above the water since the last call."""
        points = [] if self._net is None else self._net["points"]
        heights = {}
        for k, line in enumerate([] if self._net is None else self._net["lines"]):
            for end, point in enumerate(line["ends"]):
                if points[point]["force"] is not None:
                    heights[point] = self._moordyn.end_position(k, end)[2]
        found = above_water(points, heights)
        texts = [text for k, text in found.items() if k not in self._surfaced]
        self._surfaced = set(found)
        return texts

    def overstretched(self, parted=()):
        """A text for each line that is stretched far beyond its length since the last call.

        Lines whose numbers are among `parted` are left out.
        """
        remedy = "check its length and stiffness, and the forces on the body"
        found = self._beyond(LARGE_STRAIN, remedy)
        found = {k: text for k, text in found.items() if k not in parted}
        texts = [text for k, text in found.items() if k not in self._stretched]
        self._stretched = set(found)
        return texts

    def _beyond(self, strain, remedy):
        """A text, by number, for each line with ends further apart than (1 + strain)·length."""
        texts = {}
        for k, length in enumerate(self._moordyn.lengths):
            a, b = (self._moordyn.end_position(k, end) for end in (0, 1))
            distance = hypot(*map(sub, a, b))
            if distance > (1 + strain) * length:
                texts[k] = (
                    f"the ends of {self._names[k]} are {distance:.6g} m apart, "
                    f"{100 * (distance / length - 1):.3g} % beyond its unstretched length of "
                    f"{length:.6g} m, and it pulls {self.fairlead_tension[k]:.3g} N: {remedy}"
                )
        return texts


def _each(formula, *pairs):
    """`formula` for each coordinate of each fairlead."""
    return [tuple(map(formula, *of_one)) for of_one in zip(*pairs, strict=True)]


def _still(position):
    """A velocity of zero for each fairlead."""
    return [(0.0,) * len(place) for place in position]


def _copied(value):
    return [tuple(item) for item in value] if isinstance(value, list) else value
