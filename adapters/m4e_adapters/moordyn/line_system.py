"""Mooring lines between fairleads that are moved from outside: motion in, forces out.

Travels inside the FMU: imports NumPy, SciPy and its neighbours that travel as well. World
frame, X right and Z up, SI units. Positions, velocities and forces of fairleads are (x, z), with a
fixed y, or (x, y, z).

MoorDyn 2.7.2 has habits that this module and the loop in `lines.c` answer:

- `Step` returns the force of its last internal stage, which for RK2 lies half an internal step
  before the end, and 0 before the first step. Every step here ends with a vanishing one, so the
  force belongs to the end of the step, and to the start of the run.
- During `Step` fairleads keep one velocity, and a jump of it rings in the line's stiff segments.
  Their path is therefore a parabola, taken in pieces of a few internal steps.
- Its static solution is often wrong. Lines start in the equilibrium that `rest` finds; where it
  finds none, as with free bodies, MoorDyn looks for one, and warnings tell how far it is off.
- What parts a line in MoorDyn cannot be taken back: see `MoorDynSystem.replace`.
"""

from functools import partial
from itertools import chain
from math import dist, hypot, inf, isfinite

from .moordyn_system import MoorDynSystem, warnings_in, with_free_ends
from .plausibility import (
    above_water,
    below_seabed,
    high_anchors,
    misplaced,
    unplaced,
)
from .rest import LATER, MORE_TIME, away_from, left_over, lying, too_long, with_nodes
from .statics import Net

SWITCHED_OFF = "the input switches the static equilibrium off (static_equilibrium, or TmaxIC 0)"
NOT_FOUND = "the static equilibrium was not found, and lines start in MoorDyn's own solution"
LARGE_STRAIN = 0.2  # a line stretched by more than this deserves a warning
START_STRAIN = 0.002  # at the start, by this: steel yields there


class LineSystem(MoorDynSystem):
    """Mooring lines between fairleads that are moved from outside, and anchors.

    Parameters
    ----------
    text
        MoorDyn v2 input file.
    fairleads
        The fixed y coordinate [m] of each fairlead, in the order of MoorDyn's coupled objects;
        None of those that move in space.
    lines
        The names of the lines, in MoorDyn's order.
    net
        Points and lines as `statics.Net` takes them; None if MoorDyn alone knows their equilibrium.
    at_rest
        True: lines start in their static equilibrium; False: as `text` has MoorDyn begin.
    names, placed
        The names of the fairleads, and those that have a place of their own.
    bed
        z [m] of the seabed.
    drawn
        Name and place [m] of the fairleads in a file that somebody else wrote, in its order.
    notes
        Warnings of every start.
    ends, axes, moving, more
        As of `MoorDynSystem`; no `ends`: one each, no `axes`: no rods.
    failures
        Ends of lines that part from what they are at, together: (line, end) numbers from 0, end 1
        for B; and the time [s] and tension [N] at which they do, None for never by itself.
    course
        The motion of the water at the nodes, a `water_course.WaterCourse`; None if it stands still.

    Attributes
    ----------
    parted
        Numbers of the failures that have happened, in their order.
    warnings
        Those of the last start.
    """

    def __init__(
        self,
        text,
        *,
        fairleads,
        lines,
        net,
        at_rest,
        names,
        placed,
        bed,
        drawn=(),
        notes=(),
        ends=(),
        axes=(),
        moving=False,
        failures=(),
        course=None,
        **more,
    ):
        self._y = list(fairleads)
        ends = ends or [1] * len(self._y)
        super().__init__(
            ends=ends,
            axes=axes or [(0.0, 0.0, 0.0)] * len(ends),
            moving=moving or course is not None,
            lines=len(lines),
            fixed=self._y,
            course=course,
            **more,
        )
        self._text, self._names, self._fairleads, self._placed = text, list(lines), names, placed
        self._bed, self._net, self._at_rest = bed, net, at_rest
        self._drawn, self._notes = drawn, list(notes)
        self._failures = [([tuple(end) for end in ends], *when) for ends, *when in failures]
        self._buoyant = {
            point: (line, end)
            for line, one in enumerate(net["lines"] if net else ())
            for end, point in enumerate(one["ends"])
            if net["points"][point].get("buoyancy") and net["points"][point]["force"] is not None
        }  # free points, and an end there
        self._falling = any(time is not None or limit is not None for _, time, limit in failures)
        self.parted = []
        self.warnings = []
        self._partings = []
        self._doubted = set()  # of what the last warnings were

    @property
    def force(self):
        """Force [N] of the lines on the body at each fairlead, (F_x, F_z) or (F_x, F_y, F_z)."""
        force = self.forces
        return [
            (force[3 * k], force[3 * k + 2]) if y is not None else tuple(force[3 * k : 3 * k + 3])
            for k, y in enumerate(self._y)
        ]

    def end_force(self, line, end):
        """Force [N] of end A (0) or B (1) of a line, counted from 0, on what holds it; (3,).

        Second order accurate in the segment length, because the weight of half a segment is in it.
        It is 0 once the end has parted.
        """
        if self.parted and (line, end) in self._gone():
            return (0.0, 0.0, 0.0)
        at = 6 * line + 3 * end
        return tuple(self.end_forces[at : at + 3])

    def tensions(self):
        """Magnitudes [N] of the forces at ends B and A of each line."""
        return [
            (hypot(*self.end_force(k, 1)), hypot(*self.end_force(k, 0)))
            for k in range(len(self._names))
        ]

    def start(self, position, velocity, t=0.0, winch=()):
        """Begin at t [s] with the fairleads at `position` [m] with `velocity` [m/s].

        `winch` are the lengths [m] of lines that have one. Lines are at rest, in the equilibrium
        without waves. MooringError if MoorDyn cannot start there.
        """
        position = [tuple(p) for p in position]
        pairs = zip(position, self._y, strict=True)
        flat = [*chain(*(p if len(p) == 3 else (p[0], y, p[1]) for p, y in pairs))]
        net, found = None, False
        if self._net is not None and all(map(isfinite, flat)):
            net = Net(self._net, flat, dict(zip(self._winches, winch, strict=False)))
            found = net.settle_in(self.course.current) if self.course else net.settle()
        if found and self._at_rest:
            change = partial(with_nodes, net=net)
            report = self.create(self._text, flat, change=change)
        else:
            report = self.create(self._text, flat, search=True)
        self.parted = []
        self.begin(flat, winch, t)
        self.warnings = [
            *self._notes,
            *unplaced(self._fairleads, position, self._placed),
            *below_seabed(self._fairleads, position, self._bed),
            *(too_long(net, self._names) if net is not None else ()),
            *self._unrest(net if found else None),
            *(high_anchors(self._net["points"], self._net["bed"]) if self._net else ()),
            *warnings_in(report, equilibrium_known=found),
        ]
        if self.course:
            self.course.begin(self, t)
            self.evaluate()
        self._part_where_due(t)
        self.settle(velocity)
        shortest = min(self.lengths, default=inf)
        self.warnings += misplaced(self._drawn, position, shortest=shortest)
        remedy = "check the initial positions of its fairleads, and its length"
        self.warnings += self._beyond(START_STRAIN, remedy).values()
        self._doubted = set(self._beyond(LARGE_STRAIN, remedy))
        self.warnings += self.news()

    def advance(self, t, h, position, velocity, winch=()):
        """Advance from t over h [s]: fairleads end at position + velocity·h. MooringError.

        `position` [m] is meant at t, `velocity` [m/s] is the mean of the step. Where MoorDyn's
        fairlead is elsewhere at t, its velocity is adjusted so that the end coincides. The path is
        a parabola, from the velocity that was given at t by `settle`, else from the mean of the
        step before in its middle; the velocity at the end is then its own. `winch` are length [m]
        at t and its rate [m/s] of each line that has a winch.
        """
        self.step(t, h, position, velocity, winch)
        if self._falling:
            self._part_where_due(t + h)

    def part(self, failure):
        """Let the ends of a failure, by its number, part from what they are at, unless they have.

        They go on at a free point of their own.
        """
        if failure in self.parted:
            return
        count = len(self._groups())
        self.parted.append(failure)
        self.replace(self._parted_text(), [self.end_motion(*g[0]) for g in self._groups()[count:]])

    def _gone(self):
        """(line, end) of all that have parted."""
        return [*chain(*self._groups())]

    def _groups(self):
        """Those that parted together, each end where it parted first."""
        gone, groups = set(), []
        for k in self.parted:
            groups.append([end for end in self._failures[k][0] if end not in gone])
            gone.update(groups[-1])
        return [group for group in groups if group]

    def _parted_text(self):
        return with_free_ends(self._text, self._groups())

    def _part_where_due(self, t):
        for k, (ends, time, tension) in enumerate(self._failures):
            late = time is not None and t >= time
            pulls = {line: hypot(*self.end_force(line, end)) for line, end in ends}
            torn = tension is not None and max(pulls.values()) >= tension
            if (late or torn) and k not in self.parted:
                texts = (f"{self._names[line]} of {pull:.4g} N" for line, pull in pulls.items())
                self._partings.append(f"parted at t = {t:.6g} s: {', '.join(texts)}")
                self.part(k)

    def point_position(self, ends):
        """(x, y, z) [m] of a point at which (line, end) are that have not all parted from it."""
        left = [end for end in map(tuple, ends) if end not in self._gone()] or ends
        return self.end_motion(*left[0])[:3]

    def touchdown(self, line, heights):
        """The part [m] of a line on a flat seabed, from end A on; nodes at `heights` [m]."""
        return lying([z - self._bed for z in heights], self.length(line))

    def save(self):
        """All that later results depend on, as JSON values and bytes."""
        return {
            "system": self.saved(),
            "state": bytes(self.state),
            "parted": list(self.parted),
            "water": self.course.now if self.course else [],
        }

    def restore(self, saved):
        """Go back to what `save` returned, here or in another instance of the same lines.

        MooringError if it is of other lines.
        """
        if not self.running or self.parted != saved["parted"]:
            self.parted = list(saved["parted"])
            self.recreate(self._parted_text(), saved["state"])
        self.take_back(saved["system"], saved["state"])
        if self.course:
            self.course.now = saved["water"]

    def _unrest(self, net):
        """A text for each line that does not start at rest; `net` is its equilibrium, if known."""
        tensions = [(a, b) for b, a in self.tensions()]
        if net is not None:
            cause = "MoorDyn finds other forces than m4e_fmi" if self._at_rest else SWITCHED_OFF
            return away_from(net, self._names, tensions, cause)
        forces, counts = self.inner_forces(), self.segments
        remedy = MORE_TIME if self._net is None and self._at_rest else LATER
        texts = left_over(self._names, forces, tensions, counts, remedy)
        if not texts and self._net is not None and self._at_rest:
            worst = max(zip(forces, self._names, strict=True))
            return [f"{NOT_FOUND}: it leaves {worst[0]:.3g} N on a node of {worst[1]}"]
        return texts

    def news(self):
        """Texts on lines that parted or overstretched, and buoys that rose, since the last call."""
        heights = {
            point: self.end_places[6 * line + 3 * end + 2]
            for point, (line, end) in self._buoyant.items()
            if (line, end) not in self._gone()
        }
        remedy = "check its length and stiffness, and the forces on the body"
        found = self._beyond(LARGE_STRAIN, remedy)
        if heights:
            found |= above_water(self._net["points"], heights)
        texts = [text for key, text in found.items() if key not in self._doubted]
        texts += self._partings
        self._doubted, self._partings = set(found), []
        return texts

    def _beyond(self, strain, remedy):
        """A text, by number, for each line with ends further apart than (1 + strain)·length."""
        texts = {}
        place = self.end_places[:]
        for k, length in enumerate(map(self.length, range(len(self.lengths)))):
            distance = dist(place[6 * k : 6 * k + 3], place[6 * k + 3 : 6 * k + 6])
            if distance > (1 + strain) * length:
                texts[k] = (
                    f"the ends of {self._names[k]} are {distance:.6g} m apart, "
                    f"{100 * (distance / length - 1):.3g} % beyond its unstretched length of "
                    f"{length:.6g} m, and it pulls {self.tensions()[k][0]:.3g} N: {remedy}"
                )
        return texts
