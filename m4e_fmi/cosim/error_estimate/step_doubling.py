"""Online estimate of the coupling error: parts of the run are repeated.

**Smooth motions.** Two runs by an algorithm of order p from one point, y at the step H and z at 2H,
differ by most of the error of the second:

    error of y = |y − z| / (2^p − 1)

So at the end of a *window* of steps the FMUs go back to its start, repeat it in half as many steps
of twice the length, and return; the run itself does not change. Nothing is assumed of the FMUs, and
errors propagate in both runs as they do. The first 2048 steps are a window. Then follow octaves
(2048 to 4096, 4096 to 8192 ...) of which the first sixteenth is one. Jumps that FMUs announce, and
steps about kinks, are the same in both runs; where this leaves steps that are not longer, the
differences are scaled up.

Where steps of twice the length are not possible (they fail or grow without bound, most of them
would end at jumps, values were set between the run's steps, a component's own points are not met) a
window is repeated at H/2, and the error of y is |y − z| 2^p / (2^p − 1).
Values are set there as in the run. This costs twice the steps of the window again. Beyond its
window an error may go on growing: see `windows`. `repeated_windows` repeats them, and
`stretch_errors` decides which.

**Everywhere else** fourth differences of the outputs are watched in every step (`roughness`), in
*stretches*. One that is rougher than all windows, apart from its kinks, becomes a window too, whose
errors count for that stretch alone.

**Kinks and jumps** that no FMU announces (a contact, a switch) lower the order where they are, and
what they change remains. From the stretch in which the first is found, the run is *followed*: a
second run makes the same steps, but those about kinks sixteen times finer. It is the run without
the errors of kinks, so that |y − z| is their part of the error, in all that follows; it adds to
that of smooth motions, of which all these stretches are windows. It ends where its difference has
died out. Kinks smaller than a tenth of the error that is known already are ignored.

**Many kinks** that matter less than smooth steps (lines that touch the seabed make one every few
steps) are no more followed than all smooth steps are repeated. After `MANY`, windows stand for all
kinks that are not rougher than theirs, and steps of twice the length are made about these too. That
holds if the errors of the followed run are less than a third of those of windows, and do not grow;
where none is followed, if the errors of smooth motions and kinks together fall by the order of the
algorithm. Where kinks matter more, they may change all that follows, and the run is followed to its
end. Where rougher ones come later, it is followed and decided anew.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.repeated_steps import FAR
from m4e_fmi.cosim.error_estimate.repeated_windows import RepeatedWindows
from m4e_fmi.cosim.error_estimate.roughness import Roughness
from m4e_fmi.cosim.error_estimate.state import StepDoublingSnapshot, StepDoublingState
from m4e_fmi.cosim.error_estimate.stretch import Stretch
from m4e_fmi.cosim.error_estimate.stretch_errors import StretchErrors
from m4e_fmi.cosim.exchange.failures import LostError
from m4e_fmi.cosim.exchange.network import Change, Network, NetworkSnapshot
from m4e_fmi.cosim.exchange.operations import Operation, gather
from m4e_fmi.cosim.stepping.algorithm import Algorithm
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.energy import BLOCK
from m4e_fmi.errors import RunError
from m4e_fmi.signals import Terminated

FIRST, SHARE = 2048, 16
"""Steps of the first window; octaves over windows after it."""
PART = 4
"""Steps of the run over those of a stretch without windows."""


class StepDoublingEstimator:
    """Estimates the error of a run of `network` by an algorithm of this `order`.

    `make` makes the algorithm anew. The `operations` are to be performed after each step of the
    run. `lengths` are those of repeated steps over the run's, TWICE and HALF, to be tried in this
    order. `spans` gives the range of all outputs of its unit for the range of each source. `coarse`
    says why there are no steps of a part of the length, if so.
    """

    def __init__(
        self,
        network: Network,
        make: Callable[[Network], Algorithm],
        sources: np.ndarray,
        lengths: Sequence[float],
        *,
        order: int,
        spans: Callable[[np.ndarray], np.ndarray],
        coarse: str,
    ) -> None:
        self._network, self._sources = network, sources
        self._windows = RepeatedWindows(network, make, sources, lengths, order=order, coarse=coarse)
        self._roughness = Roughness(network)
        self._errors = StretchErrors(
            network, self._windows, self._roughness, sources, coarse=coarse
        )
        self.longer: Mapping[str, str] = {}
        self._values = np.zeros((BLOCK, len(sources)))
        self.operations: tuple[Operation, ...] = (
            gather(self._values, network.values, sources),
            self._roughness.operation,
        )
        self._state = StepDoublingState(
            spans_of=spans,
            lengths=tuple(lengths),
            coverage=Coverage(self._now, self._now),
            bounds=np.repeat(network.values[sources][None], 2, axis=0),
            leaps=np.zeros(len(sources)),
            kinked=np.zeros(len(sources)),
            kinked_since=np.zeros(len(sources)),
            watched=np.zeros(len(network.outputs)),
            rough=np.zeros(len(network.outputs)),
        )

    @property
    def failure(self) -> str:
        """Why the errors are not known, if so."""
        return self._state.failure

    @property
    def _now(self) -> int:
        """The time [ns] of the network."""
        return round(self._network.time * NS_PER_SECOND)

    def before(self) -> None:
        """Before a step of the run: ends a stretch, and keeps the point where the next begins."""
        self._close_whole()
        state = self._state
        if state.stretch is not None or state.failure:
            return
        window = state.steps == state.begins
        if window:
            state.begins = max(2 * state.begins, FIRST)
            end = state.steps + (state.steps // SHARE or FIRST)
        else:
            end = min(state.begins, state.steps + max(1, state.steps // PART))
        start, values = self._network.keep(), self._network.values[self._sources][None]
        recorded = window or state.followed is not None
        state.stretch = Stretch(start, window, recorded, end, [values], self._now)
        self._roughness.start_over()

    def halt(self) -> None:
        """End repeated steps at the next point, called by another thread."""
        self._windows.halt()

    def changed(self, changes: Sequence[Change]) -> None:
        """Account for values that were set at the present point, and exchanged."""
        self._close_whole()
        self._roughness.forget()
        state = self._state
        if state.stretch:
            state.stretch.changes.setdefault(self._now, []).extend(changes)
        elif state.followed:
            end = self._network.keep()
            with self._network.rehearsing():
                try:
                    self._network.restore(state.followed.point)
                    self._network.change(changes)
                    state.followed = replace(state.followed, point=self._network.keep())
                finally:
                    self._network.restore(end)

    def snapshot(self) -> StepDoublingSnapshot:
        """The state at the present point."""
        return StepDoublingSnapshot(self._state.copy(), self._roughness.snapshot())

    def restore(self, snapshot: StepDoublingSnapshot) -> None:
        """Continue as from where the snapshot was taken, without estimates made since then."""
        self._state = snapshot.state.copy()
        self._roughness.restore(snapshot.roughness)

    @property
    def room(self) -> int:
        """Number of steps that may be made at once before `after` is called."""
        state = self._state
        if state.failure or state.stretch is None:
            return FAR
        return state.stretch.end - state.steps

    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None:
        """After so many steps of `size` [ns]; the operations have filled rows from `row` on.

        The last has `jumped`: what was before it is forgotten. The jump was `within` it, or else at
        its end.
        """
        state = self._state
        stretch = state.stretch
        state.steps += steps
        if stretch is None or not steps:
            return
        same, state.size = size == state.size, size
        if len(sudden := self._roughness.sudden(row, steps, same=same, jumped=jumped)):
            stretch.kinks.append(stretch.steps + sudden)
        if jumped or not same:
            self._roughness.forget()
        stretch.extend(steps, size)
        if within:
            stretch.kinks.append(stretch.steps + np.array([-1, 0]))  # it may show after the step
            stretch.within.append(stretch.last)
        if jumped:
            stretch.jumps.append(stretch.last)
        if stretch.recorded:
            stretch.values.append(self._values[row : row + steps].copy())

    def _close_whole(self) -> None:
        """Close a stretch that has all its steps; one that a signal interrupts stays open."""
        stretch = self._state.stretch
        if stretch is None or self._state.steps < stretch.end:
            return
        kept = self.snapshot()
        try:
            self._close()
        except (KeyboardInterrupt, Terminated):
            self.restore(kept)
            raise

    def _close(self) -> None:
        """Repeat the open stretch in steps of other lengths, for the errors that are wanted."""
        state = self._state
        stretch, state.stretch = state.stretch, None
        if stretch is None or not stretch.steps:
            return
        kinks = np.concatenate([np.zeros(0, dtype=np.intp), *stretch.kinks])
        kinks = kinks[kinks < stretch.steps]
        rough = self._errors.is_rough(state, self._roughness.largest)
        if rough and len(kinks) and state.crowded:  # they may be of another kind
            state.crowded, state.met = False, 0
            state.kinked_since = np.zeros_like(state.kinked)
        alone = len(kinks) > 0 and not state.crowded
        if not (stretch.window or rough or state.followed or alone):
            return
        end = self._network.keep()
        why = "they were interrupted"
        with self._network.rehearsing():
            try:
                why = ", and ".join(self._errors.repeat(state, stretch, kinks, rough=rough))
            finally:
                self._back_to(end, why)

    def _back_to(self, end: NetworkSnapshot, why: str) -> None:
        """Return to where the run is; RunError that says `why` repeated steps have failed."""
        at = f"the run was at t = {end.time:.9g} s, where its coupling error is estimated"
        try:
            self._network.restore(end)
        except LostError as error:
            raise RunError(f"{error.message}; {at}", error.remedy) from error
        except RunError as error:
            message = f"{at}: {why}; it cannot return there ({error.message})"
            remedy = "an FMU should discard a step that it cannot make, not return Fatal"
            raise RunError(message, remedy) from error

    def finish(self) -> None:
        """At the end of the run: evaluate the open stretch."""
        state = self._state
        try:
            self._close()
        except RunError as error:
            state.failure = error.message
        if not state.failure and not state.told:
            few = "the run has only one step" if state.steps else "the run has no steps"
            state.failure = "all steps end at jumps" if state.steps > 1 else few

    def errors(self, *, halved: bool = False) -> np.ndarray:
        """Largest known errors (n,) of the sources, in their units, or those at half the step."""
        return self._state.errors(self._now, halved=halved)

    def coverage(self) -> Coverage:
        """The part of the run up to the present point that was repeated."""
        return replace(self._state.coverage, end=self._now)

    def leaps(self) -> np.ndarray:
        """Largest known changes (n,) of the outputs within one step, in their units."""
        return self._state.leaps

    def ranges(self) -> np.ndarray:
        """Ranges (n,) of the sources where their values are known, in their units."""
        return self._state.ranges()
