"""`Record`: what is kept of one run, its statistics, and the `Store` of kept runs.

The store is a database of SQLite, which locks it where several studies write, writes a record whole
or not at all, and has on the disk what it says it has, however the process ends.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from m4e_fmi.errors import RunError
from m4e_fmi.files.writing import cannot_write
from m4e_fmi.statistics import STATISTICS
from m4e_fmi.study.given.study import Wanted


@dataclass(frozen=True)
class Record:
    """Numbers of one run, and how it went: all that is kept of it.

    `values` are the wanted statistics by name, in their units; `time` (n,) [s] and `series` (n,) by
    variable those that are wanted whole. `coupling_error` [1] is the largest over the range, nan if
    it is not known, at `coupling_at`. `failure` is empty of a run that reached its end, `undefined`
    has the reasons of statistics that are nan.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    time: np.ndarray = field(default_factory=lambda: np.empty(0), repr=False)
    series: Mapping[str, np.ndarray] = field(default_factory=dict, repr=False)
    coupling_error: float = float("nan")
    coupling_at: str = ""
    wall_time: float = 0.0
    failure: str = ""
    warnings: tuple[str, ...] = ()
    undefined: Mapping[str, str] = field(default_factory=dict)

    def head(self) -> str:
        """All but the arrays, as JSON; numbers keep all their digits."""
        told = {k: v for k, v in vars(self).items() if k not in ("time", "series")}
        return json.dumps({**told, "series": list(self.series)})

    def block(self) -> bytes:
        """The arrays: times, then each series."""
        if not self.series:
            return b""
        return np.stack([self.time, *self.series.values()]).astype("<f8").tobytes()

    @classmethod
    def of(cls, head: str, block: bytes) -> Record:
        """The record of a head and a block; RunError if they are damaged."""
        try:
            told = json.loads(head)
            names = told.pop("series")
            arrays = np.frombuffer(block, "<f8").reshape(len(names) + 1, -1)
            told["warnings"] = tuple(told["warnings"])
            if not names:
                return cls(**told)
            series = dict(zip(names, arrays[1:], strict=True))
            return cls(**told, time=arrays[0], series=series)
        except (ValueError, TypeError, KeyError) as error:
            raise RunError(f"a kept run is damaged: {error}", "run with --fresh") from error


def records_of(
    wanted: Sequence[Wanted],
    series: Sequence[str],
    time: np.ndarray,
    values: Mapping[str, np.ndarray],
    start_up: float,
) -> list[Record]:
    """The records of m runs with their statistics, and why they are nan.

    `time` (n,) [s], `values` (m, n) by variable, in their units; those before `start_up` [s] do not
    count in statistics.
    """
    after = time >= start_up
    counted = slice(None) if np.all(after) else after  # no copies of all
    told = {
        one.name: STATISTICS[one.statistic].explained(
            time[counted], values[one.variable][:, counted], **dict(one.parameters)
        )
        for one in wanted
    }
    return [
        Record(
            values={name: float(one.values[k]) for name, one in told.items()},
            time=time if series else np.empty(0),
            series={name: values[name][k] for name in series},
            undefined={name: one.reasons[k] for name, one in told.items() if one.reasons[k]},
        )
        for k in range(len(next(iter(values.values()))))
    ]


_PATIENCE = 60.0
"""Seconds that another study may take to write."""
_NO_WRITING = (
    sqlite3.SQLITE_FULL,
    sqlite3.SQLITE_IOERR,
    sqlite3.SQLITE_CANTOPEN,
    sqlite3.SQLITE_READONLY,
    sqlite3.SQLITE_PERM,
)
"""Codes of SQLite: the file is in order, but cannot be written."""
_REMEDIES = {
    sqlite3.SQLITE_BUSY: "wait for the other study",
    sqlite3.SQLITE_LOCKED: "wait for the other study",
    sqlite3.SQLITE_CORRUPT: "remove the file",
    sqlite3.SQLITE_NOTADB: "remove the file",
}
_FORM = 1
"""Number of the form of the database."""


class Store:
    """The records in the file `path`; use it as a context manager.

    RunError if it cannot be written, is damaged or is no store.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def __enter__(self) -> Store:
        with self._errors():
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._base = sqlite3.connect(self.path, timeout=_PATIENCE, isolation_level=None)
            (form,) = self._base.execute("PRAGMA user_version").fetchone()
            if form not in (0, _FORM):
                message = f"{self.path}: kept runs of another version of m4e_fmi"
                raise RunError(message, "remove the file, or choose another build folder")
            self._base.execute("PRAGMA synchronous = FULL")
            self._base.execute(
                "CREATE TABLE IF NOT EXISTS runs "
                "(key TEXT PRIMARY KEY, head TEXT NOT NULL, block BLOB NOT NULL) WITHOUT ROWID"
            )
            if form != _FORM:
                self._base.execute(f"PRAGMA user_version = {_FORM}")
        return self

    def __exit__(self, *_: object) -> None:
        self._base.close()

    def found(self, keys: Sequence[str]) -> dict[str, Record]:
        """The records that are there, by key."""
        records: dict[str, Record] = {}
        with self._errors():
            for key in keys:
                question = "SELECT head, block FROM runs WHERE key = ?"
                for head, block in self._base.execute(question, (key,)):
                    records[key] = Record.of(head, block)
        return records

    def keep(self, records: Mapping[str, Record], *, again: bool = False) -> None:
        """Add records, in place of others that are made `again`.

        They are on the disk when this returns. Those of failed runs are not kept.
        """
        rows = [(k, r.head(), r.block()) for k, r in records.items() if not r.failure]
        if not rows:
            return
        instead = "REPLACE" if again else "IGNORE"
        with self._errors(), self._base:  # which commits, or rolls back
            self._base.execute("BEGIN IMMEDIATE")
            self._base.executemany(f"INSERT OR {instead} INTO runs VALUES (?, ?, ?)", rows)

    @contextmanager
    def _errors(self) -> Generator[None]:
        try:
            yield
        except sqlite3.DatabaseError as error:
            code = getattr(error, "sqlite_errorcode", 0) & 0xFF  # without what it adds to them
            if code in _NO_WRITING:
                raise cannot_write(self.path, error) from error
            remedy = _REMEDIES.get(code, "choose another build folder")
            raise RunError(f"{self.path}: kept runs: {error}", remedy) from error
        except OSError as error:
            raise cannot_write(self.path, error) from error
