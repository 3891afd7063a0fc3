"""The water's motion at the nodes of lines during a step.

Travels inside the FMU: imports numpy and the standard library only.

MoorDyn takes velocities and accelerations of the water at its nodes, and keeps them during a step.
To compute them is expensive, and they change slowly: they are computed at three times of an
interval, where the nodes would be with the velocities that they have at its beginning. In between
they are quadratic in time. The end of an interval is the beginning of the next: nothing jumps.
"""

from math import ceil

import numpy as np

LONGEST = 0.1  # [s] of an interval


class WaterCourse:
    """The motion of the `water` at the nodes of lines, in time.

    `water.at(t, places)` gives velocity and acceleration (2, n, 3) [m/s, m/s2] at t [s] and places
    (n, 3) [m], `water.steady(places)` those without waves. `now` is the present motion as two flat
    lists; all later motions depend on it and on the state of the lines, a `MoorDynSystem`.
    """

    def __init__(self, water):
        self._water = water
        self.now = []
        self._interval = (0.0, 0.0)
        self._samples = []  # motions at the interval's beginning, in its middle, at its end

    def current(self, places):
        """Velocities (x, y, z) [m/s] of the water without waves at `places` [m]."""
        return self._water.steady(np.array(places))[0].tolist()

    def be_calm(self, lines):
        """Let there be no waves for now."""
        places, _ = lines.nodes()
        self.now = _flat(self._water.steady(np.array(places)))

    def begin(self, lines, t):
        """Take the motion at `t` [s] where the nodes are."""
        places, _ = lines.nodes()
        self.now = _flat(self._water.at(t, np.array(places)))

    def apply(self, lines, bounds, piece):
        """Give MoorDyn the motion in the middle of a `piece` of a step.

        `bounds` [s] of all pieces are equally spaced; they are taken in order from piece 0 on.
        """
        pieces = len(bounds) - 1
        size = ceil(pieces / ceil((bounds[-1] - bounds[0]) / LONGEST))
        if piece % size == 0:
            self._begin_interval(lines, bounds[piece], bounds[min(piece + size, pieces)])
        begin, end = self._interval
        s = ((bounds[piece] + bounds[piece + 1]) / 2 - begin) / (end - begin)
        first, middle, last = self._samples
        motion = (1 - 2 * s) * ((1 - s) * first - s * last) + 4 * s * (1 - s) * middle
        lines.set_water(*_flat(motion))

    def _begin_interval(self, lines, t, end):
        """Sample the motion from `t` to `end` [s]; `now` becomes that at the end."""
        places, speeds = (np.array(values) for values in lines.nodes())
        first = np.array(self.now).reshape(2, -1, 3)
        later = [self._water.at(s, places + speeds * (s - t)) for s in ((t + end) / 2, end)]
        self._interval, self._samples = (t, end), [first, *later]
        self.now = _flat(later[-1])


def _flat(motion):
    return motion.reshape(2, -1).tolist()
