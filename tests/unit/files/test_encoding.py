"""Values as JSON and raw bytes: what comes back is what went in, and nothing else is taken."""

from __future__ import annotations

import importlib
import json
import math
import os
import pickle
import sys
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, make_dataclass
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from m4e_fmi.errors import Problem
from m4e_fmi.files import encoding
from m4e_fmi.files.encoding import LIVE, DamagedError, Decoder, Encoder


@dataclass(frozen=True)
class Base:
    """A base class without fields."""


@dataclass(frozen=True)
class Derived(Base):
    """A class that is found by its name among those derived."""

    number: int


@dataclass(frozen=True, order=True)
class Key:
    """A key of mappings."""

    name: str


@dataclass(frozen=True)
class Late:
    """One that is checked."""

    time: float

    def check(self) -> None:
        if self.time < 0.0:
            raise ValueError("before the start")


@dataclass
class Whole:
    """One field of each kind."""

    call: Callable[[], int] = field(metadata=LIVE)
    values: np.ndarray
    flags: np.ndarray
    data: bytes
    base: Base
    other: Base
    pairs: Mapping[Key, tuple[float, ...]]
    counts: dict[int, str]
    last: deque[float]
    names: frozenset[Key]
    maybe: np.ndarray | None
    value: float | int | bool | str
    either: int | None


def whole() -> Whole:
    base = Derived(3)
    return Whole(
        call=lambda: 1,
        values=np.array([[0.1, -0.0, math.inf], [math.nan, 5e-324, 1.0]]),
        flags=np.zeros((0, 2), dtype=bool),
        data=b"\x00\xff",
        base=base,
        other=base,
        pairs={Key("a"): (0.1, 1e300), Key("b"): ()},
        counts={2: "two", 1: "ü"},
        last=deque([1.0, 2.5]),
        names=frozenset({Key("x"), Key("y")}),
        maybe=None,
        value=True,
        either=7,
    )


def decoded(data: object, encoder: Encoder, live: Mapping[str, object]) -> Whole:
    blobs = memoryview(b"".join(encoder.blobs))
    return Decoder(blobs).decode(Whole, json.loads(json.dumps(data)), live)


def test_everything_comes_back_with_its_type_and_its_bits() -> None:
    given, encoder = whole(), Encoder()
    found = decoded(encoder.encode(given), encoder, {"call": given.call})
    assert found.values.tobytes() == given.values.tobytes()
    assert found.values.flags.writeable
    assert (found.flags.shape, found.flags.dtype) == ((0, 2), np.dtype(bool))
    alike = [f.name for f in fields(Whole) if f.name not in ("values", "flags")]
    assert {n: getattr(found, n) for n in alike} == {n: getattr(given, n) for n in alike}
    assert type(found.base) is Derived
    assert type(found.value) is bool
    assert list(found.counts) == [2, 1]


def test_an_object_that_is_met_twice_is_one_again() -> None:
    given, encoder = whole(), Encoder()
    found = decoded(encoder.encode(given), encoder, {"call": given.call})
    assert found.base is found.other


def test_what_has_no_form_is_a_mistake_of_the_program() -> None:
    for value in (object(), np.array(["a", "b"], dtype=object), os.system, Path):
        with pytest.raises(TypeError, match="no form"):
            Encoder().encode(value)


def test_a_class_of_another_package_is_taken_if_it_is_derived_from_one_of_ours(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = ModuleType("elsewhere")
    monkeypatch.setitem(sys.modules, "elsewhere", other)
    for base, is_taken in ((Base, True), (object, False)):
        made = make_dataclass("Other", [("number", int)], bases=(base,), frozen=True)
        made.__module__, other.__dict__["Other"] = "elsewhere", made
        encoder = Encoder()
        place = encoder.encode(made(number=3))
        decoder = Decoder(memoryview(encoder.blobs[0]))
        if is_taken:
            assert decoder.decode(Base, place, {}) == made(number=3)
        else:
            with pytest.raises(DamagedError, match=r"elsewhere\.Other is no dataclass of"):
                decoder.decode(Base, place, {})


class Forged:
    """A value that is pickled as a call."""

    def __init__(self, *call: object) -> None:
        self.call = call

    def __reduce__(self) -> tuple[object, ...]:
        return self.call


@pytest.mark.parametrize(
    "value",
    [
        Forged(os.system, ("true",)),
        Forged(eval, ("1",)),
        Forged(importlib.import_module, ("os",)),
        Forged(getattr, ("a", "upper")),
        Forged(Fraction, (1, 2)),
        Forged(Problem, ("of another package",)),
        Forged(encoding._array, ("|O", (1,), bytes(8))),
        Forged(encoding._array, ("<f8", (10**12,), b"")),
        Forged(encoding._array, ("<f8", (-2,), bytes(8))),
        Forged(Derived, (1, 2)),
        Forged(encoding._object, (Derived, {"more": 1}, [])),
        Forged(encoding._object, (Derived, {}, ["number"])),
        Forged(encoding._object, (Late, {"time": -1.0}, [])),
        Derived(1),
        None,
    ],
)
def test_what_a_file_may_not_have_is_refused(value: object) -> None:
    content = pickle.dumps(value)
    for data in ([0, len(content)], [0, len(content) - 1], [0, 0], [-1, 1], "ab", None, [0]):
        with pytest.raises(DamagedError):
            Decoder(memoryview(content)).decode(Whole, data, {})
