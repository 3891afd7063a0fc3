"""Values as JSON and raw bytes: what comes back is what went in, and nothing else is taken."""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields

import numpy as np
import pytest

from m4e_fmi.files.encoding import LIVE, DamagedError, Decoder, Encoder, Json


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


def decoded(data: Json, encoder: Encoder, live: Mapping[str, object]) -> Whole:
    blobs = memoryview(b"".join(bytes(blob) for blob in encoder.blobs))
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
    for value in (object(), np.array(["a"], dtype=object), Key):
        with pytest.raises(TypeError, match="no form"):
            Encoder().encode(value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("values", [1.0]),
        ("values", {"at": 0, "dtype": "|O", "shape": [1]}),
        ("values", {"at": 0, "dtype": "<f8", "shape": [10**12]}),
        ("values", {"at": -8, "dtype": "<f8", "shape": [1]}),
        ("values", {"at": 0, "dtype": "<f8", "shape": [-1]}),
        ("data", {"at": 10**9, "size": 1}),
        ("base", {"class": "Key", "name": "a"}),
        ("base", {"class": "Derived", "number": 1.5}),
        ("base", {"class": "Derived", "number": 1, "more": 2}),
        ("base", {"same": 99}),
        ("counts", {"1": "one"}),
        ("counts", [[1, 2]]),
        ("either", "7"),
        ("either", True),
        ("value", [1]),
    ],
)
def test_what_a_field_cannot_be_is_refused(name: str, value: Json) -> None:
    encoder = Encoder()
    data = encoder.encode(whole())
    data[name] = value
    with pytest.raises(DamagedError):
        decoded(data, encoder, {"call": lambda: 1})
