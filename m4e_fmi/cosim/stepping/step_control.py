"""The size of the next step, from the error estimated in the last: adaptive communication steps.

An algorithm that can go back estimates in `change` the error of the outputs in its step. That,
over the *scale* of the output, is held below a tolerance: a step that exceeds it is taken back and
made again, smaller. The scale is the largest magnitude that any exchanged output of the same unit
has had, so that a signal near zero among large ones does not count for more than it is worth.

A signal that starts at zero has no magnitude yet: what a step reaches falls with its size as fast
as the error does, and no step would be small enough. So the scale is at least what any attempt has
reached, also one that was taken back; but of that no more than a hundredth of the nominal value,
because an attempt may have gone astray. (The nominal value, 1 where an FMU declares none, times the
tolerance times 0.01 is the absolute tolerance that FMI 2.0, section 2.2.7, proposes.)

The change falls with a power p of the step, so the next step is the last one times
0.9 (tolerance/error)^(1/p), but at most doubled, at least a fifth, and not larger right after a
rejection. Steps never exceed the `step_size` of the simulation.

Where an output jumps, steps shrink onto the jump; the smallest passes over it. So they do where an
output that is not Real changes. If the next step
misses the tolerance too, however small, it is no jump: that ends the run.

An estimate compares two ways of making a step. Both may take the same jump for a steep but smooth
motion, agree, and be wrong. So outputs are extrapolated, too, by the parabola through their last
three points (`JumpDetection`). Of a smooth motion that is resolved by the steps, the parabola
misses a small part; of a jump, all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.errors import RunError

SMALLEST = 1e-6
"""Smallest step, as a share of `step_size`."""
SAFETY, LEAST, MOST = 0.9, 0.2, 2.0
OF_NOMINAL = 0.01
"""Share of the nominal value up to which taken back attempts count."""
POINTS = 3
JUMPED = 0.5
"""Share of an output's movement in a step from which on missing it is a jump."""


@dataclass(eq=False)
class JumpDetection:
    """The last POINTS points of some outputs, of which some are `known`.

    `times` (POINTS,) are in ns, `values` (POINTS, n) in the outputs' units.
    """

    times: np.ndarray
    values: np.ndarray
    known: int = 0

    def note(self, time: int, values: np.ndarray) -> None:
        """Add the point at `time` [ns], where the outputs are `values` (n,), in their units."""
        self.times[1:], self.values[1:] = self.times[:-1].copy(), self.values[:-1].copy()
        self.times[0], self.values[0] = time, values
        self.known = min(self.known + 1, POINTS)

    def forget(self) -> None:
        """Drop the points before the last one, at which the outputs have jumped."""
        self.known = 1

    def missed(self, time: int, values: np.ndarray) -> np.ndarray:
        """Misses (n,) of outputs that are `values` (n,) at `time` [ns] and have jumped.

        They are in the outputs' units; zero for outputs that move smoothly, and as long as too few
        points are known.
        """
        if self.known < POINTS:
            return np.zeros_like(values)
        ahead = (time - self.times)[:, None]
        last, earlier, _ = steps = self.values
        by_time = np.diff(steps, axis=0) / np.diff(self.times)[:, None]
        bend = (by_time[0] - by_time[1]) / (self.times[0] - self.times[2])
        off = np.abs(values - last - ahead[0] * by_time[0] - ahead[0] * ahead[1] * bend)
        movement = np.maximum(np.abs(values - last), np.abs(last - earlier))
        return np.where(off > JUMPED * movement, off, 0.0)


class StepControl(Restorable):
    """Chooses steps for a relative `tolerance`; sizes are in nanoseconds, `largest` the first.

    Estimates fall with the power `order` of the step. `passed` is true if the last step has missed
    the tolerance, being the smallest: something has jumped in it. `rejected` counts the steps that
    were taken back.
    """

    restored = ("size", "rejected", "passed", "_just_rejected", "_scale", "_reached", "_jumps")

    def __init__(self, network: Network, tolerance: float, largest: int, order: int) -> None:
        self._network = network
        self._tolerance = tolerance
        self._order = order
        self._largest = largest
        self._smallest = max(1, round(SMALLEST * largest))
        self.size = largest
        self.rejected = 0
        self.passed = False
        self._just_rejected = False
        sources = {network.index(port) for _, port in network.monitored_outputs}
        self._sources = np.array(sorted(sources), dtype=np.intp)
        self._scale = Scale(network, self._sources)
        self._reached = np.zeros(len(self._sources))
        outputs = [network.outputs[k] for k in self._sources]
        start = network.values[: len(network.outputs)]
        self._jumps = JumpDetection(np.zeros(POINTS), np.zeros((POINTS, len(self._sources))))
        self._jumps.note(round(network.time * 1e9), start[self._sources])
        self._most_reached = OF_NOMINAL * np.array([network.nominal(port) for port in outputs])

    def accepts(self, change: np.ndarray, end: np.ndarray, now: int, size: int) -> bool:
        """True if a step of `size` from `now` [ns] may stand; sets the size of the next one.

        `change` and `end` (n_outputs,) are the changes and values of all exchanged outputs at its
        end, in their units. RunError naming the output if the smallest step is not small enough,
        twice running.
        """
        scale = self._scale.with_values(end)
        values = end[self._sources]
        changes = np.maximum(np.abs(change[self._sources]), self._jumps.missed(now + size, values))
        attempt = self._scale.with_values(np.abs(end) + np.abs(change))
        self._reached = np.maximum(self._reached, attempt)
        enough = np.maximum(scale, np.minimum(self._reached, self._most_reached))
        allowed = self._tolerance * enough  # 0 also of a value that is next to nothing
        ratios = changes / np.where(allowed > 0.0, allowed, 1.0)
        error = float(ratios.max(initial=0.0))
        factor = MOST if error == 0.0 else SAFETY * error ** (-1 / self._order)
        missed, smallest = error > 1.0, size <= self._smallest
        if missed and smallest and self.passed:
            worst = self._network.outputs[self._sources[int(ratios.argmax())]]
            raise RunError(
                f"the coupling error of {worst} at t = {self._network.time:.9g} s stays above "
                f"coupling_tolerance, even with steps of {size / 1e9:.3g} s",
                "its FMU does not repeat its outputs after rollback, or it jumps "
                "repeatedly: remove coupling_tolerance, or increase it",
            )
        accepted = not missed or smallest
        if accepted:
            self.passed = missed
            self._scale.keep(scale)
            self._jumps.note(now + size, values)
            if missed:
                self._jumps.forget()
            factor = min(max(factor, LEAST), 1.0 if self._just_rejected else MOST)
            cut_short = size < self.size and factor >= 1.0  # by the end, or a row of the results
            wanted = max(size * factor, self.size) if cut_short else size * factor
        else:
            self.rejected += 1
            wanted = size * min(max(factor, LEAST), SAFETY)
        self._just_rejected = not accepted
        self.size = int(min(max(wanted, self._smallest), self._largest))
        return accepted

    def shrinks(self, size: int) -> bool:
        """True if a step of `size` [ns] within which a value switches is to be made smaller."""
        if size <= self._smallest:
            return False
        self.rejected += 1
        self._just_rejected = True
        self.size = max(self._smallest, round(LEAST * size))
        return True

    def pass_over(self, end: np.ndarray, time: int) -> None:
        """Continue after a jump to `time` [ns].

        The exchanged outputs are `end` (n_outputs,) there, in their units.
        """
        self._scale.keep(self._scale.with_values(end))
        self._jumps.note(time, end[self._sources])
        self._jumps.forget()


class Scale(Restorable):
    """Largest magnitudes so far of some outputs, `sources`, shared among those of one unit.

    `sources` (n,) are places among the exchanged outputs.
    """

    restored = ("_largest",)

    def __init__(self, network: Network, sources: np.ndarray) -> None:
        self._sources = sources
        units = [network.unit(network.outputs[k]) for k in sources]
        known = sorted(set(units))
        self._group = np.array([known.index(unit) for unit in units], dtype=np.intp)
        self._largest = np.zeros(len(known))
        self.keep(self.with_values(network.values[: len(network.outputs)]))

    def with_values(self, values: np.ndarray) -> np.ndarray:
        """Scale (n,) of the outputs in their units, when all exchanged ones have these values.

        `values` (n_outputs,) are in the outputs' units.
        """
        largest = self._largest.copy()
        np.maximum.at(largest, self._group, np.abs(values[self._sources]))
        return largest[self._group]

    def keep(self, scale: np.ndarray) -> None:
        """Keep the `scale` (n,) that `with_values` has returned, in the outputs' units."""
        self._largest[self._group] = scale
