"""The saved state of a run, and checkpoints: that state in a file for another process."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.cosim.error_estimate.report import Spans
from m4e_fmi.cosim.error_estimate.state import StepDoublingSnapshot
from m4e_fmi.cosim.exchange.fmu_log import Kinds, Warn
from m4e_fmi.cosim.exchange.layout import OWN_PLACES, NetworkSnapshot
from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.monitoring.instability import StabilitySnapshot
from m4e_fmi.cosim.monitoring.late_dependence import SecondLookSnapshot
from m4e_fmi.cosim.results.writer import FirstRows, Mark
from m4e_fmi.cosim.run.checkpoint_file import (
    CheckpointParts,
    read_checkpoint,
    results_of,
    write_checkpoint,
)
from m4e_fmi.cosim.run.identity import check_identity
from m4e_fmi.cosim.stepping.algorithm import AlgorithmSnapshot
from m4e_fmi.cosim.stepping.step_control import StepControlSnapshot
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.time_loop.energy import EnergySnapshot
from m4e_fmi.cosim.time_loop.time_loop import Position
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.encoding import LIVE
from m4e_fmi.fmu.importer.calls import SerializedState

EXACT = 1e-6
"""Share of a step, or of an interval, by which a time may miss a checkpoint by rounding."""
HEAD, SAVED = "head", "saved"
"""Names of the parts of a checkpoint."""
MOST_PLACES = 64
"""Places of states that a run has, at most."""


@dataclass(frozen=True, eq=False)
class State:
    """The state of a whole system at a communication point of a run, until that ends.

    It holds the states of the FMUs, the exchanged values, what the algorithm knows of the past,
    the energy balance, the place in time, the row of the results, and what is known of the errors.
    `run` is the one that it belongs to.
    """

    run: object = field(repr=False, metadata=LIVE)
    point: NetworkSnapshot = field(repr=False)
    algorithm: AlgorithmSnapshot = field(repr=False)
    control: StepControlSnapshot | None = field(repr=False)
    energy: EnergySnapshot = field(repr=False)
    position: Position = field(repr=False)
    second_look: SecondLookSnapshot = field(repr=False)
    row: Mark | None = field(repr=False)
    seen: StepDoublingSnapshot | None = field(repr=False)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.point.time

    @property
    def points(self) -> tuple[NetworkSnapshot, ...]:
        """All points of which the FMUs keep states."""
        return (self.point, *(self.seen.points if self.seen else ()))


@dataclass(frozen=True)
class Memory:
    """Memory of a run of its past that does not go back when it returns to a state.

    `warned` are the numbers of steps that FMUs have answered with Warning, with the times [s] of
    the first and the last; `messages` what they have logged, `stability` the looks for growth,
    `ranges` the outputs that have left the range of their FMU, by component and column.
    """

    warned: dict[str, tuple[int, float, float]]
    messages: Kinds
    stability: StabilitySnapshot
    ranges: tuple[dict[int, str], ...]


@dataclass(frozen=True)
class Saved:
    """A state for another process: `fmu_states` are those of its points, by place and component."""

    state: State
    fmu_states: dict[int, dict[str, SerializedState]]
    memory: Memory

    def give(self, network: Network) -> None:
        """Give the FMUs of this process their states; RunError if one refuses.

        ValueError for states that cannot be of a run of this network.
        """
        points = {point.place: point for point in self.state.points}
        for place in sorted(points):
            if not OWN_PLACES <= place < MOST_PLACES:
                raise ValueError(f"a state at place {place}")
            network.discrete.check(points[place].discrete)
            for name, instance in network.instances.items():
                state = self.fmu_states[place][name]
                instance.rollback.deserialize(instance.slot(place), state)
            network.adopt(points[place])


@dataclass(frozen=True)
class Head:
    """The place of a checkpoint in its run, at `time` [s].

    `identity` is what must be the same in a run that is resumed. `rows` are in the results by then,
    the last at `last` [s], with the checksum `digest`. `texts` are those that stand in cells, in
    their order.
    """

    identity: dict[str, str]
    time: float
    rows: int
    last: float
    digest: str
    texts: tuple[bytes, ...]

    def check(self) -> None:
        """ValueError if the times cannot be those of a run."""
        if not (math.isfinite(self.time) and self.last <= self.time):
            raise ValueError(f"results up to t = {self.last} s, and a state at t = {self.time} s")


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that a run is resumed from; its file is read only. InputError if damaged."""

    path: Path
    head: Head
    _parts: CheckpointParts

    @classmethod
    def read(cls, path: Path) -> Checkpoint:
        """The checkpoint at `path`; InputError if there is none."""
        results_of(path)
        parts = read_checkpoint(path)
        return cls(path, parts.part(HEAD, Head), parts)

    @property
    def rows(self) -> FirstRows:
        """The rows with which the results begin."""
        head = self.head
        return FirstRows(results_of(self.path), head.rows, head.last, head.digest)

    def check(self, identity: Mapping[str, str], stop_time: float) -> None:
        """InputError if the run has another `identity`, or ends before the checkpoint [s]."""
        check_identity(str(self.path), self.head.identity, identity)
        if stop_time < self.head.time:
            message = f"the checkpoint is at t = {self.head.time:.9g} s, after the stop time"
            remedy = f"take a stop_time of {self.head.time:.9g} s or more"
            raise InputError.single(message, remedy, str(self.path))

    def take_texts(self, network: Network) -> None:
        """Give texts the places that they had; RunError if the run's own start has others."""
        for place, text in enumerate(self.head.texts):
            if network.discrete.texts.place(text) != place:
                raise RunError(
                    "the texts at the start are not those of the run that the checkpoint is of: an "
                    "FMU is not deterministic",
                    "run again from the start, without --resume",
                )

    def saved(self, run: object, network: Network) -> Saved:
        """The state, as one of the `run` of this `network`; ValueError if it is of another time."""
        saved = self._parts.part(SAVED, Saved, {"run": run, "spans_of": Spans(network)})
        if saved.state.time != self.head.time:
            raise ValueError(f"a state of t = {saved.state.time:.9g} s")
        return saved


class Checkpoints:
    """Checkpoints of a run by `simulation` at `path`, each in place of the one before.

    `taken` is the time [s] of the last one, None if there is none. `warn` is told once that one
    could not be written.
    """

    def __init__(self, path: Path, simulation: Simulation, warn: Warn | None) -> None:
        self.path, self._warn = path, warn
        self._every = simulation.checkpoint_interval or math.inf
        self._wall = simulation.checkpoint_wall_interval or math.inf
        self._size, self._start = simulation.step_size, simulation.start_time
        self._next = self._start + self._every
        self._due = clock.monotonic() + self._wall
        self.taken: float | None = None

    def resume(self, checkpoint: Checkpoint) -> None:
        """Continue after a checkpoint, which may be another run's."""
        self._wait(checkpoint.head.time)
        self.taken = checkpoint.head.time if checkpoint.path == self.path else None

    def _wait(self, time: float) -> None:
        """The next checkpoint is one after this time [s]."""
        passed = math.floor((time - self._start) / self._every + EXACT)
        self._next = self._start + (passed + 1) * self._every

    def room(self, time: float) -> float:
        """Steps from `time` [s] up to the next checkpoint; infinite without simulated interval."""
        rest = (self._next - time) / self._size
        return max(1, math.ceil(rest - EXACT)) if rest < math.inf else math.inf

    def due(self, time: float) -> bool:
        """True if a checkpoint is to be taken at `time` [s]; the one after it is awaited then."""
        passed = time >= self._next - EXACT * self._size
        if passed:
            self._wait(time)
        return passed or clock.monotonic() >= self._due

    def write(self, time: float, parts: Callable[[], tuple[Head, Saved]]) -> None:
        """Write a checkpoint at `time` [s]; where that fails, the one before stays."""
        try:
            head, saved = parts()
            write_checkpoint(self.path, {HEAD: head, SAVED: saved})
            self.taken = time
        except RunError as error:
            if self._warn:
                last = "there is none" if self.taken is None else f"the last is of {self.taken:g} s"
                self._warn(f"warning: no checkpoint at t = {time:.9g} s: {error.message}; {last}")
                self._warn = None
        self._due = clock.monotonic() + self._wall
