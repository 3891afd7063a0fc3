"""Results on disk: netCDF-4, one group per component, streamed while the run goes on.

The dimension and the variable `time` are at the root; a group `buoy` holds the variables of the
component `buoy` under their FMI names, each with `units` and `long_name`.
"""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.cosim.connect import Port
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.operations import Get, Operation, gather
from m4e_fmi.cosim.schedule import Schedule
from m4e_fmi.cosim.selection import chosen
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.reading import Variable
from m4e_fmi.writing import cannot_write

CHUNK = 64, 16384
"""Least and most rows of a variable that lie together in the file."""
MOST_ROWS, MOST_VALUES = 65536, 2**22
"""Rows, and values in all of them, that are kept in memory before they are written."""
FLUSH = 5.0
"""Seconds of wall time after which rows reach the disk even if the block is not full."""


@dataclass(frozen=True)
class Mark:
    """A place in the results: rows before it, the last one's time [s], returns until then."""

    rows: int
    last: float
    backs: int


class ResultsWriter:
    """Writes rows of Real variables of a network; use it as a context manager.

    These are all scalar outputs, or what `variables` choose (see `chosen`). A row reaches the disk
    with its block (of 4 million values at most), or after five seconds; a run that is killed leaves
    a readable file. `expected` is the number of rows, for a file of the right size: there may be
    more or less. The file's attribute `ended` says how the run did.
    """

    def __init__(
        self,
        path: str | Path,
        network: Network,
        attributes: Mapping[str, str],
        *,
        expected: int,
        variables: Sequence[str] = (),
    ) -> None:
        from netCDF4 import Dataset

        self.path = Path(path)
        descriptions = {name: i.description for name, i in network.instances.items()}
        names = chosen(descriptions, variables)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = Dataset(self.path, "w", format="NETCDF4")
        except (OSError, RuntimeError) as error:
            with suppress(OSError):
                if not self.path.stat().st_size:
                    self.path.unlink()
            raise cannot_write(self.path, error) from error
        self._rows = 0
        self._written = 0
        self._backs: list[int] = []
        self.last = network.time
        self._flushed = clock.monotonic()
        with self._errors():
            self._declare(network, attributes, names, expected)

    def _declare(
        self,
        network: Network,
        attributes: Mapping[str, str],
        outputs: Mapping[str, list[Variable]],
        expected: int,
    ) -> None:
        self._file.setncatts({**attributes, "created": datetime.now(UTC).isoformat("T", "seconds")})
        self._file.createDimension("time", None)
        count = sum(map(len, outputs.values()))
        self._block, chunk = _sizes(expected, count + 1)
        self._time = self._file.createVariable("time", "f8", ("time",), chunksizes=(chunk,))
        self._time.setncatts({"units": "s", "long_name": "simulated time"})
        self._times = np.zeros(self._block)
        self._groups = [
            _Group(self._file, network, name, outputs[name], self._block, chunk)
            for name in network.instances
        ]
        self.schedule = Schedule([o for group in self._groups for o in group.operations])
        self._file.sync()

    def __enter__(self) -> ResultsWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, _: object) -> None:
        self.close("at the stop time" if kind is None else _ending(error))

    def mark(self) -> Mark:
        """The present end of the rows."""
        return Mark(self._written + self._rows, self.last, len(self._backs))

    def back(self, mark: Mark) -> None:
        """Go on after the rows that there were at `mark`; RunError if they were given up since."""
        if min(self._backs[mark.backs :], default=mark.rows) < mark.rows:
            raise RunError(
                f"the results up to t = {mark.last:.9g} s that led to that state were given up by "
                "going back further",
                "restore states from the latest to the earliest, or run without results",
            )
        self._backs.append(mark.rows)
        self._rows = max(0, mark.rows - self._written)
        self._written = min(mark.rows, self._written)
        self.last = mark.last

    @property
    def row(self) -> int:
        """The next row of the block, which `schedule` fills."""
        return self._rows

    @property
    def room(self) -> int:
        """Rows of the block that are not yet filled; one at least."""
        return self._block - self._rows

    def record(self, time: float) -> None:
        """Read all outputs, at `time` [s], into the next row."""
        self.schedule.run(time, row=self._rows)
        self.keep(np.array([time]))

    def keep(self, times: np.ndarray) -> None:
        """Further rows are filled, read at `times` [s] (n,), one at least."""
        last = self._rows + len(times)
        self._times[self._rows : last] = times
        self.last = float(times[-1])
        self._rows = last
        if self._rows == self._block or clock.monotonic() - self._flushed > FLUSH:
            self.flush()

    def flush(self) -> None:
        """Bring all rows to the disk; RunError if it does not take them."""
        with self._errors():
            self._flush()

    def _flush(self) -> None:
        if self._rows:
            rows = slice(self._written, self._written + self._rows)
            self._time[rows] = self._times[: self._rows]
            for group in self._groups:
                group.write(rows, self._rows)
            self._file.sync()
            self._written += self._rows
            self._rows = 0
        self._flushed = clock.monotonic()

    def close(self, ended: str) -> None:
        """Write what is left and how the run has `ended`, and close the file.

        RunError if the disk does not take it.
        """
        if self._file.isopen():
            with self._errors():
                self._flush()
                self._file.setncattr("ended", ended)
                longer = len(self._time) > self._written
                self._file.close()
                if longer:
                    _cut(self.path, self._written)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Errors of netCDF as RunError; what had reached the disk before can be read, if any."""
        try:
            yield
        except (OSError, RuntimeError) as error:
            with suppress(RuntimeError):
                self._file.close()
            if not self._written:
                self.path.unlink(missing_ok=True)
            raise cannot_write(self.path, error) from error


def _sizes(expected: int, columns: int) -> tuple[int, int]:
    """Rows that are written together, and those of a chunk: whole chunks, the last one full too."""
    most = max(CHUNK[0], min(MOST_ROWS, MOST_VALUES // columns))
    chunks = ceil(expected / min(CHUNK[1], most))
    chunk = max(CHUNK[0], ceil(expected / chunks))
    return max(1, most // chunk) * chunk, chunk


def _cut(path: Path, rows: int) -> None:
    """Leave the first `rows` in the file: those after them are of a course that was given up."""
    from netCDF4 import Dataset

    cut = path.with_suffix(".cut")
    with Dataset(path) as whole, Dataset(cut, "w", format="NETCDF4") as file:
        file.createDimension("time", None)
        for source in (whole, *whole.groups.values()):
            target = file if source is whole else file.createGroup(source.name)
            target.setncatts({name: source.getncattr(name) for name in source.ncattrs()})
            for name, old in source.variables.items():
                new = target.createVariable(name, "f8", ("time",))
                new.setncatts({key: old.getncattr(key) for key in old.ncattrs()})
                new[:] = old[:rows]
    cut.replace(path)


def _ending(error: object) -> str:
    if isinstance(error, RunError):
        return f"failed: {error.message}"
    return "interrupted" if isinstance(error, KeyboardInterrupt) else f"failed: {error}"


class _Group:
    """What is recorded of one component: blocks of rows, and the netCDF variables they go to.

    Outputs are as they were exchanged, or read with those; what the network does not know, the FMU
    tells.
    """

    def __init__(
        self,
        file: Any,
        network: Network,
        component: str,
        outputs: Sequence[Variable],
        rows: int,
        chunk: int,
    ) -> None:
        group, rate = file.createGroup(component), network.rates.get(component)
        if rate:
            group.setncattr("step_size", f"{rate.step:g} s")
        self._variables = []
        for output in outputs:
            variable = group.createVariable(output.name, "f8", ("time",), chunksizes=(chunk,))
            variable.setncatts({"units": output.unit or "1", "long_name": output.description})
            self._variables.append(variable)
        places = [network.known(Port(component, output.name)) for output in outputs]
        known = [place for place in places if place is not None]
        asked = [o.name for o, place in zip(outputs, places, strict=True) if place is None]
        blocks = np.zeros((rows, len(known))), np.zeros((rows, len(asked)))
        self.operations: list[Operation] = []
        if known:
            self.operations.append(gather(blocks[0], network.values, known))
        if asked:
            instance = network.instances[component]
            self.operations.append(Get(instance, tuple(asked), blocks[1]))
        columns = iter(blocks[0].T), iter(blocks[1].T)
        self._columns = [next(columns[place is None]) for place in places]

    def write(self, rows: slice, count: int) -> None:
        for variable, column in zip(self._variables, self._columns, strict=True):
            variable[rows] = column[:count]
