"""Slave of the mooring FMU: passes fairlead motion to the lines and their forces back."""

import json
import sys
from itertools import chain

from pythonfmu.enums import Fmi2Status

from .line_system import LineSystem  # type: ignore  # side by side in the FMU
from .slave_base import M4eSlave  # type: ignore

ROUNDING = 1e-6  # of speeds


class MooringSlave(M4eSlave):
    """Mooring lines: a `LineSystem` with the input `lines.txt` and arguments `mooring.json`.

    Where `water.json` is, the water moves.
    """

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        text = (self.resources / "lines.txt").read_text(encoding="utf-8")
        system = json.loads((self.resources / "mooring.json").read_text(encoding="utf-8"))
        self._line_names = system["lines"]
        axes = ["xyz" if y is None else "xz" for y in system["fairleads"]]
        self._motion, self._speed, forces = (
            [[self.index[f"{name}.{kind}{axis}"] for axis in axes] for name, axes in pairs]
            for kind, pairs in (
                (kind, list(zip(system["names"], axes, strict=True)))
                for kind in ("", "v", "force_")
            )
        )
        self._outputs = [
            *chain(*forces),
            *(
                self.index[f"{name}.{end}_tension"]
                for end in ("anchor", "fairlead")
                for name in self._line_names
            ),
        ]
        self._water, self._of_water, self._values_of_water = None, [], []
        nodes, names = system.pop("nodes"), system.pop("files")
        self._parting = {
            self.index[f"{line}.parted"]: failure for line, failure in system.pop("parting").items()
        }
        self._winches = [
            [self.index[f"{self._line_names[line]}.{kind}"] for line in system["winches"]]
            for kind in ("length", "length_rate")
        ]
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
        self._nodes = {
            (line, node): [self.index[f"{name}.node_{axis}[{k}]"] for axis in "xyz"]
            for line, name in enumerate(self._line_names)
            for k, node in enumerate(nodes[name], start=1)
        }
        self._of_nodes = {place for places in self._nodes.values() for place in places}
        self._nodes_known = True
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
        self._fastest = water.pop("fastest")
        self._water = MovingWater(code, **water)
        return WaterCourse(self._water)

    def _set_water(self):
        """Give the water the values of its parameters; return them."""
        values = [self.values[k] for k in self._of_water]
        if self._water is not None and values != self._values_of_water:
            self._water.set(values)
            self._check_speed(self._water.speed())
            self._values_of_water = values
        return values

    def _check_speed(self, speed):
        """Raise ValueError if the internal step is not stable in water of that `speed` [m/s]."""
        if self._fastest is not None and speed > self._fastest * (1 + ROUNDING):
            raise ValueError(
                f"waves and current reach {speed:.3g} m/s with these parameters, but the lines' "
                f"internal step is stable up to {self._fastest:.3g} m/s: write the largest waves "
                "and current in their sections, and build anew, or give a shorter solver.time_step"
            )

    def initialise(self):
        """Start the lines, unless they have started with the same motion and waves."""
        given = (self._taken(self._motion), self._taken(self._speed), self._set_water())
        lengths = self._taken(self._winches)[0]
        if (*given, lengths) != self._started_with:
            self._lines.start(*given[:2], self.time, lengths)
            self._started_with = (*given, lengths)
            self._warn(self._lines.warnings)

    def _taken(self, places):
        """The values of variables, by groups of value references."""
        values = self.values
        return [[values[k] for k in group] for group in places]

    def _warn(self, texts):
        for text in texts:
            self.log(f"{self.instance_name}: {text}", status=Fmi2Status.warning)

    def step(self, t, h):
        """Advance from t over h [s]."""
        self._set_water()
        winch = [x for pair in zip(*self._taken(self._winches), strict=True) for x in pair]
        self._lines.advance(t, h, self._taken(self._motion), self._taken(self._speed), winch)
        self._warn(self._lines.overstretched() + self._lines.surfaced())

    def update(self):
        """Set the outputs for the present inputs."""
        for place, failure in self._parting.items():
            if self.values[place]:
                self._lines.part(failure)
        self._lines.settle(self._taken(self._speed))
        values, tensions = self.values, self._lines.tensions()
        for place, found in zip(self._outputs, chain(*self._lines.force, *tensions), strict=True):
            values[place] = found
        self._nodes_known = False

    def get_real(self, vrs):
        """Values of real variables; places of nodes are looked up only if they are read."""
        if not self._of_nodes.isdisjoint(vrs):
            super().get_real([])
            self._guard(self._place_nodes)
        return super().get_real(vrs)

    def _place_nodes(self):
        """Bring the places of the nodes up to date."""
        if self._nodes_known or not self._lines.running:
            return
        for (line, node), places in self._nodes.items():
            for place, part in zip(places, self._lines.node_position(line, node), strict=True):
                self.values[place] = part
        self._nodes_known = True

    def save(self):
        """All that later results depend on, as JSON values and bytes."""
        return self._lines.save() if self._lines.running else {}

    def restore(self, saved):
        """Go back to what `save` returned."""
        self._started_with = None
        self._nodes_known = False
        self._set_water()
        if saved:
            self._lines.restore(saved)

    def finish(self):
        """Free the lines, whose last places can still be read."""
        self._place_nodes()
        self._lines.close()
