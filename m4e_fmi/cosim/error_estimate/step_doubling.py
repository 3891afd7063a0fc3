"""Online estimate of the coupling error: parts of the run are made a second time.

**Smooth courses.** Two courses of an algorithm of order p from one point, y at the step H and z at
2H, differ by most of the error of the second:

    error of y = |y − z| / (2^p − 1)

So at the end of a *window* of steps the FMUs go back to its start, make it again in half as many
steps of twice the length, and return; the run is not touched by it. Nothing is assumed of the FMUs,
and errors propagate in both courses as they do. The first 2048 steps are a window. Then follow
octaves (2048 to 4096, 4096 to 8192 ...) of which the first sixteenth is one. Jumps that FMUs
announce, and steps about kinks, are made by both courses alike; where this leaves steps that are
not longer, the differences are scaled up.

Where steps of twice the length cannot be (they fail or grow without bound, most of them would end
at jumps, values were set between the run's steps, a component's own points are not met) a window is
made again at H/2:

    error of y = |y − z| 2^p / (2^p − 1)

Values are set there as in the run. This costs twice the steps of the window again.

Beyond its window an error may go on growing: see `windows`.

**Everywhere else** fourth differences of the outputs are watched in every step (`roughness`), in
*stretches*. One that is rougher than all windows, apart from its kinks, is made a window too, which
tells of itself alone.

**Kinks and jumps** that no FMU announces (a contact, a switch) lower the order where they are, and
what they change remains. From the stretch in which the first is found, the run is *followed*: a
second course makes the same steps, but those about kinks sixteen times finer. It is the run without
the errors of kinks, so that |y − z| is their part of the error, in all that follows; it adds to
that of smooth courses, of which all these stretches are windows. It ends where its difference has
died out. Kinks smaller than a tenth of the error that is known already are passed over.

**Many kinks** that matter less than smooth steps (lines that touch the seabed make one every few
steps) are no more followed than all smooth steps are made twice. After MANY, windows speak for all
kinks that are not rougher than theirs, and steps of twice the length are made about these too. So
it is if a followed course has told less than a third of what windows have, and does not grow; where
there is none, if the errors of smooth courses and kinks together fall by the order of the
algorithm. Where kinks matter more, they may change all that follows, and the run is followed to its
end. Where rougher ones come later, it is followed and decided anew.

Going back to a saved state also discards what was learned since then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.repeated_steps import (
    FAR,
    ROUNDING,
    Recorded,
    SecondCourse,
    about,
    doubled,
    events,
    first_events,
    first_of_each,
    halved,
    other_steps,
    refined,
)
from m4e_fmi.cosim.error_estimate.report import over
from m4e_fmi.cosim.error_estimate.roughness import HISTORY, Roughness, fourth_differences
from m4e_fmi.cosim.error_estimate.stretch import Followed, StepDoublingSnapshot, Stretch
from m4e_fmi.cosim.error_estimate.windows import Told, pieces, throughout
from m4e_fmi.cosim.exchange.layout import NetworkSnapshot
from m4e_fmi.cosim.exchange.network import HALF, TWICE, Change, Network
from m4e_fmi.cosim.exchange.operations import Operation, gather
from m4e_fmi.cosim.stepping.algorithm import Algorithm
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.time_loop.energy import BLOCK
from m4e_fmi.errors import RunError

FIRST, SHARE = 2048, 16
"""Steps of the first window; octaves over windows after it."""
PART = 4
"""Steps of the run over those of a stretch without windows."""
MEASURED = 128
"""Steps over which the order is measured, at most."""
MANY = 32
"""Kinks after which windows speak for others like them."""
A_FEW = 8
"""Of many kinks, those that the order is measured over."""
LOST, LITTLE = 0.5, 1 / 3
"""Kinks do not matter where the order is so much lower than the algorithm's at most, or their error
so small beside that of smooth steps."""
NOISE = 8 * ROUNDING
"""Share of the largest value up to which a fourth difference says nothing."""
SMALL = 0.1
"""Share of the known error up to which a kink is passed over."""
ROUGHER = 2.0
"""Times as rough as all windows, from which on a stretch is made a window too."""
RESOLVED = 0.3
"""Difference over range up to which the order of an algorithm shows."""
GROWN = 2.0
"""The same from which on the error is not that of values within the range any more."""
DIED = 0.01
"""Share of the error that is known below which the run is not followed any more."""


def _nanoseconds(time: float) -> int:
    return round(time * NS_PER_SECOND)


def halved_kinks(errors: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Errors (n,) of kinks at half the step: of first order.

    A jump that comes at another point is an error of its size, about the range, however short the
    steps. Beyond that it is growth, and the step that is too long.
    """
    jumps = (errors > RESOLVED * spans) & (errors <= GROWN * spans)
    return errors * np.where(jumps, 1.0, 0.5)


class _UntoldError(Exception):
    """A course of steps of some length cannot tell the errors of a window; why not."""


class StepDoublingEstimator:
    """Follows a run of `network` by an algorithm of this `order`, which `make` makes anew.

    The `operations` are to be performed after each step of the run. `lengths` are those of the
    other course's steps over the run's, TWICE and HALF, to be tried in this order. `spans` gives
    the range of all outputs of its unit for the range of each source. `coarse` says why there are
    no steps of a part of the length, if so.
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
        self._network = network
        self._others = {c: SecondCourse(network, make, sources, length=c) for c in lengths}
        self._same = SecondCourse(network, make, sources, length=1.0)
        self._coarse = coarse
        self._order, self._sources, self._spans = order, sources, spans
        self._falls: float | None = None  # the order of smooth errors as measured, 0 at least
        self._roughness = Roughness(network)
        self._values = np.zeros((BLOCK, len(sources)))
        self.operations: tuple[Operation, ...] = (
            gather(self._values, network.values, sources),
            self._roughness.operation,
        )
        self._steps = self._begins = self._size = 0
        self._stretch: Stretch | None = None
        self._told: list[Told] = []
        self._bounds = np.repeat(network.values[sources][None], 2, axis=0)
        self._kinked = np.zeros(len(sources))  # the largest differences of the followed course
        self._kinked_since = self._kinked  # since they may be of another kind
        self._met = 0  # kinks since then in windows, or where the run was followed
        self._crowded = False  # whether they are many, and windows tell of them
        self._followed: Followed | None = None
        self._watched = np.zeros(len(network.outputs))  # how rough windows have been
        self._rough = np.zeros(len(network.outputs))  # and what was followed
        self._start = _nanoseconds(network.time)
        self._coverage = Coverage(self._start, self._start)
        self.failure = ""
        """Why nothing can be told, if so."""

    def before(self) -> None:
        """Before a step of the run: keeps the point where a stretch begins."""
        if self._stretch is not None or self.failure:
            return
        window = self._steps == self._begins
        if window:
            self._begins = max(2 * self._begins, FIRST)
            end = self._steps + (self._steps // SHARE or FIRST)
        else:
            end = min(self._begins, self._steps + max(1, self._steps // PART))
        start = self._network.keep()
        now, values = _nanoseconds(start.time), self._network.values[self._sources][None]
        recorded = window or self._followed is not None
        self._stretch = Stretch(start, window, recorded, end, [values], now)
        self._roughness.start_over()

    def halt(self) -> None:
        """End the steps that are made again at the next point, called by another thread."""
        for course in (*self._others.values(), self._same):
            course.halt()

    def changed(self, changes: Sequence[Change]) -> None:
        """Some values were set at the present point, and exchanged."""
        self._roughness.forget()
        if self._stretch:
            now = _nanoseconds(self._network.time)
            self._stretch.changes.setdefault(now, []).extend(changes)
        elif self._followed:
            end = self._network.keep()
            with self._network.rehearsing():
                try:
                    self._network.restore(self._followed.point)
                    self._network.change(changes)
                    self._followed = replace(self._followed, point=self._network.keep())
                finally:
                    self._network.restore(end)

    def snapshot(self) -> StepDoublingSnapshot:
        """All that is known at the present point."""
        return StepDoublingSnapshot(
            steps=self._steps,
            begins=self._begins,
            size=self._size,
            told=tuple(self._told),
            bounds=self._bounds,
            kinked=self._kinked,
            kinked_since=self._kinked_since,
            met=self._met,
            followed=self._followed,
            watched=self._watched.copy(),
            rough=self._rough.copy(),
            coverage=self._coverage,
            crowded=self._crowded,
            falls=self._falls,
            failure=self.failure,
            others=self._others,
            roughness=self._roughness.snapshot(),
            stretch=self._stretch.copy() if self._stretch else None,
        )

    def restore(self, snapshot: StepDoublingSnapshot) -> None:
        """Continue as from where the snapshot was taken."""
        self._steps, self._begins, self._size = snapshot.steps, snapshot.begins, snapshot.size
        self._told, self._bounds = list(snapshot.told), snapshot.bounds
        self._kinked, self._kinked_since = snapshot.kinked, snapshot.kinked_since
        self._met, self._followed = snapshot.met, snapshot.followed
        self._watched, self._rough = snapshot.watched.copy(), snapshot.rough.copy()
        self._coverage, self._crowded = snapshot.coverage, snapshot.crowded
        self._falls, self.failure, self._others = snapshot.falls, snapshot.failure, snapshot.others
        self._roughness.restore(snapshot.roughness)
        self._stretch = snapshot.stretch.copy() if snapshot.stretch else None

    @property
    def room(self) -> int:
        """How many steps may be made at once before `after` is told."""
        if self.failure or self._stretch is None:
            return FAR
        return self._stretch.end - self._steps

    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None:
        """After so many steps of `size` [ns]; the operations have filled rows from `row` on.

        The last has `jumped`: what was before it is forgotten. The jump was `within` it, or else at
        its end.
        """
        stretch = self._stretch
        self._steps += steps
        if stretch is None or not steps:
            return
        same, self._size = size == self._size, size
        if len(sudden := self._roughness.sudden(row, steps, same=same, jumped=jumped)):
            stretch.kinks.append(stretch.steps + sudden)
        if jumped or not same:
            self._roughness.forget()
        stretch.go_on(steps, size)
        if within:
            stretch.kinks.append(np.array([stretch.steps - 1]))
            stretch.within.append(stretch.last)
        if jumped:
            stretch.jumps.append(stretch.last)
        if stretch.recorded:
            stretch.values.append(self._values[row : row + steps].copy())
        if self._steps == stretch.end:
            self._close()

    def _close(self) -> None:
        """Make the open stretch again, in steps of other lengths, as far as that is wanted."""
        stretch, self._stretch = self._stretch, None
        if stretch is None or not stretch.steps:
            return
        kinks = np.concatenate([np.zeros(0, dtype=np.intp), *stretch.kinks])
        rough = self._is_rough(self._roughness.largest)
        if rough and len(kinks) and self._crowded:  # they may be of another kind
            self._crowded, self._met = False, 0
            self._kinked_since = np.zeros_like(self._kinked)
        alone = len(kinks) > 0 and not self._crowded
        if not (stretch.window or rough or self._followed or alone):
            return
        end = self._network.keep()
        why = "they were interrupted"
        with self._network.rehearsing():
            try:
                why = self._made_again(stretch, kinks, rough=rough)
            finally:
                self._back_to(end, why)

    def _is_rough(self, largest: np.ndarray) -> bool:
        """True if outputs with such fourth differences are rougher than windows have been."""
        return bool((largest > np.maximum(ROUGHER * self._watched, self._roughness.gate)).any())

    def _smooth(self, stretch: Stretch, run: Recorded, kinks: np.ndarray) -> np.ndarray:
        """The largest fourth difference of each output away from some `kinks` (k,) and from jumps.

        0 of outputs that are not monitored, if there are any.
        """
        if not len(kinks) and not stretch.jumps and len(stretch.runs) == 1:
            return self._roughness.largest
        found = fourth_differences(run.values)
        uneven = np.flatnonzero(np.diff(np.diff(run.times))) + 1
        jumps = np.searchsorted(run.times, stretch.jumps) - 1
        steps = np.concatenate([about(kinks, run.steps), jumps, uneven]).astype(np.intp)
        after = (steps[:, None] + 1 + np.arange(HISTORY + 1)).ravel()
        found[after[after <= run.steps]] = 0.0
        largest = np.zeros_like(self._roughness.largest)
        largest[self._sources] = found.max(axis=0)
        return largest

    def _back_to(self, end: NetworkSnapshot, why: str) -> None:
        """Return to where the run is; RunError that says `why` courses have failed, if it fails."""
        try:
            self._network.restore(end)
        except RunError as error:
            raise RunError(
                f"the coupling error is found by steps of another length: {why}; the run cannot "
                f"return from them ({error.message})",
                "an FMU should discard a step that it cannot make, not return Fatal",
            ) from error

    def _made_again(self, stretch: Stretch, kinks: np.ndarray, *, rough: bool) -> str:
        """Learn from a stretch by making it again; why courses have failed, if some have."""
        run, why = self._recorded(stretch), []
        kinks = self._beyond_rounding(kinks, run)
        smooth = self._smooth(stretch, run, kinks)
        if self._told:
            kinks = self._relevant(kinks, run)
        many = stretch.window and len(kinks) > 0 and self._met + events(kinks) >= MANY
        many = many and not (self._crowded or self._coarse)
        followed = self._followed is not None or (len(kinks) > 0 and not self._crowded)
        window = stretch.window or followed or (rough and self._is_rough(smooth))
        if window:
            if many and not self._kinked_since.any():
                self._crowded = not self._lower(stretch, run, kinks)
            edges = run.times[1 + about(kinks, run.steps)]
            alike = not (self._crowded or self._coarse) and len(edges) < run.steps / 2
            kinked = self._crowded or len(kinks) > 0
            why = self._judged(stretch, run, edges if alike else edges[:0], kinked=kinked)
            self._set_gates(run)
            if stretch.window:
                seen = self._roughness.largest if self._crowded else smooth
                np.maximum(self._watched, seen, out=self._watched)
            kinks = self._relevant(kinks, run)
        if self.failure or not (self._crowded or self._followed or len(kinks)):
            return ", and ".join(why)
        first = int(run.times[kinks[0] if len(kinks) else 0])
        if self._crowded:
            self._met += events(kinks)
        elif self._coarse:
            self._coverage = self._coverage.lose(first, self._coarse)
        else:
            why += self._follow(stretch, run, kinks)
            self._set_gates(run)
            self._crowded = many and not self._outweigh(int(run.times[-1]))
        if self._crowded:
            self._hand_over(first)
        return ", and ".join(why)

    def _outweigh(self, now: int) -> bool:
        """True if errors of kinks, as followed, matter beside those of smooth steps, or grow."""
        if not self._told:
            return True
        spans = self._spans(self.ranges())
        smooth = throughout(self._told, self._start, now)
        if over(self._kinked_since, spans).max() > LITTLE * over(smooth, spans).max():
            return True
        return self._followed is not None and self._followed.told.doubles(spans)

    def _lower(self, stretch: Stretch, run: Recorded, kinks: np.ndarray) -> bool:
        """True if many kinks in a window (k,) lower the order by which its errors fall."""
        if self._order == 1:
            return False  # all errors are as those of kinks
        spans = self._spans(self.ranges())
        roughest = over(_rough(kinks, run.values), spans).max(axis=1).argmax()
        few = int(first_events(kinks, A_FEW)[-1])
        last = min(max(few, int(kinks[roughest])) + MEASURED // 2, run.steps)
        begin = Recorded(run.times[: last + 1], run.values[: last + 1])
        within, end = set(stretch.within), int(begin.times[-1])
        met = [time for time in stretch.jumps if time <= end and time not in within]
        times = doubled(begin.times, met, phase=self._phase(run.times))
        try:
            self._network.restore(stretch.start)
            twice = self._others[TWICE].along(times, stretch.jumps, stretch.changes)
        except (KeyError, RunError):
            return True
        falls = self._measured(stretch, begin, twice, met)
        return falls is None or falls < self._order - LOST

    def _hand_over(self, time: int) -> None:
        """From a time [ns] on windows speak for kinks, and none is followed."""
        if self._followed:
            np.maximum(self._watched, self._rough, out=self._watched)
        self._followed = None
        self._coverage = self._coverage.crowd(time)

    def _recorded(self, stretch: Stretch) -> Recorded:
        """A stretch of the run; made again where its values are not known."""
        times = stretch.times
        if stretch.recorded:
            return Recorded(times, np.concatenate(stretch.values))
        self._network.restore(stretch.start)
        return self._same.along(times, stretch.jumps, stretch.changes)

    @staticmethod
    def _beyond_rounding(kinks: np.ndarray, run: Recorded) -> np.ndarray:
        """Those of some steps (k,) that are rough by more than rounding."""
        if not len(kinks):
            return kinks
        return kinks[np.any(_rough(kinks, run.values) > NOISE * run.largest, axis=1)]

    def _relevant(self, kinks: np.ndarray, run: Recorded) -> np.ndarray:
        """Those of some steps (k,) that are rough by more than a share of the known error."""
        if not len(kinks):
            return kinks
        spans = self._spans(self.ranges())
        least = SMALL * self._known_error(spans) * spans
        return kinks[np.any(_rough(kinks, run.values) > least, axis=1)]

    def _known_error(self, spans: np.ndarray) -> float:
        """The largest error over its span that windows and what was followed have told so far."""
        if not self._told:
            return 0.0
        largest = np.max([one.largest for one in self._told], axis=0) + self._kinked
        return float(over(largest, spans).max())

    def _set_gates(self, run: Recorded) -> None:
        spans = self._spans(self.ranges())
        least = np.maximum(NOISE * run.largest, SMALL * self._known_error(spans) * spans)
        self._roughness.gate[self._sources] = least

    def _judged(
        self, stretch: Stretch, run: Recorded, alike: np.ndarray, *, kinked: bool
    ) -> list[str]:
        """Note what a course of another length tells of a stretch, which may be `kinked`.

        Steps to some times [ns] are `alike` in both. Why courses have failed; `failure` is told
        where all have.
        """
        why: list[str] = []
        if stretch.steps == 1 and HALF not in self._others:
            return why  # a single step tells nothing
        wild: Told | None = None
        for length in tuple(self._others):
            try:
                found = self._judge(stretch, run, length, alike, kinked=kinked)
            except _UntoldError as error:
                why.append(str(error))
                continue
            if found is None:
                return why
            told, better = found
            is_wild = over(told.largest, self._spans(better.ranges)).max() > GROWN
            if is_wild and length == TWICE and HALF in self._others:
                wild = told
                continue
            if wild and not is_wild:
                self._give_up(TWICE)  # it is these steps that grow, and not the run
                wild = None
            self._note(wild or told, run if wild else better)
            return why
        if wild:
            self._note(wild, run)
        else:
            self.failure = ", and ".join(why)
        return why

    def _note(self, told: Told, better: Recorded) -> None:
        self._told = [*self._told, told]
        self._bounds = _wider(self._bounds, better)
        self._coverage = self._coverage.twice(told.begin, told.begin + told.span)

    def _give_up(self, length: float) -> None:
        """Make no more courses with steps of this `length`."""
        self._others = {c: course for c, course in self._others.items() if c != length}

    def _judge(
        self, stretch: Stretch, run: Recorded, length: float, alike: np.ndarray, *, kinked: bool
    ) -> tuple[Told, Recorded] | None:
        """The errors by a course with steps of this `length`, and the better one; or _UntoldError.

        None if there is nothing but jumps.
        """
        twice = length == TWICE
        if twice and stretch.changes:
            raise _UntoldError("values were set between steps")
        unlike = set(stretch.within) if self._crowded else set()
        if self._coarse and HALF not in self._others:  # a step of the run cannot stand alone
            unlike = set(stretch.jumps)
        jumps = [time for time in stretch.jumps if time not in unlike]
        same, phase = sorted({*jumps, *alike.tolist()}), self._phase(run.times)
        times = doubled(run.times, same, phase=phase) if twice else halved(run.times, jumps)
        span, other = int(times[-1] - times[0]), other_steps(times, run.times)
        if other < span / 2 or not span:
            if twice:
                raise _UntoldError("most steps end at jumps")
            return None
        try:
            self._network.restore(stretch.start)
            again = self._others[length].along(times, stretch.jumps, stretch.changes)
        except RunError as error:
            self._give_up(length)
            name = "twice" if twice else "half"
            raise _UntoldError(f"steps of {name} the length fail ({error.message})") from error
        if self._falls is None and twice and HALF in self._others and self._order > 1:
            last = min(MEASURED, run.steps // 4)
            begin = Recorded(run.times[: last + 1], run.values[: last + 1])
            self._falls = self._measured(stretch, begin, again, same)
        if self._falls is None:
            self._falls = float(self._order)
        falls = self._falls
        order = max(1.0, min(falls, self._order) if kinked else falls)
        if kinked and self._coarse:
            order = 1.0  # as the errors of kinks, which nothing else tells
        scale = span / other * (1.0 if twice else 2.0**order) / (2.0**order - 1)
        found, left = scale * pieces(run.off(again)), 2.0**-falls
        told = Told(found, int(run.times[0]), span, stretch.window, left)
        return told, run if twice else again

    def _phase(self, run: np.ndarray) -> int | None:
        """Which of two steps of the run begins these times; None if no component has rarer ones."""
        if len(run) < 2 or not any(rate.is_sampled for rate in self._network.rates.values()):
            return None
        return round((run[0] - self._start) / (run[1] - run[0])) % 2

    def _measured(
        self, stretch: Stretch, begin: Recorded, twice: Recorded, alike: Sequence[int]
    ) -> float | None:
        """The order over the `begin` of a stretch, as measured by a third course, at H/2.

        It may be lower than the algorithm promises, as where FMUs are not linear in inputs that
        they hold, or higher by one; but higher it is not taken in a window with kinks, after which
        the motion is faster than where it was measured.

        None where differences are rounding, or so large that no order shows.
        """
        times = np.intersect1d(begin.times, twice.times, assume_unique=True)
        if len(times) < 2:
            return None
        shorter = halved(begin.times, alike)
        try:
            self._network.restore(stretch.start)
            half = self._same.along(shorter, stretch.jumps, stretch.changes)
        except RunError:
            return None
        spans = self._spans(begin.ranges)
        large, small = (
            over(begin.off(one, times).max(axis=0), spans).max() for one in (twice, half)
        )
        if small > 0.0 and 0.0 < large < RESOLVED:
            return float(np.clip(np.log2(large / small), 0.0, self._order + 1))
        return None

    def _follow(self, stretch: Stretch, run: Recorded, kinks: np.ndarray) -> list[str]:
        """Make the stretch a second time, in finer steps about `kinks` (k,); why that fails, if so.

        The second course begins where it has ended before, or at the start of the stretch.
        """
        followed = self._followed
        within = set(stretch.within)
        met = [time for time in stretch.jumps if time not in within]
        times = refined(run.times, met, about(kinks, run.steps))
        begin, end = int(run.times[0]), int(run.times[-1])
        try:
            self._network.restore(followed.point if followed else stretch.start)
            again = self._same.along(times, stretch.jumps, stretch.changes)
            point = self._network.keep()
        except RunError as error:
            self._followed = None
            why = f"steps of a part of the length fail ({error.message})"
            self._coverage = self._coverage.lose(begin, why)
            return [why]
        errors = run.off(again)
        self._kinked = np.maximum(self._kinked, errors.max(axis=0))
        self._kinked_since = np.maximum(self._kinked_since, errors.max(axis=0))
        self._bounds = _wider(self._bounds, again)
        np.maximum(self._rough, self._roughness.largest, out=self._rough)
        if followed:
            since, first = followed.since, followed.told.begin
            largest = np.concatenate((followed.told.errors, pieces(errors)))
        else:
            since, first = begin, int(run.times[kinks[0]])
            largest = pieces(errors[kinks[0] :])
        self._coverage = self._coverage.follow(since, end, run.times[1 + first_of_each(kinks)])
        spans = self._spans(self.ranges())
        self._followed = Followed(point, since, Told(largest, first, end - first, speaks=True))
        self._met += events(kinks)
        if (errors[-1] <= DIED * self._known_error(spans) * spans).all():
            self._followed = None
        return []

    def finish(self) -> None:
        """At the end of the run: judge the stretch that is open."""
        try:
            self._close()
        except RunError as error:
            self.failure = error.message
        if not self.failure and not self._told:
            few = "the run has only one step" if self._steps else "the run has no steps"
            self.failure = "all steps end at jumps" if self._steps > 1 else few

    def errors(self, *, halved: bool = False) -> np.ndarray:
        """The largest errors that are known, for each source, in its unit; or at half the step.

        To be called without a `failure`.
        """
        start, end = self._start, _nanoseconds(self._network.time)
        told = [one.halved for one in self._told] if halved else self._told
        smooth, kinked = throughout(told, start, end), self._kinked
        if halved:
            kinked = halved_kinks(kinked, self._spans(self.ranges()))
        return smooth + kinked

    def coverage(self) -> Coverage:
        """How much of the run up to the present point was watched."""
        return replace(self._coverage, end=_nanoseconds(self._network.time))

    def ranges(self) -> np.ndarray:
        """How far the values of each source have been apart where they are known."""
        return np.ptp(self._bounds, axis=0)


def _wider(bounds: np.ndarray, course: Recorded) -> np.ndarray:
    """Smallest and largest values (2, n) of those in `bounds`, and of a course."""
    (low, high), (least, most) = bounds, course.bounds
    return np.array([np.minimum(low, least), np.maximum(high, most)])


def _rough(steps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Fourth differences (steps, n) of values (m, n) where some steps end, or the first known."""
    return fourth_differences(values)[np.clip(steps + 1, HISTORY, len(values) - 1)]
