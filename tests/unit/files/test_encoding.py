"""Values as bytes: what comes back is what went in, and no code of others is run for it."""

from __future__ import annotations

import importlib
import math
import os
import pickle
from collections.abc import Mapping
from dataclasses import dataclass, fields
from fractions import Fraction
from pathlib import Path
from pickle import UnpicklingError

import numpy as np
import pytest

from m4e_fmi.errors import Problem
from m4e_fmi.files import encoding
from m4e_fmi.files.encoding import decode, encode


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

    values: np.ndarray
    flags: np.ndarray
    data: bytes
    base: Base
    other: Base
    pairs: Mapping[Key, tuple[float, ...]]
    counts: dict[int, str]
    last: list[float]
    names: frozenset[Key]
    maybe: np.ndarray | None
    value: float | int | bool | str
    either: int | None


def whole() -> Whole:
    base = Derived(3)
    return Whole(
        values=np.array([[0.1, -0.0, math.inf], [math.nan, 5e-324, 1.0]]),
        flags=np.zeros((0, 2), dtype=bool),
        data=b"\x00\xff",
        base=base,
        other=base,
        pairs={Key("a"): (0.1, 1e300), Key("b"): ()},
        counts={2: "two", 1: "ü"},
        last=[1.0, 2.5],
        names=frozenset({Key("x"), Key("y")}),
        maybe=None,
        value=True,
        either=7,
    )


def test_everything_comes_back_with_its_type_and_its_bits() -> None:
    given = whole()
    found = decode(Whole, encode(given))
    assert found.values.tobytes() == given.values.tobytes()
    assert found.values.flags.writeable
    assert (found.flags.shape, found.flags.dtype) == ((0, 2), np.dtype(bool))
    alike = [f.name for f in fields(Whole) if f.name not in ("values", "flags")]
    assert {n: getattr(found, n) for n in alike} == {n: getattr(given, n) for n in alike}
    assert type(found.base) is Derived
    assert type(found.value) is bool
    assert list(found.counts) == [2, 1]


def test_an_object_that_is_met_twice_is_one_again() -> None:
    found = decode(Whole, encode(whole()))
    assert found.base is found.other


def test_what_has_no_form_is_a_mistake_of_the_program() -> None:
    for value in (object(), np.array(["a", "b"], dtype=object), os.system, Path):
        with pytest.raises(TypeError, match="no form"):
            encode(value)


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
        Forged(encoding.encode, (1,)),
        Forged(Problem, ("of another package",)),
    ],
)
def test_code_of_others_is_refused(value: object) -> None:
    with pytest.raises(UnpicklingError, match="is no dataclass of"):
        decode(Whole, pickle.dumps(value))


def test_arrays_of_objects_are_refused() -> None:
    """Their bytes would be addresses."""
    forged = Forged(encoding._array, ("|O", (1,), bytes(8)))
    with pytest.raises(ValueError, match="OBJECT"):
        decode(Whole, pickle.dumps(forged))
