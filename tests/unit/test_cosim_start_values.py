"""Start values in the range that an FMU declares."""

import math

import pytest

from m4e_fmi.cosim.start_values import value_of
from m4e_fmi.fmu.reading import Variable
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
