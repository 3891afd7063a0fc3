"""Checkpoints of a run that goes on: when they are taken, and what they say."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cosim.checkpoint.container import checkpoint_of, write_checkpoint
from m4e_fmi.cosim.checkpoint.fmu_states import serialized, without_states
from m4e_fmi.cosim.checkpoint.state import Exchanged, Head, Saved
from m4e_fmi.cosim.connections.prepared import Prepared
from m4e_fmi.cosim.exchange.fmu_log import Warn
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.results.writer import ResultsWriter
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.errors import RunError
from m4e_fmi.signals import Terminated

if TYPE_CHECKING:
    from m4e_fmi.cosim.master.master import Master

EXACT = 1e-6
"""Share of a step, or of an interval, by which a time may miss a checkpoint by rounding."""
HEAD, SAVED = "head", "saved"
"""Names of the parts of a checkpoint."""


class Checkpoints:
    """Takes checkpoints of a run at `path`, each in place of the one before.

    `identity` is that of the run. Where FMUs cannot save their states, `without` says so, and a
    checkpoint is the place only up to which the run is made again.
    """

    def __init__(
        self,
        path: Path,
        simulation: Simulation,
        identity: Mapping[str, str],
        *,
        without: str = "",
        warn: Warn | None = None,
    ) -> None:
        self.path = path
        self._identity, self._without, self._warn = dict(identity), without, warn
        self._every = simulation.checkpoint_interval or math.inf
        self._wall = simulation.checkpoint_wall_interval or math.inf
        self._size = simulation.step_size
        self._begin = simulation.start_time
        self._next = self._begin + self._every
        self._due = clock.monotonic() + self._wall
        self.taken: float | None = None
        """Time [s] of the last checkpoint; None if there is none."""

    def go_on(self, path: Path, time: float) -> None:
        """The run has begun at the checkpoint at `path`, at this time [s]."""
        self._next = self._after(time)
        self.taken = time if path == self.path else None

    def _after(self, time: float) -> float:
        """The time [s] of the next checkpoint after this one."""
        passed = math.floor((time - self._begin) / self._every + EXACT)
        return self._begin + (passed + 1) * self._every

    def rest(self, master: Master) -> float:
        """Steps up to the next checkpoint; infinite where none is due at a simulated time."""
        rest = (self._next - master.network.time) / self._size
        return max(1, math.ceil(rest - EXACT)) if rest < math.inf else math.inf

    def look(self, master: Master, results: ResultsWriter) -> None:
        """Take a checkpoint at the present communication point if it is time."""
        soon = self._next - EXACT * self._size
        if master.network.time < soon and clock.monotonic() < self._due:
            return
        self.take(master, results)
        if master.network.time >= soon:
            self._next = self._after(master.network.time)
        self._due = clock.monotonic() + self._wall

    def take(self, master: Master, results: ResultsWriter) -> None:
        """Take a checkpoint at the present communication point, if the results have a step.

        Where that fails, the one before stays, and `warn` is told once.
        """
        time = master.network.time
        if results.mark().rows < 2 or results.replaying or self.taken == time:
            return
        try:
            self._take(master, results)
        except RunError as error:
            if self._warn:
                last = "there is none" if self.taken is None else f"the last is of {self.taken:g} s"
                self._warn(f"warning: no checkpoint at t = {time:.9g} s: {error.message}; {last}")
                self._warn = None
            return
        self.taken = time

    def _take(self, master: Master, results: ResultsWriter) -> None:
        results.flush()
        mark, network = results.mark(), master.network
        head = Head(
            identity=self._identity,
            time=network.time,
            steps=master.steps,
            rows=mark.rows,
            last=mark.last,
            digest=results.last_row(),
            watched=master.watched,
            texts=network.discrete.texts.content(),
            exchanged=exchanged(network),
            without=self._without,
        )
        parts: dict[str, object] = {HEAD: head}
        if not self._without:
            state = master.save()
            parts[SAVED] = Saved(state, serialized(network, state), master.memory())
        write_checkpoint(self.path, parts)


@contextmanager
def resumable(checkpoints: Checkpoints | None) -> Generator[None]:
    """Errors and signals get a note of the time from which the run can go on, if there is one."""
    try:
        yield
    except BaseException as error:
        if checkpoints is None or checkpoints.taken is None:
            raise
        note = f"--resume (in Python resume=True) goes on at t = {checkpoints.taken:.9g} s"
        if isinstance(error, RunError):
            raise RunError(error.message, f"{error.remedy}; {note}".strip("; ")) from error
        error.add_note(note)
        raise


@contextmanager
def saving(
    checkpoints: Checkpoints | None, master: Master, results: ResultsWriter | None
) -> Generator[Callable[[], None]]:
    """Gives what is to be called between steps, for `checkpoints` when they are due.

    One is taken at the end of the block, and where a signal ends it between steps.
    """
    if checkpoints is None or results is None:
        yield lambda: None
        return
    try:
        yield lambda: checkpoints.look(master, results)
    except (KeyboardInterrupt, Terminated):
        if not master.is_stepping:
            checkpoints.take(master, results)
        raise
    checkpoints.take(master, results)


def checkpoints(
    prepared: Prepared,
    results: Path,
    identity: Mapping[str, str],
    *,
    tell: Callable[[str], None] | None,
    warn: Warn | None,
) -> Checkpoints:
    """The checkpoints of a run, beside its `results`; tells if they have no states."""
    without = without_states(prepared.descriptions)
    if without and tell:
        tell(f"checkpoints have no states: {without}; to go on, a run is made again up to there")
    settings = prepared.system.simulation
    path = checkpoint_of(results)
    return Checkpoints(path, settings, identity, without=without, warn=warn)


def exchanged(network: Network) -> Exchanged:
    """The exchanged values at the present point."""
    values = network.values[network.now : network.now + len(network.outputs)]
    return Exchanged(values.copy(), network.discrete.values.copy())
