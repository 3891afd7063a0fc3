"""The saved state of a run, and checkpoints: that state in a file for another process.

::

    m4e_fmi checkpoint 8\\n
    SHA-256 of all that follows, 64 hexadecimal digits\\n
    the bytes of a `Saved` (see `encoding`)

A file appears whole or not at all, and one that is cut off or altered is refused. The checksum
tells damage, but no forgery. The states in it go to the
FMUs, so that a checkpoint is to be trusted as they are; but it names no code that would be run.
"""

from __future__ import annotations

import hashlib
import math
import os
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from pickle import UnpicklingError

from m4e_fmi.cosim.network.fmu_log import Kinds, Warn
from m4e_fmi.cosim.network.network import Network, NetworkSnapshot
from m4e_fmi.cosim.network.restorable import Snapshot
from m4e_fmi.cosim.results.writer import FirstRows, Mark
from m4e_fmi.cosim.run.identity import check_identity
from m4e_fmi.cosim.system.simulation import Simulation
from m4e_fmi.cosim.time_loop.time_loop import Position
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.encoding import decode, encode
from m4e_fmi.files.files_read import opened
from m4e_fmi.files.limits import LARGEST_CHECKPOINT
from m4e_fmi.files.writing import written
from m4e_fmi.fmu.importer.calls import SerializedState

SUFFIX = ".checkpoint"
MAGIC = b"m4e_fmi checkpoint "
VERSION = 8
"""The number of the form; files of other numbers are refused."""
_REMEDY = "take another checkpoint, or run again from the start"
EXACT = 1e-6
"""Share of a step, or of an interval, by which a time may miss a checkpoint by rounding."""


def checkpoint_of(results: str | Path) -> Path:
    """The checkpoint beside a results file."""
    path = Path(results)
    return path.with_name(path.name + SUFFIX)


def results_of(checkpoint: Path) -> Path:
    """The results file beside a checkpoint; InputError if that is not named as one."""
    if checkpoint.suffix != SUFFIX:
        message = f"is not named as a checkpoint, RESULTS{SUFFIX}"
        raise InputError.single(message, "give the checkpoint beside its results", str(checkpoint))
    return checkpoint.with_suffix("")


@dataclass(frozen=True, eq=False)
class State:
    """The state of a whole system at a communication point of a run, until that ends.

    It holds the states of the FMUs, the exchanged values, the algorithm's past values,
    the energy balance, the position in time, the row of the results, and the error estimate.
    `run` is the run that it belongs to, None in a file.
    """

    run: object = field(repr=False)
    point: NetworkSnapshot = field(repr=False)
    algorithm: Snapshot = field(repr=False)
    control: Snapshot | None = field(repr=False)
    energy: Snapshot = field(repr=False)
    position: Position = field(repr=False)
    second_look: Snapshot = field(repr=False)
    row: Mark | None = field(repr=False)
    seen: Snapshot | None = field(repr=False)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.point.time

    @property
    def points(self) -> tuple[NetworkSnapshot, ...]:
        """All points of which the FMUs keep states."""
        return (self.point, *(self.seen["state"].points if self.seen else ()))


@dataclass(frozen=True)
class Memory:
    """Memory of a run of its past that does not go back when it returns to a state.

    `warned` are the numbers of steps that FMUs have answered with Warning, with the times [s] of
    the first and the last; `messages` what they have logged, `ranges` the outputs that have left
    the range of their FMU, by component and column.
    """

    warned: dict[str, tuple[int, float, float]]
    messages: Kinds
    ranges: tuple[dict[int, str], ...]


@dataclass(frozen=True)
class Saved:
    """A state for another process, and its place in its run.

    `identity` is what must be the same in a run that is resumed. `rows` are in the results by then,
    the last at `last` [s], with the checksum `digest`. `texts` are those that stand in cells, in
    their order. `fmu_states` are those of the state's points, by place and component.
    """

    identity: dict[str, str]
    rows: int
    last: float
    digest: str
    texts: tuple[bytes, ...]
    state: State
    fmu_states: dict[int, dict[str, SerializedState]]
    memory: Memory

    def give(self, network: Network) -> None:
        """Give the FMUs of this process their states; RunError if one refuses."""
        points = {point.place: point for point in self.state.points}
        for place in sorted(points):
            for name, instance in network.instances.items():
                state = self.fmu_states[place][name]
                instance.rollback.deserialize(instance.slot(place), state)
            network.adopt(points[place])

    def take_texts(self, network: Network) -> None:
        """Give texts the places that they had; RunError if the run's own start has others."""
        for place, text in enumerate(self.texts):
            if network.discrete.texts.place(text) != place:
                raise RunError(
                    "the texts at the start are not those of the run that the checkpoint is of: an "
                    "FMU is not deterministic",
                    "run again from the start, without --resume",
                )


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that a run is resumed from; its file is read only."""

    path: Path
    saved: Saved

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.saved.state.time

    @property
    def rows(self) -> FirstRows:
        """The rows with which the results begin."""
        saved = self.saved
        return FirstRows(results_of(self.path), saved.rows, saved.last, saved.digest)

    def check(self, identity: Mapping[str, str], stop_time: float) -> None:
        """InputError if the run has another `identity`, or ends before the checkpoint [s]."""
        check_identity(str(self.path), self.saved.identity, identity)
        if stop_time < self.time:
            message = f"the checkpoint is at t = {self.time:.9g} s, after the stop time"
            remedy = f"take a stop_time of {self.time:.9g} s or more"
            raise InputError.single(message, remedy, str(self.path))


def write_checkpoint(path: Path, saved: Saved) -> None:
    """Write a state to `path`; an existing file is replaced once it is on the disk.

    RunError if that fails; TypeError if it holds values that cannot be saved.
    """
    content = encode(saved)
    with written(path) as place, place.open("wb") as file:
        file.write(MAGIC + b"%d\n" % VERSION)
        file.write(hashlib.sha256(content).hexdigest().encode() + b"\n")
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def read_checkpoint(path: Path) -> Checkpoint:
    """The checkpoint at `path`.

    InputError if there is no such file, if it is cut off, altered or too large, or of a form that
    is not read here.
    """
    try:
        return Checkpoint(path, decode(Saved, _content(path)))
    except (UnpicklingError, EOFError, AttributeError, TypeError, ValueError, LookupError) as error:
        raise InputError.single(f"is damaged: {error}", _REMEDY, str(path)) from error


def _content(path: Path) -> bytes:
    """All that is behind the checksum of a file, which is right; or InputError."""
    try:
        if path.stat().st_size > LARGEST_CHECKPOINT:
            message = f"is larger than {LARGEST_CHECKPOINT} bytes, which no checkpoint is"
            raise InputError.single(message, _REMEDY, str(path))
        with opened(path) as file:
            magic, digest = file.readline(len(MAGIC) + 20), file.readline(65)
            if not magic.startswith(MAGIC):
                raise InputError.single("is not a checkpoint", _REMEDY, str(path))
            if magic != MAGIC + b"%d\n" % VERSION:
                version = magic.removeprefix(MAGIC).strip().decode("ascii", "replace")
                message = f"is a checkpoint of form {version[:20]}; only {VERSION} is read here"
                raise InputError.single(message, _REMEDY, str(path))
            content = file.read(LARGEST_CHECKPOINT)
    except OSError as error:
        why = "no such file" if isinstance(error, FileNotFoundError) else error.strerror
        message = f"the checkpoint cannot be read: {why}"
        raise InputError.single(message, _REMEDY, str(path)) from None
    if hashlib.sha256(content).hexdigest().encode() + b"\n" != digest:
        message = "is cut off or altered: its checksum is not that of its content"
        raise InputError.single(message, _REMEDY, str(path))
    return content


class Checkpoints:
    """Checkpoints of a run by `simulation` at `path`, each in place of the one before.

    `taken` is the time [s] of the last one, None before the first. `warn` is called once if one
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
        self._wait(checkpoint.time)
        self.taken = checkpoint.time if checkpoint.path == self.path else None

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

    def write(self, time: float, saved: Callable[[], Saved]) -> None:
        """Write a checkpoint at `time` [s]; where that fails, the one before stays."""
        try:
            write_checkpoint(self.path, saved())
            self.taken = time
        except RunError as error:
            if self._warn:
                last = "there is none" if self.taken is None else f"the last is of {self.taken:g} s"
                self._warn(f"warning: no checkpoint at t = {time:.9g} s: {error.message}; {last}")
                self._warn = None
        self._due = clock.monotonic() + self._wall
