"""The water's motion at the nodes of lines during a step.

Travels inside the FMU: imports numpy and the standard library only.

MoorDyn takes velocities and accelerations of the water at its nodes, and keeps them during a call.
To compute them is expensive, and they change slowly: they are computed at three times of an
interval, where the nodes would be with the velocities that they have at its beginning. In between
they are quadratic in time. The end of an interval is the beginning of the next: nothing jumps.
"""

import ctypes

import numpy as np

LONGEST = 0.1  # [s] of an interval


class WaterCourse:
    """The motion of the `water` at the nodes of lines, in time.

    `water.at(t, places)` gives velocity and acceleration (2, n, 3) [m/s, m/s2] at t [s] and places
    (n, 3) [m], `water.steady(places)` those without waves. All later motions depend on the present
    one and on the state of the lines, a `MoorDynSystem`.
    """

    longest = LONGEST

    def __init__(self, water):
        self._water = water
        self._motions = np.zeros((4, 2, 0, 3))  # begin, middle, end of an interval, and the loop's

    def room(self, nodes):
        """Numbers for the motions of so many nodes, which the loop over MoorDyn reads: flat."""
        room = (ctypes.c_double * (24 * nodes))()
        self._motions = np.frombuffer(room).reshape(4, 2, nodes, 3)
        return room

    @property
    def now(self):
        """The present motion, as a flat list."""
        return self._motions[2].ravel().tolist()

    @now.setter
    def now(self, values):
        self._motions[2] = np.reshape(values, self._motions.shape[1:])

    def current(self, places):
        """Velocities (n, 3) [m/s] of the water without waves at `places` (n, 3) [m]."""
        return self._water.steady(places)[0]

    def be_calm(self, lines):
        """Let there be no waves for now."""
        places, _ = _at(lines)
        self._motions[2] = self._water.steady(places)

    def begin(self, lines, t):
        """Take the motion at `t` [s] where the nodes are."""
        places, _ = _at(lines)
        self._motions[2] = self._water.at(t, places)

    def sample(self, lines, t, end):
        """Take the motions from `t` to `end` [s]; the present one becomes that at the end."""
        places, speeds = _at(lines)
        self._motions[0] = self._motions[2]
        for k, time in ((1, (t + end) / 2), (2, end)):
            self._motions[k] = self._water.at(time, places + speeds * (time - t))


def _at(lines):
    """Places [m] and velocities [m/s] (n, 3) of the nodes."""
    return (np.array(values).reshape(-1, 3) for values in lines.nodes())
