"""Results on disk: netCDF-4, one group per component, streamed while the run goes on.

The dimension and the variable `time` are at the root; a group `buoy` holds the variables of the
component `buoy` under their FMI names, each with `units` and `long_name`.
"""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.operations import Get
from m4e_fmi.cosim.schedule import Schedule
from m4e_fmi.errors import RunError

BLOCK = 256
"""Rows that are kept in memory before they are written."""
FLUSH = 5.0
"""Seconds of wall time after which rows reach the disk even if the block is not full."""


class ResultsWriter:
    """Writes rows of all scalar Real outputs of a network; use it as a context manager.

    A row reaches the disk with its block of 256, or after five seconds; a run that is killed leaves
    a readable file.
    """

    def __init__(self, path: str | Path, network: Network, attributes: Mapping[str, str]) -> None:
        from netCDF4 import Dataset

        self.path = Path(path)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = Dataset(self.path, "w", format="NETCDF4")
        except OSError as error:
            raise RunError(f"{path}: cannot be written: {error}", "choose another file") from error
        self._file.setncatts({**attributes, "created": datetime.now(UTC).isoformat("T", "seconds")})
        self._file.createDimension("time", None)
        self._time = self._file.createVariable("time", "f8", ("time",), chunksizes=(BLOCK,))
        self._time.setncatts({"units": "s", "long_name": "simulated time"})
        self._times = np.zeros(BLOCK)
        self._groups = [_Group(self._file, network, name) for name in network.instances]
        self.schedule = Schedule([o for group in self._groups for o in group.operations])
        self._rows = 0
        self._written = 0
        self._flushed = clock.monotonic()
        self._file.sync()

    def __enter__(self) -> ResultsWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def row(self) -> int:
        """The next row of the block, which `schedule` fills; below BLOCK."""
        return self._rows

    def record(self, time: float) -> None:
        """Read all outputs, at `time` [s], into the next row."""
        self.schedule.run(time, row=self._rows)
        self.keep([time])

    def keep(self, times: Sequence[float]) -> None:
        """So many further rows are filled, read at `times` [s]."""
        last = self._rows + len(times)
        self._times[self._rows : last] = times
        self._rows = last
        if self._rows == BLOCK or clock.monotonic() - self._flushed > FLUSH:
            self.flush()

    def flush(self) -> None:
        """Bring all rows to the disk."""
        if self._rows:
            rows = slice(self._written, self._written + self._rows)
            self._time[rows] = self._times[: self._rows]
            for group in self._groups:
                group.write(rows, self._rows)
            self._written += self._rows
            self._rows = 0
            self._file.sync()
        self._flushed = clock.monotonic()

    def close(self) -> None:
        """Write what is left and close the file."""
        if self._file.isopen():
            self.flush()
            self._file.close()


class _Group:
    """The outputs of one component: a block of rows, and the netCDF variables they go to."""

    def __init__(self, file: Any, network: Network, component: str) -> None:
        group = file.createGroup(component)
        outputs = [
            v
            for v in network.instances[component].description.of_causality("output")
            if v.type == "Real" and not v.name.endswith("]")
        ]
        self._variables = []
        for output in outputs:
            variable = group.createVariable(output.name, "f8", ("time",), chunksizes=(BLOCK,))
            variable.setncatts({"units": output.unit or "1", "long_name": output.description})
            self._variables.append(variable)
        self._block = np.zeros((BLOCK, len(outputs)))
        names = tuple(output.name for output in outputs)
        instance = network.instances[component]
        self.operations = (Get(instance, names, self._block),) if names else ()

    def write(self, rows: slice, count: int) -> None:
        for variable, column in zip(self._variables, self._block.T, strict=True):
            variable[rows] = column[:count]
