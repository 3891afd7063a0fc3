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
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.recorded import REAL, Recorded

ROWS_BEGIN, ENDED = "rows_begin", "ended"
NOT_ENDED = "not yet: the run goes on, or its process was killed"
"""The attribute `ended` until the file is told otherwise."""
CELLS = "i8"
"""The kind of cells: whole numbers, Booleans, and the places of texts."""
TEXTS = "texts"
_ENDED_LENGTH = 1024
_TEXTS_LENGTH = 2**16
_MAGIC = b"CDF\x05"
_COUNT_AT = len(_MAGIC)
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_CHAR, _TYPES = 2, {"i4": 4, "f8": 6, "i8": 10}
_KINDS = {number: kind for kind, number in _TYPES.items()}
READ = 2**24
"""Bytes of rows that are read at once, about."""


@dataclass(frozen=True)
class Column:
    """What one variable of results is."""

    name: str
    unit: str
    long_name: str
    recorded: Recorded = REAL

    @property
    def told(self) -> dict[str, str]:
        """Its attributes in a file of rows."""
        found = {"units": self.unit, "long_name": self.long_name}
        one = self.recorded
        more = {"type": one.type, "kind": one.kind, "items": json.dumps(dict(one.items))}
        return found if one.is_real else found | more


@dataclass(frozen=True)
class Section:
    """Columns of one `component` that are of one `kind`: f8, i4, i8; CELLS if not Real."""

    component: str
    columns: tuple[Column, ...]
    kind: str = "f8"
    attributes: Mapping[str, str] = field(default_factory=dict)


TIME = Section("", (Column("time", "s", "simulated time"),))
"""The first section of every file."""


class RowFile:
    """A file of rows of `sections`, TIME before them, that is being written at `path`.

    `count` is the number of rows that can be read. Every method raises OSError if the disk does
    not take what it writes; the rows that there are can be read then.
    """

    def __init__(
        self, path: Path, sections: Sequence[Section], attributes: Mapping[str, str | int]
    ) -> None:
        self.path, self.count = path, 0
        self.sections = (TIME, *sections)
        self.dtype = _row(self.sections)
        header, self._ended_at, self._texts_at = _header(self.sections, attributes)
        self._texts = 0
        self._begin = len(header)
        self._file = path.open("w+b", buffering=0)
        self._put(0, header)

    def move(self, path: Path) -> None:
        """Go on at `path`, in the same folder, in place of what is there."""
        self._file.close()  # Windows moves no open file
        self.path.replace(path)
        self.path = path
        self._file = path.open("r+b", buffering=0)

    def append(self, first: int, parts: Sequence[np.ndarray]) -> None:
        """Write rows from row `first` on, which may be before the end: later rows are given up.

        `parts` are arrays (rows, columns), one for each section. OSError if the disk does not take
        all of them; those that it took can be read then.
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

    def keep_texts(self, texts: Sequence[str]) -> None:
        """Keep what the cells of texts stand for, before rows with them are written.

        There is room for 64 KiB; only the netCDF-4 file, at the end, has what is more.
        """
        if not self._texts_at or len(texts) == self._texts:
            return
        data, self._texts = b"[", len(texts)
        for place in range(len(texts)):
            more = json.dumps(texts[place], ensure_ascii=False).encode()
            if len(data) + len(more) + 2 > _TEXTS_LENGTH:
                break
            data += b"," * (place > 0) + more
        self._put(self._texts_at, (data + b"]").ljust(_TEXTS_LENGTH))

    def cut(self, count: int) -> None:
        """Give up all rows but the first `count`."""
        if count < self.count:
            self._commit(count)

    def end(self, text: str) -> None:
        """Say how the run has ended."""
        self._put(self._ended_at, _fixed(text))
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file; it can be moved and replaced then, on Windows too."""
        self._file.close()

    @property
    def closed(self) -> bool:
        return self._file.closed

    def blocks(self) -> Iterator[list[np.ndarray]]:
        """The rows that can be read, some at a time: an array (rows, columns) for each section.

        They can be read after `close`, too.
        """
        with self.path.open("rb", buffering=0) as file:
            yield from _blocks(file, self.dtype, self._begin, self.count)

    def _commit(self, count: int) -> None:
        os.fsync(self._file.fileno())
        self._put(_COUNT_AT, count.to_bytes(8, "big"))
        self.count = count

    def _put(self, place: int, data: Any) -> None:
        view = memoryview(data).cast("B")
        self._file.seek(place)
        while view:
            view = view[self._file.write(view) :]


def _row(sections: Sequence[Section]) -> np.dtype:
    """One row of a file; all its types have four or eight bytes, so that there are no gaps."""
    return np.dtype([(f"_{k}", f">{s.kind}", (len(s.columns),)) for k, s in enumerate(sections)])


def _fixed(text: str) -> bytes:
    return text.encode()[:_ENDED_LENGTH].decode(errors="ignore").encode().ljust(_ENDED_LENGTH)


def _header(
    sections: Sequence[Section], attributes: Mapping[str, str | int]
) -> tuple[bytes, int, int]:
    """The header of a file without rows, and where in it ENDED and TEXTS (0: not there) begin."""
    with_texts = any(c.recorded.is_text for section in sections for c in section.columns)
    room = {TEXTS: b"[]".ljust(_TEXTS_LENGTH)} if with_texts else {}
    rest = {**attributes, **room, ENDED: _fixed(NOT_ENDED)}
    begin = 0
    for _ in range(2):  # where the rows begin is in it, too
        dimension = _list(_DIMENSIONS, [_name("time") + _big(0)])
        head = _MAGIC + _big(0) + dimension + _attributes({ROWS_BEGIN: begin, **rest})
        data = head + _list(_VARIABLES, list(_variables(sections, begin)))
        begin = len(data)
    ended = len(head) - _ENDED_LENGTH
    before = len(_name(ENDED)) + 12  # its name, type and length
    return data, ended, ended - before - _TEXTS_LENGTH if with_texts else 0


def _variables(sections: Sequence[Section], begin: int) -> Iterator[bytes]:
    for section in sections:
        prefix = f"{section.component}." if section.component else ""
        size = np.dtype(section.kind).itemsize
        for column in section.columns:
            told = {**column.told, **section.attributes}
            yield (
                _name(prefix + column.name) + _big(1) + _big(0) + _attributes(told)
                + _big(_TYPES[section.kind], 4) + _big(size) + _big(begin)
            )  # fmt: skip
            begin += size


def _attributes(attributes: Mapping[str, str | int | bytes]) -> bytes:
    found = []
    for name, value in attributes.items():
        if isinstance(value, int):
            found.append(_name(name) + _big(_TYPES["i8"], 4) + _big(1) + _big(value))
        else:
            data = value.encode() if isinstance(value, str) else value
            found.append(_name(name) + _big(_CHAR, 4) + _counted(data))
    return _list(_ATTRIBUTES, found)


def _list(tag: int, elements: Sequence[bytes]) -> bytes:
    return _big(tag, 4) + _big(len(elements)) + b"".join(elements)


def _name(name: str) -> bytes:
    return _counted(unicodedata.normalize("NFC", name).encode())


def _counted(data: bytes) -> bytes:
    return _big(len(data)) + data + bytes(-len(data) % 4)


def _column(name: str, told: Mapping[str, str | int]) -> Column:
    recorded = REAL
    if "type" in told:
        items = json.loads(str(told["items"]))
        recorded = Recorded(str(told["type"]), str(told["kind"]), items)
    return Column(name, str(told["units"]), str(told["long_name"]), recorded)


def _big(value: int, size: int = 8) -> bytes:
    return value.to_bytes(size, "big")


_BEGIN_NAME = _name(ROWS_BEGIN)
_BEGIN_AT = len(_MAGIC) + 8 + len(_list(_DIMENSIONS, [_name("time") + _big(0)])) + 12
"""Where the first attribute of a file is."""


def is_row_file(path: Path) -> bool:
    """Whether the file at `path` begins as those that RowFile writes; OSError if none is there."""
    with path.open("rb") as file:
        head = file.read(_BEGIN_AT + len(_BEGIN_NAME))
    return head.startswith(_MAGIC) and head.endswith(_BEGIN_NAME)


def read_rows(path: Path) -> tuple[dict[str, str | int], list[tuple[Column, np.ndarray]]]:
    """The attributes of a file that RowFile writes or has written, and its variables.

    Cells are there as the values that they stand for, as `Recorded.stored`.

    Each is a Column, with its full name, and the values in all rows that are complete: (rows,).
    InputError if the file is cut off.
    """
    with path.open("rb", buffering=0) as file:
        begin = int.from_bytes(_read(file, _BEGIN_AT + len(_BEGIN_NAME) + 12, 8), "big")
        _check_length(path, file, begin)
        count, attributes, columns, kinds = _Header(_read(file, 0, begin)).content()
        row = np.dtype([(f"_{k}", f">{kind}", (1,)) for k, kind in enumerate(kinds)])
        _check_length(path, file, begin + count * row.itemsize)
        values = [np.empty(count, kind) for kind in kinds]
        first = 0
        for parts in _blocks(file, row, begin, count):
            last = first + len(parts[0])
            for into, part in zip(values, parts, strict=True):
                into[first:last] = part[:, 0]
            first = last
    texts = dict(enumerate(json.loads(str(attributes.pop(TEXTS, "[]")))))
    found = [
        (column, column.recorded.stored(cells, lambda k: texts.get(k, f"({k}th text: lost)")))
        for column, cells in zip(columns, values, strict=True)
    ]
    return attributes, found


class _Header:
    """Reads what `_header` writes, from its beginning to its end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, len(_MAGIC)

    def content(self) -> tuple[int, dict[str, str | int], list[Column], list[str]]:
        """Number of rows, attributes, the variables and their kinds."""
        count = self._number()
        for _ in self._list():
            self._text()
            self._number()
        attributes = self._attributes()
        attributes[ENDED] = str(attributes[ENDED]).rstrip()
        del attributes[ROWS_BEGIN]
        columns, kinds = [], []
        for _ in self._list():
            name = self._text()
            for _ in range(self._number()):
                self._number()
            told = self._attributes()
            columns.append(_column(name, told))
            kinds.append(_KINDS[self._number(4)])
            self._number()
            self._number()
        return count, attributes, columns, kinds

    def _attributes(self) -> dict[str, str | int]:
        found: dict[str, str | int] = {}
        for _ in self._list():
            name = self._text()
            if self._number(4) == _CHAR:
                found[name] = self._text()
            else:
                self._number()
                found[name] = self._number()
        return found

    def _list(self) -> range:
        self._number(4)
        return range(self._number())

    def _number(self, size: int = 8) -> int:
        self._place += size
        return int.from_bytes(self._data[self._place - size : self._place], "big")

    def _text(self) -> str:
        length = self._number()
        data = self._data[self._place : self._place + length]
        self._place += length + -length % 4
        return data.decode()


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
