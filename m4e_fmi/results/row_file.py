"""Rows of results on their way to the disk: a file that a kill or a full disk cannot spoil.

It is of netCDF's classic form with 64-bit sizes (CDF-5): a header, then row after row. The number
of rows stands in the header; it is written last, once the rows are on the disk, so that every
reader of netCDF sees complete rows only. HDF5, the form of results in the end, spreads changes of
its own tables over the file, and a kill between two of them can make all of it unreadable.

The form is at https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html
"""

from __future__ import annotations

import json
import os
import shutil
import unicodedata
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path
from typing import BinaryIO, Protocol

import numpy as np

from m4e_fmi.files.writing import part_prefix
from m4e_fmi.results.series import REAL, Recorded

MAGIC = b"CDF\x05"
"""The first bytes of a file."""
ROWS_BEGIN, CLOSING, TEXTS, ENDED = "rows_begin", "closing", "texts", "ended"
"""The first and the last attributes: where rows begin, others that are known at the end (JSON),
texts by lines, how the run ended.
"""
NOT_ENDED = "not yet: the run goes on, or its process was killed"
"""The attribute `ended` until the file is told otherwise."""
CELLS = "i8"
"""The kind of cells: whole numbers, Booleans, and the places of texts."""
READ = 2**24
"""Bytes of rows that are read at once, about."""
_ENDED_LENGTH, _CLOSING_LENGTH = 1024, 8192
"""Bytes of the texts of ENDED and CLOSING."""
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_CHAR, _TYPES = 2, {"f8": 6, "i8": 10}


@dataclass(frozen=True)
class ResultColumn:
    """Name and properties of one variable of results."""

    name: str
    unit: str
    long_name: str
    recorded: Recorded = REAL


@dataclass(frozen=True)
class RowSection:
    """Columns of one `component` that are of one `kind`: f8 for Reals, CELLS for all else."""

    component: str
    columns: tuple[ResultColumn, ...]
    kind: str = "f8"
    attributes: Mapping[str, str] = field(default_factory=dict)


class Numbered(Protocol):
    """Texts by their places, from 0 on; they keep them."""

    def __len__(self) -> int: ...
    def __getitem__(self, place: int, /) -> str: ...


TIME = RowSection("", (ResultColumn("time", "s", "simulated time"),))
"""The first section of every file."""


class RowFile:
    """A file of rows of `sections`, TIME before them, that is being written at `path`.

    `count` is the number of rows that can be read. Every method raises OSError if the disk does
    not take what it writes; the rows that there are can be read then.
    """

    def __init__(
        self,
        path: Path,
        sections: Sequence[RowSection],
        attributes: Mapping[str, str | int],
        *,
        room: int = 2**14,
    ) -> None:
        """`room` are the bytes for texts at first, if there is a column of them."""
        self.path, self.count = path, 0
        self._sections, self._attributes = sections, attributes
        row = [(f"_{k}", f">{s.kind}", (len(s.columns),)) for k, s in enumerate((TIME, *sections))]
        self._row = np.dtype(row)  # all types have eight bytes, so that there are no gaps
        self._room = room * any(c.recorded.is_text for s in sections for c in s.columns)
        self._texts = self._texts_end = 0
        head, self._places = _header((TIME, *sections), attributes, self._room)
        self._begin = len(head)
        self._file = path.open("w+b", buffering=0)
        self._put(0, head)

    def move(self, path: Path) -> None:
        """Continue at `path`, in the same folder; an existing file is replaced."""
        self._file.close()  # Windows moves no open file
        self.path.replace(path)
        self.path = path
        self._file = path.open("r+b", buffering=0)

    def append(self, first: int, parts: Sequence[np.ndarray]) -> None:
        """Write rows from row `first` on, which may be before the end: later rows are given up.

        `parts` are arrays (n_rows, n_columns) in the variables' units, one for each section.
        OSError if the disk does not take all of them; those that it took can be read then.
        """
        self.cut(first)
        rows = np.empty(len(parts[0]), self._row)
        for name, part in zip(self._row.names or (), parts, strict=True):
            rows[name] = part
        size = self._row.itemsize
        place = self._begin + first * size
        try:
            self._put(place, rows.view(np.uint8).data)
        except OSError:
            with suppress(OSError):
                self._commit(first + (self._file.tell() - place) // size)
            raise
        self._commit(first + len(rows))

    def keep_texts(self, texts: Numbered) -> None:
        """Keep what the cells of texts stand for, before rows with them are written."""
        if not self._room or len(texts) == self._texts:
            return
        new = [json.dumps(texts[place]) + "\n" for place in range(self._texts, len(texts))]
        data = "".join(new).encode()
        if self._texts_end + len(data) > self._room:
            self._enlarge(texts, self._texts_end + len(data))
            return
        self._put(self._places[TEXTS] + self._texts_end, data)
        self._texts, self._texts_end = len(texts), self._texts_end + len(data)

    def _enlarge(self, texts: Numbered, room: int) -> None:
        """Go on in a file with more than `room` [bytes] for `texts`, in the same place."""
        beside = self.path.with_name(f"{part_prefix()}{uuid.uuid4().hex}")
        larger = RowFile(beside, self._sections, self._attributes, room=2 * room)
        try:
            larger.keep_texts(texts)
            self._file.seek(self._begin)
            larger._file.seek(larger._begin)
            shutil.copyfileobj(self._file, larger._file)
            larger._commit(self.count)
        except OSError:
            larger.close()
            beside.unlink()
            raise
        self.close()
        larger.move(self.path)
        vars(self).update(vars(larger))

    def cut(self, count: int) -> None:
        """Give up all rows but the first `count`."""
        if count < self.count:
            self._commit(count)

    def end(self, text: str, closing: Mapping[str, str] | None = None) -> None:
        """Write how the run has ended, and `closing`, further attributes, those that fit."""
        self._put(self._places[CLOSING], _closing(closing or {}))
        self._put(self._places[ENDED], _ended(text))
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file; it can be moved and replaced then, on Windows too."""
        self._file.close()

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self._file.closed

    def blocks(self) -> Iterator[list[np.ndarray]]:
        """Blocks of rows: an array (n_rows, n_columns) for each section, in the variables' units.

        They can be read after `close`, too; before, also where the file has been moved or removed.
        """
        with ExitStack() as stack:
            file = self._file
            if file.closed:
                file = stack.enter_context(self.path.open("rb", buffering=0))
            for rows in blocks_of_rows(file, self._row, self._begin, self.count):
                yield [rows[name] for name in self._row.names or ()]

    def _commit(self, count: int) -> None:
        os.fsync(self._file.fileno())
        self._put(len(MAGIC), _big(count))
        self.count = count

    def _put(self, place: int, data: bytes | memoryview) -> None:
        view = memoryview(data).cast("B")
        self._file.seek(place)
        while view:
            view = view[self._file.write(view) :]


def blocks_of_rows(
    file: BinaryIO | FileIO, row: np.dtype, begin: int, count: int
) -> Iterator[np.ndarray]:
    """The first `count` rows (n_rows,) of type `row` behind `begin` [bytes], block by block."""
    most = max(1, READ // row.itemsize)
    for first in range(0, count, most):
        file.seek(begin + first * row.itemsize)
        yield np.fromfile(file, row, min(most, count - first))


def _ended(text: str) -> bytes:
    """The text of ENDED, cut or filled with blanks to its length."""
    return text.encode()[:_ENDED_LENGTH].decode(errors="ignore").encode().ljust(_ENDED_LENGTH)


def _closing(attributes: Mapping[str, str]) -> bytes:
    """The text of CLOSING; without the longest of these attributes where they do not fit."""
    kept = dict(sorted(attributes.items(), key=lambda one: len(one[1])))
    while len(text := json.dumps(kept).encode()) > _CLOSING_LENGTH:
        kept.popitem()
    return text.ljust(_CLOSING_LENGTH)


def _header(
    sections: Sequence[RowSection], attributes: Mapping[str, str | int], room: int
) -> tuple[bytes, dict[str, int]]:
    """The header of a file without rows, and the places of the texts in it that change.

    These are the last attributes, of which TEXTS is there if there is `room` [bytes] for it.
    """
    texts = {TEXTS: b" " * room} if room else {}
    rest = {**attributes, CLOSING: _closing({}), **texts, ENDED: _ended(NOT_ENDED)}
    start = MAGIC + _big(0) + _list(_DIMENSIONS, [_name("time") + _big(0)])
    head = whole = b""
    for _ in range(2):  # once more with the place where rows begin, which is in it, too
        begin = len(whole)
        head = start + _list(_ATTRIBUTES, list(_attributes({ROWS_BEGIN: begin, **rest})))
        whole = head + _list(_VARIABLES, list(_variables(sections, begin)))
    names = {name: _name(name) for name in (CLOSING, *texts, ENDED)}
    return whole, {name: head.rindex(one) + len(one) + 12 for name, one in names.items()}


def _variables(sections: Sequence[RowSection], begin: int) -> Iterator[bytes]:
    for section in sections:
        prefix = f"{section.component}." if section.component else ""
        for column in section.columns:
            one = column.recorded
            told = {"units": column.unit, "long_name": column.long_name}
            if not one.is_real:
                told |= {"type": one.type, "kind": one.kind, "items": json.dumps(dict(one.items))}
            told |= section.attributes
            yield (
                _name(prefix + column.name) + _big(1) + _big(0)
                + _list(_ATTRIBUTES, list(_attributes(told)))
                + _big(_TYPES[section.kind], 4) + _big(8) + _big(begin)
            )  # fmt: skip
            begin += 8


def _attributes(attributes: Mapping[str, str | int | bytes]) -> Iterator[bytes]:
    for name, value in attributes.items():
        if isinstance(value, int):
            yield _name(name) + _big(_TYPES["i8"], 4) + _big(1) + _big(value)
        else:
            data = value.encode() if isinstance(value, str) else value
            yield _name(name) + _big(_CHAR, 4) + _counted(data)


def _list(tag: int, elements: Sequence[bytes]) -> bytes:
    return _big(tag, 4) + _big(len(elements)) + b"".join(elements)


def _name(name: str) -> bytes:
    return _counted(unicodedata.normalize("NFC", name).encode())


def _counted(data: bytes) -> bytes:
    return _big(len(data)) + data + bytes(-len(data) % 4)


def _big(value: int, size: int = 8) -> bytes:
    return value.to_bytes(size, "big")
