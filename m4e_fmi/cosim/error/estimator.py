"""The steps of a run that are made again for its coupling error, their length, and the error.

**Smooth motions.** Two runs by an algorithm of order p from one point, y at the step H and z at 2H,
differ by most of the error of the second:

    error of y = |y − z| / (2^p − 1)

Nothing is assumed of the FMUs, and errors propagate in both runs as they do. Where z goes at H/2
instead, the error of y is |y − z| 2^p / (2^p − 1).

**Windows.** At the end of a window of steps the FMUs go back to its start, repeat it in steps of
twice the length, and return; the run itself does not change. The first 2048 steps are a window.
Then follow octaves (2048 to 4096, 4096 to 8192 ...) of which the first sixteenth is one. Beyond its
window an error may go on growing: see `throughout`.

**Everywhere else** fourth differences of the outputs are watched in every step (`roughness`), in
*stretches* of steps. One that is twice as rough as all that was repeated is repeated, too, as is
one with kinks twice as rough as all kinks there; its errors count for that stretch alone.

**A trajectory goes on** beside the run as long as its errors are among the largest and grow: in a
window FASTER than with the time, elsewhere, and where kinks matter, if they double in the second
half of its way.

**The order** of `corrector` is measured in the first window, by steps of four times the length:
see `_measure`. Otherwise it is the algorithm's.

**Kinks** that no FMU announces lower the order where they are: bends (a contact) to the second,
and jumps (a switch) to the first. Orders are taken rather too low, and those of kinks for all
errors where kinks matter: see `SMOOTH`. A trajectory goes on, too, if few kinks were met that are
rough beside the known error, so that others like them may make larger ones. Where a value jumps
within a step, a longer one begins with it: it acts a step later there.

**A second set** of the FMUs makes the second trajectory where they cannot go back, or step less
often than the system without being sampled (then these steps, too, are twice as long). It covers
the run from its start.

**Half the step** instead of twice the step is taken in windows where longer steps fail, would
mostly be the run's own (between jumps, and values that were set), or grow without bound where the
run does not: there errors over the range so far are UNUSABLE, and those of half the step UNLIKE
them. In a second set it is taken where values may be set in every step. It costs four times as
much.

**No more than `MOST`** of the number of the run's steps is made again. What that leaves out, the
coverage says; errors are taken to grow with the ranges there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from m4e_fmi.cosim.error.course import DOUBLE, FASTER, Course, grows, throughout
from m4e_fmi.cosim.error.report import ONE_LENGTH, Coverage, Spans, monitored_places, over
from m4e_fmi.cosim.error.roughness import Roughness
from m4e_fmi.cosim.error.state import EstimateState, Stretch
from m4e_fmi.cosim.error.trajectory import (
    Trajectory,
    between_jumps,
    differences,
    doubled_steps,
    halved_steps,
    length_of_others,
)
from m4e_fmi.cosim.network.failures import LostError
from m4e_fmi.cosim.network.network import HALF, TWICE, Change, Network, NetworkSnapshot
from m4e_fmi.cosim.network.operations import Operation, gather
from m4e_fmi.cosim.network.restorable import Restorable, Snapshot
from m4e_fmi.cosim.stepping.algorithm import BLOCK, Algorithm
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND, Simulation
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.signals import Terminated

FIRST, SHARE = 2048, 16
"""Steps of the first window, and of a stretch at most; octaves over windows after it."""
PIECES = 8
"""Pieces of a stretch, which show where errors become large."""
MOST, FEW = 0.6, 20
"""Steps that are made again at most, over those of the run; and of the shortest runs."""
ROUGHER = 2.0
"""Times as rough as all that was repeated, from which on a stretch is repeated too."""
NOISE = 8e-14
"""Share of the largest value up to which a fourth difference may be rounding."""
ROUNDING, LEAST = 1e-14, 1e-15
"""Shares of an output's largest value, and of its nominal value, up to which a difference may be
rounding."""
SMALL = 0.1
"""Share of the known error up to which fourth differences are ignored."""
SMOOTH, BEND, JUMP = 2.25, 1.5, 1.0
"""Orders of errors at most, rather too low: smooth ones fall with the second order where FMUs are
not linear in inputs that they hold, if nothing is measured; those of bends with the first or
second, and so in what is repeated beyond the windows; those of jumps with the first. None that is
measured is below that of bends."""
MATTERS, LARGE = 3.0, 100.0
"""Fourth difference at bends over the known error: above the first they may lower the order a bit,
and others like them may make more; above the second they may make most of the error."""
RARE = 8
"""Least number of steps for each jump, if jumps are few."""
MANY = 64
"""Steps with kinks after which a course stands for others like them."""
FOURFOLD = 4.0
"""Length of the steps that show how errors fall, over the run's."""
RESOLVED = 0.3
"""Error over range up to which the order of kinks shows."""
GROWN = 2.0
"""Error over range above which it is not that of values within the range any more."""
UNUSABLE, UNLIKE = 0.1, 3.0
"""Error over range from which on that of longer steps is doubted, and its ratio to that of half the
step if it is these steps that grow, and not the run."""
FAR = 2**62
"""More steps than a run has."""
WILD = "steps of twice the length come too far from the run"
SPENT = f"no more than {MOST} of the steps are made again"


class ErrorEstimator(Restorable):
    """Estimates the error of a run of `network` by an algorithm of this `order`.

    `make` makes the algorithm anew. The second trajectory is that of the network itself, or of
    `other`, a second set of FMUs at the start; `lengths` are those of its steps over the run's,
    TWICE and HALF, to be tried in this order. With `whole` steps, no step of the run can stand
    alone among steps of twice the length. `longer` is that of `CouplingErrorReport`.

    The `operations` are to be performed after each step of the run; `state` is all that it knows.
    """

    restored = ("state", "_roughness")

    def __init__(
        self,
        network: Network,
        other: Network | None,
        make: Callable[[Network], Algorithm],
        lengths: Sequence[float],
        *,
        order: int,
        simulation: Simulation,
        whole: bool,
        longer: Mapping[str, str],
    ) -> None:
        self._network, self._promised = network, order
        self._stop = round(simulation.stop_time * NS_PER_SECOND)
        self._size = round(simulation.step_size * NS_PER_SECOND)
        self._whole, self.longer = whole, longer
        self._sources, self._spans = monitored_places(network), Spans(network)
        ports = [port for _, port in network.monitored_outputs]
        # which jump at points of their own, which all steps meet
        self._least = LEAST * np.array([network.nominal(port) for port in ports])
        self._sampled = np.array([port.component in network.sampled for port in ports])
        self._beside = other is not None
        second = network if other is None else other
        self._trajectories = {
            length: Trajectory(second, make, self._sources, length=length) for length in lengths
        }
        self._fourfold = Trajectory(second, make, self._sources, length=FOURFOLD)
        self._seen: list[tuple[np.ndarray, np.ndarray, float]] = []
        self._points = [due for due in map(second.due, second.instances) if due]
        self._roughness = Roughness(network)
        self._values = np.zeros((BLOCK, len(self._sources)))
        self.operations: tuple[Operation, ...] = (
            gather(self._values, network.values, self._sources),
            self._roughness.operation,
        )
        self._start, nothing = self._now, np.zeros(len(self._sources))
        self.state = EstimateState(
            lengths=tuple(lengths),
            bounds=np.repeat(network.values[self._sources][None], 2, axis=0),
            leaps=nothing,
            watched=np.zeros(len(network.outputs)),
            kinks=nothing,
            jumps=nothing,
        )
        if other is not None:
            other.pause = lambda: network.pause()
            self.state.course = Course.at(self._start, lengths[0], len(self._sources), speaks=True)
            self.state.until = self.state.begins = FAR

    @property
    def failure(self) -> str:
        """Why the errors are not known, if so."""
        state = self.state
        if state.failure or state.courses:
            return state.failure
        if state.steps < 2:
            return "the run has only one step" if state.steps else "the run has no steps"
        return state.lost[1] if state.lost else "all steps end at jumps"

    @property
    def _now(self) -> int:
        """The time [ns] of the network."""
        return round(self._network.time * NS_PER_SECOND)

    @property
    def _most(self) -> float:
        """Steps that may be made again in all."""
        planned = (self._stop - self._start) / self._size
        return max(FEW, MOST * max(planned, self.state.steps))

    @property
    def _is_done(self) -> bool:
        """True if no step is to be made again any more."""
        state = self.state
        return bool(state.failure) or not (state.course or (state.lengths and not self._beside))

    def before(self) -> None:
        """Before a step of the run: ends a stretch, and keeps the point where the next begins."""
        self._close_whole()
        state = self.state
        if state.stretch is not None or self._is_done:
            return
        if state.steps == state.begins:
            state.until = state.steps + (state.steps // SHARE or FIRST)
            state.begins = max(2 * state.begins, FIRST)
        edge = state.until if state.steps < state.until else state.begins
        start = None if self._beside else self._network.keep()
        values = [self._network.values[self._sources][None]]
        state.stretch = Stretch(start, min(edge, state.steps + FIRST), values, self._now)
        self._roughness.largest[:] = 0.0

    def halt(self) -> None:
        """End repeated steps at the next point, called by another thread."""
        for trajectory in self._trajectories.values():
            trajectory.halt()

    def changed(self, changes: Sequence[Change]) -> None:
        """Account for values that were set at the present point, and exchanged."""
        self.before()
        self._roughness.forget()
        if self.state.stretch:
            self.state.stretch.changes.setdefault(self._now, []).extend(changes)

    def restore(self, snapshot: Snapshot) -> None:
        """Continue as from where the snapshot was taken, without estimates made since then."""
        super().restore(snapshot)
        if self._beside:
            why = "the run went on from a saved state, a second set of FMUs did not"
            self.state.failure = self.state.failure or why

    @property
    def room(self) -> int:
        """Number of steps that may be made at once before `after` is called."""
        stretch = self.state.stretch
        return FAR if stretch is None else stretch.end - self.state.steps

    def after(
        self, steps: int, size: int, row: int, *, jumped: bool = False, within: bool = False
    ) -> None:
        """After so many steps of `size` [ns]; the operations have filled rows from `row` on.

        The last has `jumped`: what was before it is forgotten. The jump was `within` it, or else at
        its end.
        """
        state = self.state
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
            stretch.switched = True
            stretch.leaping = np.append(stretch.leaping, stretch.steps - 1)
        elif jumped:
            stretch.jumps.append(stretch.last)
        stretch.values.append(self._values[row : row + steps].copy())

    def _close_whole(self) -> None:
        """Close a stretch that has all its steps; one that a signal interrupts stays open."""
        stretch = self.state.stretch
        if stretch is None or self.state.steps < stretch.end:
            return
        before = self.snapshot()
        try:
            self._close()
        except (KeyboardInterrupt, Terminated):
            super().restore(before)
            raise

    def _close(self) -> None:
        """Repeat the steps of the open stretch, if its errors are wanted."""
        state = self.state
        stretch, state.stretch = state.stretch, None
        if stretch is None or not stretch.steps or self._is_done:
            return
        limit = np.maximum(ROUGHER * state.watched, self._roughness.gate)
        is_rough = bool((self._roughness.largest > limit).any())
        if stretch.kinks and not is_rough:
            kinks, _ = stretch.kinks_of(np.concatenate(stretch.values), 0.0)
            is_rough = bool((kinks > ROUGHER * state.kinks).any())
        state.met *= not is_rough  # they may be of another kind
        if not (state.course or state.steps <= state.until or is_rough):
            return
        if stretch.start is None:
            self._repeat(stretch)
            return
        end, why = self._network.keep(), "they were interrupted"
        with self._network.rehearsing():
            try:
                why = self._repeat(stretch)
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

    def _repeat(self, stretch: Stretch) -> str:
        """Repeat a stretch for its errors; why repeated steps have failed, if some have.

        A course that has come further than others tells more.
        """
        state, run, values = self.state, stretch.times, np.concatenate(stretch.values)
        state.watched = np.maximum(state.watched, self._roughness.largest)
        noise = np.maximum(NOISE * np.abs(values).max(axis=0), self._least)
        kinks, jumps = stretch.kinks_of(values, noise)
        state.kinks = np.maximum(state.kinks, kinks)
        state.jumps = np.maximum(state.jumps, np.where(self._sampled, 0.0, jumps))
        state.switched |= stretch.switched
        state.met += sum(map(len, stretch.kinks))
        found, why = self._best(stretch, run, values)
        if found.end > run[0]:
            state.widen(values[run <= found.end])
        if why:
            state.lost = state.lost or (found.end, why)
        state.course = found
        if why:
            state.end()
            self._leave(values)
        elif self._is_complete(found):
            state.end()
        elif not self._beside:
            state.point = self._network.keep()
        if not why and found.length == TWICE and state.falls is None:
            self._measure(found, stretch, run, values)
        self._roughness.gate[self._sources] = np.maximum(noise, SMALL * self._known())
        return why

    def _leave(self, values: np.ndarray) -> None:
        """Take errors to have grown with the ranges along `values` (n, n_sources) not repeated."""
        state, before = self.state, self.spans()
        state.widen(values)
        factor = np.where(before > 0.0, over(self.spans(), before), 1.0)
        state.ended = tuple(replace(e, differences=e.differences * factor) for e in state.ended)

    def _best(self, stretch: Stretch, run: np.ndarray, values: np.ndarray) -> tuple[Course, str]:
        """A course along a stretch, as `_follow`: in steps of half the length if longer ones fail.

        Where errors are large, it may be longer steps alone that grow without bound: they go on if
        half the step says the same, or would not come to where they are. Steps of half the length
        begin with the stretch: a course that is older is doubted only beyond the range.
        """
        state = self.state
        course, point = state.course or self._new(stretch, state.lengths[0]), state.point
        point = point if state.course else stretch.start
        may = course.length == TWICE and HALF in state.lengths and not self._beside
        limit = (GROWN if state.course else UNUSABLE) if may else np.inf
        found, why = self._follow(course, point, stretch, run, values, limit)
        if not why or not may:
            return found, why
        is_wild, other, problem = why == WILD, self._new(stretch, HALF), WILD
        point = self._network.keep() if is_wild else None
        reached = np.searchsorted(run, found.end) if is_wild else 0
        if 2 * reached <= int(self._most) - state.repeated:
            limit = self._seen[-1][2] / UNLIKE if is_wild else np.inf
            other, problem = self._follow(other, stretch.start, stretch, run, values, limit)
        if not problem or (problem != WILD and other.end >= found.end):
            state.ended += (course,) if course.span else ()
            self._give_up(TWICE)
            found = other
        elif is_wild:
            return self._follow(found, point, stretch, run, values, np.inf)
        told = " and ".join(dict.fromkeys((why, problem)))
        return found, told if problem else ""

    def _new(self, stretch: Stretch, length: float) -> Course:
        """A course that is to begin at the start of a stretch."""
        speaks, begin = self.state.steps <= self.state.until, int(stretch.times[0])
        return Course.at(begin, length, len(self._sources), speaks=speaks)

    def _follow(
        self,
        course: Course,
        point: NetworkSnapshot | None,
        stretch: Stretch,
        run: np.ndarray,
        values: np.ndarray,
        limit: float,
    ) -> tuple[Course, str]:
        """A course continued along a stretch of the run; the reason if it ends before.

        Its trajectory is at a `point`, or where the second set is. `values` (n, n_sources) of the
        run are at the times `run` (n,) [ns]. It ends where its errors over ranges so far pass the
        `limit`.
        """
        state, trajectory = self.state, self._trajectories[course.length]
        name, jumps = "twice" if course.length == TWICE else "half", frozenset(stretch.jumps)
        if self._whole and any(time > run[0] for time in stretch.changes):
            return course, "values were set between steps"
        times = halved_steps(run, jumps) if course.length == HALF else self._coarser(run, stretch)
        times = times[times >= course.end]
        if (
            not course.span
            and not self._beside
            and 2 * length_of_others(times, run) < max(1, run[-1] - run[0])
        ):
            return course, "most steps end at jumps"
        most = min(len(times) - 1, int(self._most) - state.repeated)
        count, self._seen = -(-most // PIECES), []
        noise = np.maximum(self._least, ROUNDING * np.abs(values).max(axis=0))
        smooth, bounds, begin = between_jumps(run), state.bounds, 0
        try:
            if point:
                self._network.restore(point)
            for first in range(0, most, max(1, count)):
                part = times[first : min(first + count, most) + 1]
                again = trajectory.along(part, jumps, stretch.changes)
                part = part[: len(again)]
                state.repeated += len(part) - 1
                end = int(np.searchsorted(run, part[-1], side="right"))
                here = slice(int(np.searchsorted(run, part[0])), end)
                found = differences(run[here], values[here], part, again, smooth[here])
                found = np.where(found <= noise, 0.0, found)
                course = course.further(found, int(part[-1]), length_of_others(part, run[here]))
                known = np.concatenate((bounds, values[begin:end]))
                bounds, begin = np.array([known.min(axis=0), known.max(axis=0)]), end
                so_far = self._spans(np.ptp(bounds, axis=0))
                share = float(over(course.errors(self._order), so_far).max(initial=0.0))
                self._seen.append((part, again, share))
                if share > limit:
                    return course, WILD
        except RunError as error:
            self._give_up(course.length)
            return course, f"steps of {name} the length fail ({error.message})"
        return course, SPENT if most < len(times) - 1 else ""

    def _coarser(self, times: np.ndarray, stretch: Stretch) -> np.ndarray:
        """Times (m,) [ns] of steps of twice the length of those along `times` (n,) [ns].

        One begins with each step of the run within which a value jumps, if these are few: otherwise
        both may meet a jump at the same point, later than the solution does.
        """
        if self._whole:
            return times[::2]
        due = [times[(times - one.origin) % one.period == 0] for one in self._points]
        leaping = np.unique(stretch.leaping)
        leaping = leaping[np.diff(leaping, prepend=-2) > 1]  # the first of several
        due += [stretch.times[leaping]] if RARE * len(leaping) < len(times) else []
        met = np.concatenate([np.array([*stretch.changes], dtype=np.int64), *due])
        return doubled_steps(times, stretch.jumps, met)

    def _give_up(self, length: float) -> None:
        """Make no more steps of this `length`."""
        self.state.lengths = tuple(one for one in self.state.lengths if one != length)

    def _is_complete(self, course: Course) -> bool:
        """True if a course need not go on: its window is over, and nothing may change the rest."""
        if self._trajectories[course.length].is_over:
            return True
        state, known, spans = self.state, self._known(), self.spans()
        if state.steps < state.until:
            return False
        shares = over(course.errors(self._order), spans)
        leads = 2 * shares.max(initial=0.0) > over(known, spans).max(initial=0.0)
        is_kinked = (state.kinks > SMALL * known).any()
        are_few = state.met < MANY and (state.kinks > MATTERS * known).any()
        factor = FASTER if course.speaks and not is_kinked else DOUBLE
        return not (are_few or (leads and grows(shares, factor)))

    def _measure(
        self, course: Course, stretch: Stretch, run: np.ndarray, values: np.ndarray
    ) -> None:
        """Measure how smooth errors fall, by the first quarter in steps of four times the length.

        FMUs that are not linear in inputs that they hold add a second order to the fourth that an
        algorithm of third order mostly has: errors a H² + b H⁴, which steps of 2H and 4H tell
        apart. They give the order that one power of the step would have.
        """
        state, parts = self.state, self._seen[: max(2, len(self._seen) // 4)]
        if self._promised < 3 or stretch.start is None or stretch.jumps or len(parts) < 2:
            return
        if parts[0][0][0] != course.begin or not course.differences.any():
            return
        times = np.concatenate([parts[0][0], *(one[1:] for one, _, _ in parts[1:])])
        twice = np.concatenate([parts[0][1], *(one[1:] for _, one, _ in parts[1:])])
        coarse = self._coarser(times, stretch)
        state.repeated += len(coarse) - 1
        try:
            self._network.restore(stretch.start)
            again = self._fourfold.along(coarse, frozenset(), stretch.changes)
        except RunError:
            return
        coarse = coarse[: len(again)]
        off = np.abs(twice - values[np.searchsorted(run, times)]).max(axis=0)
        spans = np.where(off > self._least, self.spans(), 0.0)
        two, four = (
            over(one - values[np.searchsorted(run, coarse)], spans)
            for one in (twice[np.searchsorted(times, coarse)], again)
        )
        largest = over(off, spans).max()
        if largest > 0.0 and np.abs(four).max() < RESOLVED:
            share = np.clip(
                np.abs(4 / 9 * two - four / 45).max() / largest, 1 / 15, 1 / (2.0**BEND - 1.0)
            )
            state.falls = float(np.log2(1.0 + 1.0 / share))

    def finish(self) -> None:
        """Repeat the steps up to the present point, if they are wanted."""
        state = self.state
        if self._whole and state.stretch and state.stretch.steps % 2 and self._now < self._stop:
            return
        try:
            self._close()
        except RunError as error:
            state.failure = error.message

    def spans(self) -> np.ndarray:
        """Ranges (n,) of all outputs of each one's unit, in the outputs' units."""
        return self._spans(self.ranges())

    @property
    def _order(self) -> float:
        """The order of smooth errors."""
        return self.state.falls or min(self._promised, SMOOTH)

    def _known(self) -> np.ndarray:
        """The largest known error over its range if motions are smooth, as errors (n,)."""
        spans, order = self.spans(), self._order
        shares = [over(one.errors(order), spans).max(initial=0.0) for one in self.state.courses]
        return max(shares, default=0.0) * spans

    @property
    def _jumps(self) -> bool:
        """True if jumps within steps are larger than the known error."""
        return self.state.switched or bool((self.state.jumps > self._known()).any())

    @property
    def _falls(self) -> float:
        """The order of all errors: that of jumps or bends within steps, where these matter."""
        state, known = self.state, self._known()
        if self._jumps:
            return JUMP
        if (state.kinks > LARGE * known).any():
            return min(self._order, BEND)
        is_bent = bool((state.kinks > MATTERS * known).any())
        return min(self._order, max(1.0, self._promised - 0.5)) if is_bent else self._order

    def errors(self, *, halved: bool = False) -> np.ndarray:
        """Largest errors (n,) of the sources, in their units, or those at half the step.

        A jump that comes at another point is an error of its size, about the range, however short
        the steps. Beyond that it is growth, and the step is too long.
        """
        courses, order = self.state.courses, self._falls
        errors = [one.errors(order if one.speaks else min(order, BEND)) for one in courses]
        if halved and self._jumps:
            spans = self.spans()
            stay = [(e > RESOLVED * spans) & (e <= GROWN * spans) for e in errors]
            errors = [e * np.where(s, 1.0, 0.5) for e, s in zip(errors, stay, strict=True)]
        elif halved:
            errors = [e / 2.0**order for e in errors]
        return throughout(courses, errors, self._start, self._now)

    def coverage(self) -> Coverage:
        """The part of the run up to the present point that was repeated."""
        spans = tuple((one.begin, one.begin + one.span) for one in self.state.courses)
        return Coverage(self._start, self._now, spans, self.state.lost)

    def leaps(self) -> np.ndarray:
        """Largest known changes (n,) of the outputs within one step, in their units."""
        return self.state.leaps

    def ranges(self) -> np.ndarray:
        """Ranges (n,) of the sources where their values are known, in their units."""
        return np.ptp(self.state.bounds, axis=0)


def without_rollback(descriptions: Mapping[str, Description]) -> list[str]:
    """Names of the components that cannot go back."""
    return [name for name, d in descriptions.items() if not d.saves_state]


def error_estimator(
    network: Network,
    make: Callable[[Network], Algorithm],
    prepared: Prepared,
    second: Callable[[Prepared], Network],
    *,
    order: int,
    changeable: bool,
) -> ErrorEstimator | str:
    """The estimator for a run of `network` by an algorithm of this `order`, or the reason for none.

    `make` makes another algorithm; `second` makes a second network, at the start time. In a
    `changeable` run, values may be set between the steps. With actions of a scenario whose values
    are held within steps, the order is 1, as with longer steps of a component that is not sampled:
    their error is of their length, and not of the system's.
    """
    rates, settings, longer = prepared.rates, prepared.system.simulation, prepared.halved
    whole = [f"{name} {rate}" for name, rate in rates.items() if not rate.shortens]
    odd = [f"{name} {r}" for name, r in rates.items() if r.is_longer and r.every % 2]
    if odd and whole:
        return (
            f"steps of twice the length miss points of a component ({odd[0]}), and there are no "
            f"steps of half the length: {whole[0]}"
        )
    lengths = [TWICE] if whole else [TWICE, HALF]
    if any(rate.held and name not in longer for name, rate in rates.items()):
        lengths = [HALF]  # they have points at all steps
    other, why = None, ONE_LENGTH
    fixed = without_rollback(prepared.descriptions)
    single = settings.stop_time - settings.start_time <= settings.step_size
    if fixed or longer:
        beside = lengths[-1:] if changeable or single else lengths[:1]
        own = {n: replace(r, step=2 * beside[0] * r.step) for n, r in longer.items()}
        try:
            other = second(replace(prepared, rates={**rates, **own}))
            lengths = beside
        except RunError as error:
            why = f"a second set of FMUs fails ({error.message})"
            if fixed:
                return f"{' and '.join(fixed)} cannot roll back (canGetAndSetFMUstate), {why}"
            longer = {}
    return ErrorEstimator(
        network,
        other,
        make,
        lengths,
        order=1 if longer or network.scenario.held else order,
        simulation=settings,
        whole=bool(whole),
        longer={name: "" if name in longer else why for name in prepared.longer},
    )
