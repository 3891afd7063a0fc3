"""Results of a run: rows that reach the disk while it goes on, and a netCDF-4 file at its end.

The rows are in a file of the form of `row_file`, from the first step on at the place of the
results, all of them before anything else is done at the end. Then a netCDF-4 file takes that place:
see `m4e_fmi.results.results_file`.
"""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.cosim.results.blocks import ComponentBlock, ScenarioBlock, blocks
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.locks import ROWS
from m4e_fmi.files.writing import cannot_write
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.results.results_file import FORMAT, FORMAT_NUMBER, digest_of, rows_of, write_netcdf
from m4e_fmi.results.row_file import RowFile, RowSection
from m4e_fmi.signals import let_through

LEAST_ROWS, MOST_ROWS, MOST_VALUES = 64, 65536, 2**22
"""Rows that are kept in memory, and values in all of them."""
FLUSH = 1.0
"""Seconds of wall time after which rows reach the disk; at first an eighth of them."""
SHARE = 0.1
"""Part of the wall time that this may take where the disk is slow."""


@dataclass(frozen=True)
class Mark:
    """A place in the results: rows before it, the last one's time [s], returns until then."""

    rows: int
    last: float
    backs: int


@dataclass(frozen=True)
class FirstRows:
    """Results that a run continues: the first `rows` in the file `path`.

    The last of them is at `last` [s], and has the checksum `digest`.
    """

    path: Path
    rows: int
    last: float
    digest: str


class ResultsWriter:
    """Writes rows of the `recorded` variables of a network, by component, up to its `close`.

    Rows reach the disk after a second; a run that is killed leaves a file with them. `path` is
    absolute, and claimed by this run. What was there before stays until the first step is on the
    disk, or the run has ended without one; then the files `beside` go, which were made of it. The
    file's attribute `ended` says how the run did. RunError if the disk takes nothing.

    `row` is the next row of the block, which `schedule` fills. `saved` are the rows of this run in
    the file at `path`, and the time [s] of the last one; None if none is there.
    """

    def __init__(
        self,
        path: Path,
        network: Network,
        recorded: Mapping[str, Sequence[Variable]],
        attributes: Mapping[str, str],
        *,
        beside: Sequence[Path] = (),
        earlier: Sequence[Path] = (),
        first: FirstRows | None = None,
    ) -> None:
        """The file begins with the `first` rows of a run that is resumed.

        The files `earlier` belong to earlier results, and go when these are replaced.
        """
        self._beside, self._earlier = beside, earlier
        self.path = path
        columns = 1 + sum(map(len, recorded.values()))
        self._block = max(LEAST_ROWS, min(MOST_ROWS, MOST_VALUES // columns))
        self._blocks = [
            block
            for name in network.instances
            for block in blocks(network, name, recorded[name], self._block)
        ]
        self._limited = [block for block in self._blocks if block.limited]
        self._groups: list[ComponentBlock | ScenarioBlock] = [*self._blocks]
        if network.scenario:
            self._groups.append(ScenarioBlock(network, self._block))
        self._times = np.zeros((self._block, 1))
        self._texts = network.discrete.texts
        self.schedule = Schedule([o for group in self._groups for o in group.operations])
        created = datetime.now(UTC).isoformat("T", "seconds")
        self._attributes = {**attributes, "created": created}
        self._before = self.row = 0  # rows of the run before those of the block, and these
        self._backs: list[int] = []
        self._first = first
        self._last = network.time
        self.saved: tuple[int, float] | None = None
        self.notes: tuple[str, ...] = ()
        """Warnings about the file, once it is closed; one line each."""
        hidden = path.with_name(f".{path.name}{ROWS}")
        with self._errors():
            head = {FORMAT: FORMAT_NUMBER, **self._attributes}
            self._file = RowFile(hidden, self._sections, head)
        try:
            if first:
                self._take_over(first)
        except BaseException:
            self._file.close()
            raise
        self._interval = FLUSH / 8
        self._due = clock.monotonic() + self._interval

    def _take_over(self, first: FirstRows) -> None:
        """Put the first rows into the file, and this where it belongs."""
        block: list[np.ndarray] = []
        with self._errors():
            for block in rows_of(first.path, self._sections, first.rows, self._texts.place):
                self._file.append(self._file.count, block)
            last = [part[-1:] for part in block]
            if not last or digest_of(last) != first.digest or last[0].item() != first.last:
                message = f"row {first.rows} is not the one that the checkpoint was taken after"
                raise InputError.single(message, "run again from the start", str(first.path))
            self._file.keep_texts(self._texts)
            self._file.move(self.path)
        self._remove((*self._earlier, *self._beside))
        self._before, self._last = first.rows, first.last
        self.saved = (first.rows, first.last)

    def mark(self) -> Mark:
        """The present end of the rows."""
        return Mark(self._before + self.row, self._last, len(self._backs))

    def last_row(self) -> str:
        """The checksum of the last row."""
        if self._first and self._first.rows == self._count:
            return self._first.digest
        last = self.row or self._block
        return digest_of(self._parts(slice(last - 1, last)))

    def ranges(self) -> tuple[dict[int, str], ...]:
        """The warnings of outputs outside the range of their FMU, by component and column."""
        return tuple(dict(block.outside) for block in self._blocks)

    def restore_ranges(self, ranges: Sequence[Mapping[int, str]]) -> None:
        """Continue after these warnings."""
        for block, seen in zip(self._blocks, ranges, strict=True):
            block.outside = dict(seen)

    def restore(self, mark: Mark) -> None:
        """Continue after the rows up to `mark`; RunError if they were given up since."""
        if min(self._backs[mark.backs :], default=mark.rows) < mark.rows:
            raise RunError(
                f"the results up to t = {mark.last:.9g} s that led to that state were discarded by "
                "returning further",
                "restore states from the latest to the earliest, or run without results",
            )
        self._backs.append(mark.rows)
        self.row = max(0, mark.rows - self._before)
        self._before = min(mark.rows, self._before)
        self._last = mark.last
        if mark.rows < self._file.count:
            with self._errors():
                self._file.cut(mark.rows)
            self.saved = (mark.rows, mark.last)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Outputs that were outside the range of their FMU; one line each."""
        return tuple(line for block in self._blocks for line in block.outside.values())

    @property
    def room(self) -> int:
        """Rows of the block that are not yet filled; one at least."""
        return self._block - self.row

    def record(self, time: float) -> None:
        """Read all outputs, at `time` [s], into the next row."""
        self.schedule.run(time, row=self.row)
        self.keep(np.array([time]))

    def keep(self, times: np.ndarray) -> None:
        """Further rows are filled, read at `times` [s] (n,), one at least."""
        last = self.row + len(times)
        self._times[self.row : last, 0] = times
        for block in self._limited:
            block.look(times, slice(self.row, last))
        self._last = float(times[-1])
        self.row = last
        if self.row == self._block:
            self.flush()
            self._before += self.row
            self.row = 0
        elif clock.monotonic() > self._due:
            self.flush()

    def flush(self) -> None:
        """Bring all rows to the disk, once there is a step; RunError if it does not take them."""
        began = clock.monotonic()
        if self._count > 1:
            with self._errors():
                self._flush()
        now = clock.monotonic()
        self._interval = min(2 * self._interval, FLUSH)
        self._due = now + max(self._interval, (now - began) / SHARE)

    def _flush(self) -> None:
        new = slice(self._file.count - self._before, self.row)
        try:
            if new.start < new.stop:
                self._file.keep_texts(self._texts)
                self._file.append(self._file.count, self._parts(new))
        finally:  # some rows may have come there
            self._publish()

    def _publish(self) -> None:
        """Put the rows on the disk where results belong, once there is a step."""
        count = self._file.count
        if self._file.path != self.path and (count > 1 or not self.path.exists()):
            self._file.move(self.path)
            self._remove((*self._earlier, *self._beside))
        if self._before < count <= self._count and self._file.path == self.path:
            self.saved = (count, float(self._times[count - self._before - 1, 0]))

    def _remove(self, files: Sequence[Path]) -> None:
        for path in files:
            with suppress(OSError):  # open elsewhere, on Windows
                path.unlink(missing_ok=True)

    def _parts(self, rows: slice) -> list[np.ndarray]:
        return [self._times[rows], *(group.filled(rows) for group in self._groups)]

    def close(
        self, ended: str, closing: Callable[[], Mapping[str, str]] = dict, *, failed: bool = False
    ) -> None:
        """Write the last rows and how the run has `ended`, and close the file.

        `closing` gives further attributes when all rows are on the disk. A run that has `failed`
        before its first step does not replace existing results. RunError if the rows cannot be
        written. A signal that is `held` is delivered once they are on the disk.
        """
        try:
            own = self._file.path == self.path or not self.path.exists()
            if self._count > 1 or (self._count and (own or not failed)):
                self._finish(ended, closing)
        finally:
            self._file.close()

    def _finish(self, ended: str, closing: Callable[[], Mapping[str, str]]) -> None:
        """Put all rows on the disk; in their place the netCDF-4 file, if there is room for it."""
        with self._errors():
            try:
                self._flush()
            except OSError as error:
                if not self._file.closed:
                    self._file.end(f"failed: {cannot_write(self.path, error).message}")
                raise
            self._file.end(ended)
        with let_through():
            further = closing()
            with self._errors():
                self._file.end(ended, further)
            self._write({**self._attributes, "ended": ended, **further})

    def _write(self, attributes: Mapping[str, str]) -> None:
        """Write the netCDF-4 file, or tell why it cannot be written."""
        count, folder = self._count, self.path.parent
        vanished = not folder.is_dir()
        in_memory = count == self.row
        blocks = self._file.blocks() if not in_memory else [self._parts(slice(self.row))]
        if sys.platform == "win32":
            self._file.close()  # which replaces no open file
        try:
            write_netcdf(self.path, self._sections, attributes, count, blocks, self._texts)
        except RunError as error:
            if vanished:
                raise
            self.notes = (
                "the results are complete, but in netCDF's classic format, without groups, which "
                f"m4e_fmi.results.results_file.load reads as well: {error.message}",
            )
        else:
            self._remove(self._beside)
            self.saved = (count, self._last)
        if vanished:
            self.notes = (
                f"warning: {folder} was renamed or removed during the run, and was created again "
                "for the results",
            )

    @property
    def _count(self) -> int:
        """Number of rows of the run."""
        return self._before + self.row

    @property
    def _sections(self) -> list[RowSection]:
        return [group.section for group in self._groups]

    @contextmanager
    def _errors(self) -> Generator[None]:
        """Errors of the disk as RunError."""
        try:
            yield
        except OSError as error:
            raise cannot_write(self.path, error) from error
