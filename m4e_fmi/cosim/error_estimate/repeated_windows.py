"""Errors of windows: their steps are repeated at twice the length, or at half of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from m4e_fmi.cosim.error_estimate.kinks import GROWN, RESOLVED, first_events, roughness_at
from m4e_fmi.cosim.error_estimate.repeated_steps import Recorded, RepeatedRun
from m4e_fmi.cosim.error_estimate.report import over
from m4e_fmi.cosim.error_estimate.state import StepDoublingState
from m4e_fmi.cosim.error_estimate.step_times import doubled, halved, length_of_others
from m4e_fmi.cosim.error_estimate.stretch import Stretch
from m4e_fmi.cosim.error_estimate.windows import Told, pieces
from m4e_fmi.cosim.exchange.network import HALF, TWICE, Network
from m4e_fmi.cosim.stepping.algorithm import Algorithm
from m4e_fmi.errors import RunError

MEASURED = 128
"""Largest number of steps over which the order is measured."""
A_FEW = 8
"""Of many kinks, those over which the order is measured."""
LOST = 0.5
"""Kinks do not matter where the measured order is so much below the algorithm's at most."""


class UnknownError(Exception):
    """Steps of some length do not give the errors of a window; the text says why."""


class RepeatedWindows:
    """Repeats stretches of a run of `network` by an algorithm of this `order`.

    `make` makes the algorithm anew; `sources` (k,) are indices of the monitored outputs in the
    network's values. `lengths` are those of repeated steps over the run's, TWICE and HALF, tried in
    this order. `coarse` says why there are no steps of a part of the length, if so.
    """

    def __init__(
        self,
        network: Network,
        make: Callable[[Network], Algorithm],
        sources: np.ndarray,
        lengths: Sequence[float],
        *,
        order: int,
        coarse: str,
    ) -> None:
        self.others = {
            length: RepeatedRun(network, make, sources, length=length) for length in lengths
        }
        self.same = RepeatedRun(network, make, sources, length=1.0)
        self._network, self._order, self._coarse = network, order, coarse

    def halt(self) -> None:
        """End repeated steps at the next point, called by another thread."""
        for run in (*self.others.values(), self.same):
            run.halt()

    def recorded(self, stretch: Stretch) -> Recorded:
        """A stretch of the run; repeated where its values are not known."""
        times = stretch.times
        if stretch.recorded:
            return Recorded(times, np.concatenate(stretch.values))
        return self._repeated(self.same, stretch, times)

    def _repeated(self, run: RepeatedRun, stretch: Stretch, times: np.ndarray) -> Recorded:
        """Steps from the start of a stretch along `times` (n,) [ns]."""
        self._network.restore(stretch.start)
        return run.along(times, stretch.jumps, stretch.changes)

    def evaluate(
        self,
        state: StepDoublingState,
        stretch: Stretch,
        run: Recorded,
        alike: np.ndarray,
        *,
        kinked: bool,
    ) -> list[str]:
        """Add the errors of a stretch, which may be `kinked`, to the state.

        Steps that end at the times `alike` (k,) [ns] are the same in both runs. Returned are the
        reasons why repeated steps have failed; where all have, they are the state's `failure`.
        """
        why: list[str] = []
        if stretch.steps == 1 and HALF not in state.lengths:
            return why  # a single step gives no difference
        wild: Told | None = None
        for length in state.lengths:
            try:
                found = self._errors(state, stretch, run, length, alike, kinked=kinked)
            except UnknownError as error:
                why.append(str(error))
                continue
            if found is None:
                return why
            told, better = found
            is_wild = over(told.largest, state.spans_of(better.ranges)).max() > GROWN
            if is_wild and length == TWICE and HALF in state.lengths:
                wild = told
                continue
            if wild and not is_wild:
                _give_up(state, TWICE)  # it is these steps that grow, and not the run
                wild = None
            state.add_window(wild or told, run if wild else better)
            return why
        if wild:
            state.add_window(wild, run)
        else:
            state.failure = ", and ".join(why)
        return why

    def _errors(
        self,
        state: StepDoublingState,
        stretch: Stretch,
        run: Recorded,
        length: float,
        alike: np.ndarray,
        *,
        kinked: bool,
    ) -> tuple[Told, Recorded] | None:
        """Errors by steps of this `length`, and the better of the two runs; or UnknownError.

        None if there is nothing but jumps.
        """
        twice = length == TWICE
        if twice and stretch.changes:
            raise UnknownError("values were set between steps")
        # a jump within a step is an error that nothing else tells where kinks are not followed
        unlike = set(stretch.within) if state.crowded or self._coarse else set()
        if self._coarse and HALF not in state.lengths:  # a step of the run cannot stand alone
            unlike = set(stretch.jumps)
        jumps = [time for time in stretch.jumps if time not in unlike]
        same, phase = sorted({*jumps, *alike.tolist()}), self._phase(state, run.times)
        times = doubled(run.times, same, phase=phase) if twice else halved(run.times, jumps)
        span, other = int(times[-1] - times[0]), length_of_others(times, run.times)
        if other < span / 2 or not span:
            if twice:
                raise UnknownError("most steps end at jumps")
            return None
        try:
            again = self._repeated(self.others[length], stretch, times)
        except RunError as error:
            _give_up(state, length)
            name = "twice" if twice else "half"
            raise UnknownError(f"steps of {name} the length fail ({error.message})") from error
        if state.falls is None and twice and HALF in state.lengths and self._order > 1:
            begin = run.first(min(MEASURED, run.steps // 4))
            state.falls = self._measured(state, stretch, begin, again, same)
        if state.falls is None:
            state.falls = float(self._order)
        order = self._order_for(state.falls, kinked=kinked)
        scale = span / other * (1.0 if twice else 2.0**order) / (2.0**order - 1)
        found, left = scale * pieces(run.off(again)), 2.0**-state.falls
        told = Told(found, int(run.times[0]), span, stretch.window, left)
        return told, run if twice else again

    def _order_for(self, falls: float, *, kinked: bool) -> float:
        """The order of the errors of a stretch, where smooth ones fall with the order `falls`."""
        if kinked and self._coarse:
            return 1.0  # as the errors of kinks, which are not known otherwise
        return max(1.0, min(falls, self._order) if kinked else falls)

    def _phase(self, state: StepDoublingState, run: np.ndarray) -> int | None:
        """Which of two steps of the run begins these times; None if no component has rarer ones."""
        if len(run) < 2 or not any(rate.is_longer for rate in self._network.rates.values()):
            return None
        return round((run[0] - state.coverage.start) / (run[1] - run[0])) % 2

    def _measured(
        self,
        state: StepDoublingState,
        stretch: Stretch,
        begin: Recorded,
        twice: Recorded,
        alike: Sequence[int],
    ) -> float | None:
        """The order over the `begin` of a stretch, measured by a third run, at H/2.

        It may be lower than the algorithm promises, as where FMUs are not linear in inputs that
        they hold, or higher by one; but higher it is not taken in a window with kinks, after which
        the motion is faster than where it was measured.

        None where differences are rounding, or so large that no order shows.
        """
        times = np.intersect1d(begin.times, twice.times, assume_unique=True)
        if len(times) < 2:
            return None
        try:
            half = self._repeated(self.same, stretch, halved(begin.times, alike))
        except RunError:
            return None
        spans = state.spans_of(begin.ranges)
        large, small = (
            over(begin.off(one, times).max(axis=0), spans).max() for one in (twice, half)
        )
        if small > 0.0 and 0.0 < large < RESOLVED:
            return float(np.clip(np.log2(large / small), 0.0, self._order + 1))
        return None

    def is_lower(
        self, state: StepDoublingState, stretch: Stretch, run: Recorded, kinks: np.ndarray
    ) -> bool:
        """True if many `kinks` (k,), indices, in a window lower the order of its errors."""
        if self._order == 1:
            return False  # all errors are as those of kinks
        roughest = over(roughness_at(kinks, run.values), state.spans()).max(axis=1).argmax()
        few = int(first_events(kinks, A_FEW)[-1])
        begin = run.first(min(max(few, int(kinks[roughest])) + MEASURED // 2, run.steps))
        end = int(begin.times[-1])
        met = [time for time in stretch.own_jumps if time <= end]
        times = doubled(begin.times, met, phase=self._phase(state, run.times))
        try:
            self._network.restore(stretch.start)
            if TWICE not in state.lengths:
                return True
            twice = self.others[TWICE].along(times, stretch.jumps, stretch.changes)
        except RunError:
            return True
        falls = self._measured(state, stretch, begin, twice, met)
        return falls is None or falls < self._order - LOST


def _give_up(state: StepDoublingState, length: float) -> None:
    """Make no more steps of this `length`."""
    state.lengths = tuple(one for one in state.lengths if one != length)
