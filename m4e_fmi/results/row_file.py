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
from io import FileIO
from pathlib import Path

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.files.files_read import opened
from m4e_fmi.files.limits import MOST_RESULTS
from m4e_fmi.files.writing import part_prefix
from m4e_fmi.results.row_header import (
    BEGIN_AT,
    BEGIN_NAME,
    CLOSING_LENGTH,
    COUNT_AT,
    ENDED_BEFORE,
    MAGIC,
    TEXTS,
    TEXTS_BEFORE,
    TIME,
    Column,
    Header,
    Numbered,
    Section,
    closed,
    fixed,
    header,
)

READ = 2**24
"""Bytes of rows that are read at once, about."""
SMALLER = "read parts of it with netCDF4 or xarray, or record less: output_interval, --variables"
"""Remedy for a file with more values than are read at once."""


class RowFile:
    """A file of rows of `sections`, TIME before them, that is being written at `path`.

    `count` is the number of rows that can be read. Every method raises OSError if the disk does
    not take what it writes; the rows that there are can be read then.
    """

    def __init__(
        self,
        path: Path,
        sections: Sequence[Section],
        attributes: Mapping[str, str | int],
        *,
        room: int = 2**14,
    ) -> None:
        """`room` are the bytes for texts at first, if there is a column of them."""
        self.path, self.count = path, 0
        self.sections = (TIME, *sections)
        self.dtype = _row(self.sections)
        with_texts = any(c.recorded.is_text for section in sections for c in section.columns)
        self._room, self._attributes = room * with_texts, dict(attributes)
        self._texts = self._texts_end = 0
        head, self._ended_at = header(self.sections, attributes, self._room)
        self._texts_at = self._ended_at - ENDED_BEFORE - self._room
        self._begin = len(head)
        self._file = path.open("w+b", buffering=0)
        self._put(0, head)

    def move(self, path: Path) -> None:
        """Go on at `path`, in the same folder, in place of what is there."""
        self._file.close()  # Windows moves no open file
        self.path.replace(path)
        self.path = path
        self._file = path.open("r+b", buffering=0)

    def append(self, first: int, parts: Sequence[np.ndarray]) -> None:
        """Write rows from row `first` on, which may be before the end: later rows are given up.

        `parts` are arrays (n_rows, n_columns) in the variables' units, one for each section.
        OSError if the disk does not take all of them; those that it took can be read then.
        """
        if first < self.count:
            self._commit(first)
        rows = np.empty(len(parts[0]), self.dtype)
        for name, part in zip(self.dtype.names or (), parts, strict=True):
            rows[name] = part
        place, size = self._begin + first * self.dtype.itemsize, self.dtype.itemsize
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
        while self._texts_end + len(data) > self._room:
            self._grow()
        self._put(self._texts_at + self._texts_end, data)
        self._texts, self._texts_end = len(texts), self._texts_end + len(data)

    def _grow(self) -> None:
        """Go on in a file with twice the room for texts, in the same place."""
        beside = self.path.with_name(f"{part_prefix()}{uuid.uuid4().hex}")
        larger = RowFile(beside, self.sections[1:], self._attributes, room=2 * self._room)
        try:
            larger._put(larger._texts_at, _read(self._file, self._texts_at, self._texts_end))
            self._file.seek(self._begin)
            larger._file.seek(larger._begin)
            shutil.copyfileobj(self._file, larger._file)
            larger._commit(self.count)
        except OSError:
            larger.close()
            beside.unlink()
            raise
        self._file.close()
        larger.move(self.path)
        self._file, self._room, self._begin = larger._file, larger._room, larger._begin
        self._ended_at, self._texts_at = larger._ended_at, larger._texts_at

    def cut(self, count: int) -> None:
        """Give up all rows but the first `count`."""
        if count < self.count:
            self._commit(count)

    def end(self, text: str, closing: Mapping[str, str] | None = None) -> None:
        """Say how the run has ended, and `closing`, further attributes, as far as there is room."""
        texts = self._texts_at - TEXTS_BEFORE if self._room else self._ended_at - ENDED_BEFORE
        self._put(texts - CLOSING_LENGTH, closed(closing or {}))
        self._put(self._ended_at, fixed(text))
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
            yield from _blocks(file, self.dtype, self._begin, self.count)

    def _commit(self, count: int) -> None:
        os.fsync(self._file.fileno())
        self._put(COUNT_AT, count.to_bytes(8, "big"))
        self.count = count

    def _put(self, place: int, data: bytes | bytearray | memoryview) -> None:
        view = memoryview(data).cast("B")
        self._file.seek(place)
        while view:
            view = view[self._file.write(view) :]


def _row(sections: Sequence[Section]) -> np.dtype:
    """One row of a file; all its types have eight bytes, so that there are no gaps."""
    return np.dtype([(f"_{k}", f">{s.kind}", (len(s.columns),)) for k, s in enumerate(sections)])


def is_row_file(path: Path) -> bool:
    """True if the file at `path` begins as those that RowFile writes; OSError if none is there."""
    with opened(path) as file:
        head = file.read(BEGIN_AT + len(BEGIN_NAME))
    return head.startswith(MAGIC) and head.endswith(BEGIN_NAME)


def read_rows(path: Path) -> tuple[dict[str, str | int], list[tuple[Column, np.ndarray]]]:
    """The attributes of a file of a RowFile, and its variables (n_rows,), in the variables' units.

    Each variable is a Column, with its full name, and its values in all complete rows. Cells are
    given as the values that they stand for, as by `Recorded.stored`. InputError if the file is cut
    off, or has more values than are read.
    """
    with path.open("rb", buffering=0) as file:
        begin = int.from_bytes(_read(file, BEGIN_AT + len(BEGIN_NAME) + 12, 8), "big")
        _check_length(path, file, begin)
        count, attributes, columns, kinds = Header(bytes(_read(file, 0, begin))).content()
        row = np.dtype([(f"_{k}", f">{kind}", (1,)) for k, kind in enumerate(kinds)])
        _check_length(path, file, begin + count * row.itemsize)
        check_size(path, count, len(columns))
        values = [np.empty(count, kind) for kind in kinds]
        first = 0
        for parts in _blocks(file, row, begin, count):
            last = first + len(parts[0])
            for into, part in zip(values, parts, strict=True):
                into[first:last] = part[:, 0]
            first = last
    lines = str(attributes.pop(TEXTS, "")).split("\n")[:-1]  # one that broke off is in no row
    texts = [json.loads(line) for line in lines]
    found = [
        (column, column.recorded.stored(cells, texts.__getitem__))
        for column, cells in zip(columns, values, strict=True)
    ]
    return attributes, found


def leading_rows(path: Path, sections: Sequence[Section], count: int) -> Iterator[list[np.ndarray]]:
    """Blocks of leading rows: an array (n_rows, n_columns) for each section, in variables' units.

    They are the first `count` of a file of a RowFile. `sections` are all of the file, TIME first.
    ValueError if it has others, or fewer rows.
    """
    with path.open("rb", buffering=0) as file:
        begin = int.from_bytes(_read(file, BEGIN_AT + len(BEGIN_NAME) + 12, 8), "big")
        _check_length(path, file, begin)
        there, _, columns, kinds = Header(bytes(_read(file, 0, begin))).content()
        wanted = [
            (unicodedata.normalize("NFC", f"{s.component}.{c.name}".removeprefix(".")), s.kind)
            for s in sections
            for c in s.columns
        ]
        if wanted != [(c.name, kind) for c, kind in zip(columns, kinds, strict=True)]:
            raise ValueError("it has other variables")
        if there < count:
            raise ValueError(f"{count} rows, and it has {there}")
        row = _row(sections)
        _check_length(path, file, begin + count * row.itemsize)
        yield from _blocks(file, row, begin, count)


def check_size(path: Path, count: int, columns: int) -> None:
    """InputError if so many rows of so many columns are not read."""
    if count * columns > MOST_RESULTS:
        message = f"has {count} rows of {columns} values; {MOST_RESULTS:,} values are read at most"
        raise InputError.single(message, SMALLER, str(path))


def _check_length(path: Path, file: FileIO, length: int) -> None:
    found = os.fstat(file.fileno()).st_size
    if found < length:
        message = f"is cut off: it has {found} bytes of {length}"
        raise InputError.single(message, "copy it again, or run again", str(path))


def _blocks(file: FileIO, row: np.dtype, begin: int, count: int) -> Iterator[list[np.ndarray]]:
    most = max(1, READ // row.itemsize)
    for first in range(0, count, most):
        size = min(most, count - first) * row.itemsize
        rows = np.frombuffer(_read(file, begin + first * row.itemsize, size), row)
        yield [rows[name] for name in row.names or ()]


def _read(file: FileIO, place: int, size: int) -> bytearray:
    """So many bytes from `place` on; fewer where the file ends."""
    data = bytearray(min(size, max(0, os.fstat(file.fileno()).st_size - place)))
    view, done = memoryview(data), 0
    file.seek(place)
    while got := file.readinto(view[done:]):
        done += got
    return data
