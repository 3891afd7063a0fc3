"""Header of a file of rows, its content and place: see `row_file`."""

from __future__ import annotations

import json
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from m4e_fmi.results.recorded import KINDS, REAL, Recorded

ROWS_BEGIN, CLOSING, TEXTS, ENDED = "rows_begin", "closing", "texts", "ended"
"""The first and the last attributes: where rows begin, others that are known at the end (JSON),
texts by lines, how the run ended.
"""
NOT_ENDED = "not yet: the run goes on, or its process was killed"
"""The attribute `ended` until the file is told otherwise."""
CELLS = "i8"
"""The kind of cells: whole numbers, Booleans, and the places of texts."""
_ENDED_LENGTH = 1024
CLOSING_LENGTH = 8192
"""Bytes of the text of CLOSING."""
MAGIC = b"CDF\x05"
"""The first bytes of a file."""
COUNT_AT = len(MAGIC)
"""Where the number of rows is."""
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_CHAR, _TYPES = 2, {"f8": 6, "i8": 10}
_KINDS = {number: kind for kind, number in _TYPES.items()}


@dataclass(frozen=True)
class Column:
    """Name and properties of one variable of results."""

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
    """Columns of one `component` that are of one `kind`: f8 for Reals, CELLS for all else."""

    component: str
    columns: tuple[Column, ...]
    kind: str = "f8"
    attributes: Mapping[str, str] = field(default_factory=dict)


class Numbered(Protocol):
    """Texts by their places, from 0 on; they keep them."""

    def __len__(self) -> int: ...
    def __getitem__(self, place: int, /) -> str: ...


TIME = Section("", (Column("time", "s", "simulated time"),))
"""The first section of every file."""


def fixed(text: str) -> bytes:
    """The bytes of a text, cut or filled with blanks to the length of `ended`."""
    return text.encode()[:_ENDED_LENGTH].decode(errors="ignore").encode().ljust(_ENDED_LENGTH)


def closed(attributes: Mapping[str, str]) -> bytes:
    """The text of CLOSING; without the longest of these attributes where they do not fit."""
    kept = dict(sorted(attributes.items(), key=lambda one: len(one[1])))
    while len(text := json.dumps(kept).encode()) > CLOSING_LENGTH:
        kept.popitem()
    return text.ljust(CLOSING_LENGTH)


def header(
    sections: Sequence[Section], attributes: Mapping[str, str | int], room: int
) -> tuple[bytes, int]:
    """The header of a file without rows, and where in it the text of ENDED begins.

    If there is `room` [bytes] for texts, they are just before ENDED; CLOSING is before both.
    """
    texts = {TEXTS: bytes(room).replace(b"\0", b" ")} if room else {}
    rest = {**attributes, CLOSING: closed({}), **texts, ENDED: fixed(NOT_ENDED)}
    dimension = _list(_DIMENSIONS, [_name("time") + _big(0)])

    def made(begin: int) -> tuple[bytes, bytes]:
        head = MAGIC + _big(0) + dimension + _attributes({ROWS_BEGIN: begin, **rest})
        return head, _list(_VARIABLES, list(_variables(sections, begin)))

    begin = sum(map(len, made(0)))  # which is in it, too
    head, variables = made(begin)
    return head + variables, len(head) - _ENDED_LENGTH


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
        recorded = Recorded(str(told["type"]), str(told["kind"]), dict(items))
        if recorded.kind not in KINDS:
            raise ValueError("its header names an unknown type")
    return Column(name, str(told["units"]), str(told["long_name"]), recorded)


def _big(value: int, size: int = 8) -> bytes:
    return value.to_bytes(size, "big")


ENDED_BEFORE = len(_name(ENDED)) + 12
"""Bytes of the name, type and length of ENDED."""
TEXTS_BEFORE = len(_name(TEXTS)) + 12
"""The same of TEXTS."""
BEGIN_NAME = _name(ROWS_BEGIN)
BEGIN_AT = len(MAGIC) + 8 + len(_list(_DIMENSIONS, [_name("time") + _big(0)])) + 12
"""Where the first attribute of a file is."""


class Header:
    """Reads what `header` writes, from its beginning to its end; ValueError where it is damaged."""

    def __init__(self, data: bytes) -> None:
        self._data, self._place = data, len(MAGIC)

    def content(self) -> tuple[int, dict[str, str | int], list[Column], list[str]]:
        """Number of rows, attributes, the variables and their kinds."""
        try:
            return self._content()
        except (KeyError, TypeError, AttributeError, RecursionError) as error:
            raise ValueError("its header is damaged") from error

    def _content(self) -> tuple[int, dict[str, str | int], list[Column], list[str]]:
        count = self._number()
        for _ in self._list():
            self._text()
            self._number()
        attributes = self._attributes()
        attributes[ENDED] = str(attributes[ENDED]).rstrip()
        attributes.update(json.loads(str(attributes.pop(CLOSING, "{}"))))
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
        if not columns:
            raise ValueError("its header names no variables")
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
        self._advance(size)
        return int.from_bytes(self._data[self._place - size : self._place], "big")

    def _text(self) -> str:
        length = self._number()
        data = self._data[self._place : self._place + length]
        self._advance(length + -length % 4)
        return data.decode()

    def _advance(self, size: int) -> None:
        self._place += size
        if self._place > len(self._data):
            raise ValueError("its header ends early")
