"""Start values in the range that an FMU declares."""

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.units import parse_unit


def variable(low: float, high: float) -> Variable:
    return Variable(
        name="period",
        value_reference=0,
        type="Real",
        offset=0.0,
        derivative_of=None,
        causality="parameter",
        variability="fixed",
        initial="exact",
        unit="s",
        dimension=parse_unit("s"),
        description="made for 9 s",
        minimum=low,
        maximum=high,
    )


def test_values_within_the_range_are_taken() -> None:
    for given in (7.2, 9, 11.25, "8000 ms"):
        assert value_of(variable(7.2, 11.25), given) == pytest.approx(
            8.0 if isinstance(given, str) else given, rel=1e-15
        )


@pytest.mark.parametrize(
    ("low", "high", "given", "told"),
    [
        (7.2, 11.25, 16.0, "the FMU's range is 7.2 to 11.25 s (made for 9 s)"),
        (7.2, 11.25, "7000 ms", "the FMU's range is 7.2 to 11.25 s (made for 9 s)"),
        (0.0, math.inf, -1, "the FMU's range is 0 s or more (made for 9 s)"),
        (-math.inf, 0.0, 1.0, "the FMU's range is 0 s or less (made for 9 s)"),
    ],
)
def test_values_outside_are_an_error_with_both_numbers(
    low: float, high: float, given: float | str, told: str
) -> None:
    with pytest.raises(ValueError, match="the FMU's range is") as caught:
        value_of(variable(low, high), given)
    assert str(caught.value) == told


@pytest.mark.parametrize(
    ("kind", "given", "taken"),
    [
        ("Real", np.float32(0.5), 0.5),
        ("Real", np.int64(9), 9),
        ("Real", Fraction(1, 2), 0.5),
        ("Integer", np.int32(9), 9),
        ("Boolean", np.bool_(True), True),
    ],
)
def test_numbers_of_other_libraries_are_taken(kind: str, given: Any, taken: float) -> None:
    found = value_of(replace(variable(-math.inf, math.inf), type=kind), given)
    assert found == taken
    assert type(found) is type(taken)


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("Integer", np.float64(9)),
        ("Integer", np.bool_(True)),
        ("Real", np.bool_(True)),
        ("Real", np.float32("nan")),
        ("Real", Fraction(10**400)),
        ("Boolean", np.int64(1)),
    ],
)
def test_numbers_of_another_type_are_not_taken(kind: str, given: Any) -> None:
    with pytest.raises(ValueError, match=r"it is of type|finite"):
        value_of(replace(variable(-math.inf, math.inf), type=kind), given)
