"""Texts that FMUs give and take, each kept once, so that a number stands for it."""

from __future__ import annotations

import ctypes
from ctypes import c_char_p, c_int64, c_uint64, c_void_p
from weakref import finalize

from m4e_fmi.runtime.library import library


class _RawTexts(ctypes.Structure):
    """`m4e_texts`."""

    _fields_ = [
        ("texts", c_void_p),
        ("slots", c_void_p),
        ("count", c_uint64),
        ("room", c_uint64),
        ("size", c_uint64),
    ]


class Texts:
    """Different texts (UTF-8), each at its place; the empty one at 0. They are kept as this is."""

    def __init__(self) -> None:
        self._library = found = library()
        self._kept: list[ctypes.Array[ctypes.c_char]] = []
        self._places: dict[bytes, int] = {}
        self._raw = _RawTexts()
        if found is not None:
            found.m4e_text_place.argtypes = ctypes.POINTER(_RawTexts), c_char_p
            found.m4e_text_place.restype = c_int64
            found.m4e_text_at.argtypes = ctypes.POINTER(_RawTexts), c_int64
            found.m4e_text_at.restype = c_void_p
            finalize(self, found.m4e_texts_free, ctypes.byref(self._raw))
        self.place(b"")

    @property
    def address(self) -> int:
        """That of the C structure."""
        return ctypes.addressof(self._raw)

    def place(self, text: bytes) -> int:
        """Where the text is; it is added if it is not there yet."""
        if self._library is not None:
            place = self._library.m4e_text_place(self._raw, text)
            if place < 0:
                raise MemoryError
            return place
        if text not in self._places:
            self._places[text] = len(self._kept)
            self._kept.append(ctypes.create_string_buffer(text))
        return self._places[text]

    def pointer(self, place: int) -> int:
        """The address of a text, which ends with a zero."""
        if self._library is not None:
            return self._library.m4e_text_at(self._raw, place)
        return ctypes.addressof(self._kept[place])

    def content(self) -> tuple[bytes, ...]:
        """All texts, by their places."""
        return tuple(ctypes.string_at(self.pointer(place)) for place in range(len(self)))

    def __len__(self) -> int:
        return int(self._raw.count) if self._library is not None else len(self._kept)

    def __getitem__(self, place: int) -> str:
        return ctypes.string_at(self.pointer(place)).decode("utf-8", errors="replace")
