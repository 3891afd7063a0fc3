"""Kept runs: a database of records by the hash of all that a run follows from.

It is SQLite's, which locks it where several studies write, writes a record whole or not at all, and
has on the disk what it says it has, however the process ends.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from m4e_fmi.errors import RunError
from m4e_fmi.files.writing import cannot_write
from m4e_fmi.study.runs.record import Record

_PATIENCE = 60.0
"""Seconds that another study may take to write."""
_MOST_ASKED = 500
"""Keys in one question."""
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
            for first in range(0, len(keys), _MOST_ASKED):
                part = keys[first : first + _MOST_ASKED]
                marks = ", ".join("?" * len(part))
                rows = self._base.execute(
                    f"SELECT key, head, block FROM runs WHERE key IN ({marks})", part
                )
                records |= {key: Record.of(head, block) for key, head, block in rows}
        return records

    def keep(self, records: Mapping[str, Record], *, again: bool = False) -> None:
        """Add records, in place of others that are made `again`.

        They are on the disk when this returns. Those of failed runs are not kept.
        """
        rows = [(k, r.head(), r.block()) for k, r in records.items() if not r.failure]
        if not rows:
            return
        with self._errors():
            self._base.execute("BEGIN IMMEDIATE")
            try:
                self._write(rows, "REPLACE" if again else "IGNORE")
            except BaseException:
                if self._base.in_transaction:  # SQLite ends it itself where a disk is full
                    self._base.execute("ROLLBACK")
                raise
            self._base.execute("COMMIT")

    def _write(self, rows: Iterable[tuple[str, str, bytes]], instead: str) -> None:
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
