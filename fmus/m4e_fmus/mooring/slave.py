"""Slave of the mooring FMU: passes fairlead motion to the lines and their forces back."""

import json
import sys
from itertools import chain, islice
from math import atan2, hypot

from pythonfmu.enums import Fmi2Status

from .line_system import LineSystem  # type: ignore  # side by side in the FMU
from .slave_base import M4eSlave  # type: ignore

SAFEST = 1e3  # the largest safety factor


class MooringSlave(M4eSlave):
    """Mooring lines: a `LineSystem` with the input `lines.txt` and arguments `mooring.json`.

    Where `water.json` is, the water moves.
    """

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        text = (self.resources / "lines.txt").read_text(encoding="utf-8")
        system = json.loads((self.resources / "mooring.json").read_text(encoding="utf-8"))
        self._line_names = system["lines"]
        self._axes = [3 if y is None else 2 for y in system["fairleads"]]
        # place and velocity by turns, length and rate by turns, then forces and tensions
        moved, winches = 2 * sum(self._axes), 2 * len(system["winches"])
        self._place, self._speed = slice(0, moved, 2), slice(1, moved, 2)
        self._winch = slice(moved, moved + winches)
        last = self._winch.stop + sum(self._axes)
        self._forces = slice(self._winch.stop, last)
        self._tensions = slice(last, last + 2 * len(self._line_names))
        self._water, self._of_water, self._values_of_water = None, [], []
        nodes, names, looked_up = (system.pop(key) for key in ("nodes", "files", "looked_up"))
        self._anchors, self._points = system.pop("anchors"), system.pop("points")
        self._strengths, self._flat = system.pop("strengths"), system.pop("flat")
        self._parting = {
            self.index[f"{line}.parted"]: failure for line, failure in system.pop("parting").items()
        }
        self._lines = LineSystem(
            text,
            course=self._moving_water(),
            place=self.resources,
            runtime=self.resources / f"runtime.{sys.platform}",
            files={
                name: (self.resources / f"file_{k}").read_bytes() for k, name in enumerate(names)
            },
            **system,
        )
        self._nodes = [
            [
                (4 * node + k, self.index[f"{name}.{value}[{number}]"])
                for k, value in enumerate(("node_x", "node_y", "node_z", "tension"))
                for number, node in enumerate(nodes[name], start=1)
            ]
            for name in self._line_names
        ]
        self._slow = {self.index[name] for name in looked_up}
        self._slow.update(range(self._tensions.start, self._tensions.stop))
        self._slow_known = True
        self._started_with = None

    def _moving_water(self):
        """The course of the water of `water.json`; None if there is none: it stands still."""
        file = self.resources / "water.json"
        if not file.exists():
            return None
        from . import water as code  # type: ignore
        from .moving_water import MovingWater  # type: ignore
        from .water_course import WaterCourse  # type: ignore

        water = json.loads(file.read_text(encoding="utf-8"))
        self._of_water = [self.index[name] for name in water.pop("parameters")]
        self._water = MovingWater(code, **water)
        return WaterCourse(self._water)

    def _set_water(self):
        """Give the water the values of its parameters; return them."""
        values = [self.values[k] for k in self._of_water]
        if self._water is not None and values != self._values_of_water:
            self._water.set(values)
            self._values_of_water = values
        return values

    def initialise(self):
        """Start the lines, unless they have started with the same motion and waves."""
        place, speed = iter(self.values[self._place]), iter(self.values[self._speed])
        motion = [
            [tuple(islice(values, count)) for count in self._axes] for values in (place, speed)
        ]
        lengths = self.values[self._winch][::2]
        given = (*motion, lengths, self._set_water())
        if given != self._started_with:
            self._lines.start(*motion, self.time, lengths)
            self._started_with = given
            self._warn(self._lines.warnings)

    def _warn(self, texts):
        for text in texts:
            self.log(f"{self.instance_name}: {text}", status=Fmi2Status.warning)

    def step(self, t, h):
        """Advance from t over h [s]."""
        self._set_water()
        values = self.values
        motion = [values[self._place]], [values[self._speed]]
        self._lines.advance(t, h, *motion, values[self._winch])
        self._warn(self._lines.news())

    def update(self):
        """Set the outputs for the present inputs."""
        for place, failure in self._parting.items():
            if self.values[place]:
                self._lines.part(failure)
        self._lines.settle([self.values[self._speed]])
        self.values[self._forces] = [*chain(*self._lines.force)]
        self._slow_known = False

    def get_real(self, vrs):
        """Values of real variables; what takes time is looked up only if it is read."""
        if not self._slow.isdisjoint(vrs):
            super().get_real([])
            self._guard(self._look_up)
        return super().get_real(vrs)

    def _look_up(self):
        """Bring what is looked up up to date: tensions, nodes, points, anchors, touchdown."""
        if self._slow_known or not self._lines.running:
            return
        found, values = {}, self.values
        tensions = self._lines.tensions()
        values[self._tensions] = [*chain(*tensions)]
        for line, (name, both) in enumerate(zip(self._line_names, tensions, strict=True)):
            along = self._lines.along(line)
            for k, place in self._nodes[line]:
                values[place] = along[k]
            if self._flat:
                found[f"{name}.touchdown"] = self._lines.touchdown(line, along[2::4])
            if name in self._strengths:
                share = max(1 / SAFEST, max(both) / self._strengths[name])
                found[f"{name}.safety_factor"] = 1 / share
        for name, ends in self._points.items():
            found.update(zip(_along(name), self._lines.point_position(ends), strict=True))
        for name, ends in self._anchors.items():
            pulls = [self._lines.end_force(*end) for end in ends]
            force = [sum(parts) for parts in zip(*pulls, strict=True)]
            found.update(zip(_along(f"{name}.force", "_"), force, strict=True))
            found[f"{name}.uplift_angle"] = max(0.0, atan2(force[2], hypot(*force[:2])))
        for name, value in found.items():
            values[self.index[name]] = value
        self._slow_known = True

    def save(self):
        """All that later results depend on, as JSON values and bytes."""
        return self._lines.save() if self._lines.running else {}

    def restore(self, saved):
        """Go back to what `save` returned."""
        self._started_with = None
        self._slow_known = False
        self._set_water()
        if saved:
            self._lines.restore(saved)

    def finish(self):
        """Free the lines, whose last places can still be read."""
        self._look_up()
        self._lines.close()


def _along(name, mark="."):
    return [f"{name}{mark}{axis}" for axis in "xyz"]
