"""Errors of a stretch that is repeated: those of smooth motions by windows, those of kinks by
following the run. See `step_doubling`.
"""

from __future__ import annotations

import numpy as np

from m4e_fmi.cosim.error_estimate.kinks import (
    NOISE,
    SMALL,
    about,
    events,
    first_of_each,
    rougher,
    smooth_roughness,
)
from m4e_fmi.cosim.error_estimate.repeated_steps import Recorded
from m4e_fmi.cosim.error_estimate.repeated_windows import RepeatedWindows
from m4e_fmi.cosim.error_estimate.roughness import Roughness
from m4e_fmi.cosim.error_estimate.state import StepDoublingState
from m4e_fmi.cosim.error_estimate.step_times import refined
from m4e_fmi.cosim.error_estimate.stretch import Followed, Stretch
from m4e_fmi.cosim.error_estimate.windows import Told, pieces
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.errors import RunError

MANY = 32
"""Kinks after which windows stand for others like them."""
ROUGHER = 2.0
"""Times as rough as all windows, from which on a stretch becomes a window too."""
DIED = 0.01
"""Share of the known error below which the run is not followed any more."""


class StretchErrors:
    """Adds the errors of stretches to a `StepDoublingState`, by steps that the `network` repeats.

    `windows` repeats steps, `roughness` has the fourth differences of the stretch, `sources` (n,)
    are the places of the outputs whose errors are wanted. `coarse` says why there are no steps of a
    part of the length, if so. After each method the network is anywhere.
    """

    def __init__(
        self,
        network: Network,
        windows: RepeatedWindows,
        roughness: Roughness,
        sources: np.ndarray,
        *,
        coarse: str,
    ) -> None:
        self._network, self._windows, self._roughness = network, windows, roughness
        self._sources, self._coarse = sources, coarse

    def is_rough(self, state: StepDoublingState, largest: np.ndarray) -> bool:
        """True if outputs with such fourth differences are rougher than windows have been.

        `largest` (n,) are those differences, in the outputs' units.
        """
        limit = np.maximum(ROUGHER * state.watched, self._roughness.gate)
        return bool((largest > limit).any())

    def repeat(
        self, state: StepDoublingState, stretch: Stretch, kinks: np.ndarray, *, rough: bool
    ) -> list[str]:
        """Repeat a stretch for its errors; why repeated steps have failed, if some have.

        `kinks` (k,) are the numbers of steps with kinks [1]; others are `rough` too, if so.
        """
        run, why = self._windows.recorded(stretch), []
        kinks = rougher(kinks, run, NOISE * run.largest)
        smooth = self._smooth(stretch, run, kinks)
        if state.told:
            kinks = rougher(kinks, run, state.of_known(SMALL))
        many = stretch.window and len(kinks) > 0 and state.met + events(kinks) >= MANY
        many = many and not (state.crowded or self._coarse)
        followed = state.followed is not None or (len(kinks) > 0 and not state.crowded)
        if stretch.window or followed or (rough and self.is_rough(state, smooth)):
            why = self._window(state, stretch, run, kinks, smooth, many=many)
            kinks = rougher(kinks, run, state.of_known(SMALL))
        if not state.failure and (state.crowded or state.followed or len(kinks)):
            why += self._kinks(state, stretch, run, kinks, many=many)
        return why

    def _smooth(self, stretch: Stretch, run: Recorded, kinks: np.ndarray) -> np.ndarray:
        """Largest fourth differences away from `kinks` (k,) and jumps; 0 if not monitored."""
        if not len(kinks) and not stretch.jumps and len(stretch.runs) == 1:
            return self._roughness.largest
        largest = np.zeros_like(self._roughness.largest)
        largest[self._sources] = smooth_roughness(run, kinks, stretch.jumps)
        return largest

    def _window(
        self,
        state: StepDoublingState,
        stretch: Stretch,
        run: Recorded,
        kinks: np.ndarray,
        smooth: np.ndarray,
        *,
        many: bool,
    ) -> list[str]:
        """Add the errors of a window; why repeated steps have failed, if some have."""
        if many and not state.kinked_since.any():
            state.crowded = not self._windows.is_lower(state, stretch, run, kinks)
        edges = run.times[1 + about(kinks, run.steps)]
        alike = not (state.crowded or self._coarse) and len(edges) < run.steps / 2
        kinked = state.crowded or len(kinks) > 0
        alike_at = edges if alike else edges[:0]
        why = self._windows.evaluate(state, stretch, run, alike_at, kinked=kinked)
        self._set_gates(state, run)
        if stretch.window:
            seen = self._roughness.largest if state.crowded else smooth
            state.watched = np.maximum(state.watched, seen)
        return why

    def _kinks(
        self,
        state: StepDoublingState,
        stretch: Stretch,
        run: Recorded,
        kinks: np.ndarray,
        *,
        many: bool,
    ) -> list[str]:
        """Follow the run about its kinks, or leave them to windows; why that fails, if so."""
        why = list[str]()
        first = int(run.times[kinks[0] if len(kinks) else 0])
        if state.crowded:
            state.met += events(kinks)
        elif self._coarse:
            state.coverage = state.coverage.lose(first, self._coarse)
        else:
            why = self._follow(state, stretch, run, kinks)
            self._set_gates(state, run)
            state.crowded = many and not state.kinks_outweigh(int(run.times[-1]))
        if state.crowded:
            if state.followed:
                state.watched = np.maximum(state.watched, state.rough)
            state.followed = None
            state.coverage = state.coverage.crowd(first)
        return why

    def _set_gates(self, state: StepDoublingState, run: Recorded) -> None:
        """Set the fourth differences from which on the monitored outputs count as rough."""
        known = state.of_known(SMALL)
        self._roughness.gate[self._sources] = np.maximum(NOISE * run.largest, known)

    def _follow(
        self, state: StepDoublingState, stretch: Stretch, run: Recorded, kinks: np.ndarray
    ) -> list[str]:
        """Repeat the stretch in finer steps about `kinks` (k,); why that fails, if so.

        The second run begins where it has ended before, or at the start of the stretch.
        """
        followed = state.followed
        times = refined(run.times, stretch.own_jumps, about(kinks, run.steps))
        begin, end = int(run.times[0]), int(run.times[-1])
        try:
            self._network.restore(followed.point if followed else stretch.start)
            again = self._windows.same.along(times, stretch.jumps, stretch.changes)
            point = self._network.keep()
        except RunError as error:
            state.followed = None
            why = f"steps of a part of the length fail ({error.message})"
            state.coverage = state.coverage.lose(begin, why)
            return [why]
        errors = run.off(again)
        state.add_kinks(errors.max(axis=0))
        state.widen(again)
        state.rough = np.maximum(state.rough, self._roughness.largest)
        if followed:
            since, first = followed.since, followed.told.begin
            largest = np.concatenate((followed.told.errors, pieces(errors)))
        else:
            since, first = begin, int(run.times[kinks[0]])
            largest = pieces(errors[kinks[0] :])
        state.coverage = state.coverage.follow(since, end, run.times[1 + first_of_each(kinks)])
        state.followed = Followed(point, since, Told(largest, first, end - first, speaks=True))
        state.met += events(kinks)
        if (errors[-1] <= state.of_known(DIED)).all():
            state.followed = None
        return []
