"""Units: what is understood, what it is in SI, what is refused."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from m4e_fmi.units import BASE_UNITS, Unit, parse_unit


def exponents(**powers: int) -> tuple[int, ...]:
    return tuple(powers.get(base, 0) for base in BASE_UNITS)


@pytest.mark.parametrize(
    ("text", "powers", "factor"),
    [
        ("1", {}, 1.0),
        ("kg", {"kg": 1}, 1.0),
        ("t", {"kg": 1}, 1e3),
        ("g", {"kg": 1}, 1e-3),
        ("mm", {"m": 1}, 1e-3),
        ("km", {"m": 1}, 1e3),
        ("min", {"s": 1}, 60.0),
        ("kn", {"m": 1, "s": -1}, 1852 / 3600),
        ("kN", {"kg": 1, "m": 1, "s": -2}, 1e3),
        ("MPa", {"kg": 1, "m": -1, "s": -2}, 1e6),
        ("N.s/m", {"kg": 1, "s": -1}, 1.0),
        ("N.m/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}, 1.0),
        ("m/s2", {"m": 1, "s": -2}, 1.0),
        ("m/s^2", {"m": 1, "s": -2}, 1.0),
        ("m.s-2", {"m": 1, "s": -2}, 1.0),
        ("1/(m.s)", {"m": -1, "s": -1}, 1.0),
        ("deg", {"rad": 1}, math.pi / 180),
        ("deg2", {"rad": 2}, (math.pi / 180) ** 2),
        ("rpm", {"rad": 1, "s": -1}, math.pi / 30),
        ("kg/mm2", {"kg": 1, "m": -2}, 1e6),
        ("%", {}, 0.01),
        ("1/s", {"s": -1}, 1.0),
        ("daN", {"kg": 1, "m": 1, "s": -2}, 10.0),
        ("hN", {"kg": 1, "m": 1, "s": -2}, 100.0),
        ("dm", {"m": 1}, 0.1),
        ("nm", {"m": 1}, 1e-9),
        ("kNm", {"kg": 1, "m": 2, "s": -2}, 1e3),
        ("Nm/rad", {"kg": 1, "m": 2, "s": -2, "rad": -1}, 1.0),
        ("kN*m", {"kg": 1, "m": 2, "s": -2}, 1e3),
        ("mbar", {"kg": 1, "m": -1, "s": -2}, 100.0),
        ("kWh", {"kg": 1, "m": 2, "s": -2}, 3.6e6),
        ("L/min", {"m": 3, "s": -1}, 1e-3 / 60),
        ("deg/s", {"rad": 1, "s": -1}, math.pi / 180),
        ("ft", {"m": 1}, 0.3048),
        ("in2", {"m": 2}, 0.0254**2),
        ("lb", {"kg": 1}, 0.45359237),
        ("lbf", {"kg": 1, "m": 1, "s": -2}, 4.4482216152605),
        ("lbf.ft", {"kg": 1, "m": 2, "s": -2}, 4.4482216152605 * 0.3048),
        ("kip", {"kg": 1, "m": 1, "s": -2}, 4448.2216152605),
        ("slug", {"kg": 1}, 4.4482216152605 / 0.3048),
        ("psi", {"kg": 1, "m": -1, "s": -2}, 4.4482216152605 / 0.0254**2),
        ("psf", {"kg": 1, "m": -1, "s": -2}, 4.4482216152605 / 0.3048**2),
        ("mph", {"m": 1, "s": -1}, 0.44704),
        ("nmi", {"m": 1}, 1852.0),
        ("kOhm", {"kg": 1, "m": 2, "s": -3, "A": -2}, 1e3),
    ],
)
def test_exponents_and_factor(text: str, powers: dict[str, int], factor: float) -> None:
    unit = parse_unit(text)
    assert unit.exponents == exponents(**powers)
    # a handful of roundings in products of decimal factors
    assert unit.factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("m²", "m2"),
        ("kg·m²", "kg.m2"),
        ("kg*m^2", "kg.m2"),
        ("m/s⁻¹", "m/s-1"),
        ("\u00b5m", "um"),
        ("\u03bcm", "um"),  # the Greek letter looks the same
        ("°", "deg"),
    ],
)
def test_spellings_of_one_unit(one: str, other: str) -> None:
    assert parse_unit(one).exponents == parse_unit(other).exponents
    assert parse_unit(one).factor == parse_unit(other).factor


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("furlong", "'furlong'"),
        ("N/m/s", "more than one '/'"),
        ("", "''"),
        ("kg.", "''"),
        ("m s", "'m s'"),
        ("2m", "'2m'"),
        ("N.furlong", "'furlong'"),
        ("m**2", "''"),
        ("kkg", "'kkg'"),
        ("Th", "'Th'"),
        ("da", "'da'"),
        ("furlong", "known: kg, m, s,"),
        ("furlong", "Wh"),
        ("furlong", "prefixes T, G, M, k, h, da, d, c, m"),
    ],
)
def test_refused_with_the_part_that_is_not_understood(text: str, part: str) -> None:
    with pytest.raises(ValueError, match="unit") as caught:
        parse_unit(text)
    assert part in str(caught.value)


@pytest.mark.parametrize("moment", ["N.m", "Nm", "kN.m", "m.N"])
@pytest.mark.parametrize("energy", ["J", "MJ", "Wh", "kW.h", "W.s"])
def test_a_moment_is_no_energy(moment: str, energy: str) -> None:
    """Though both are kg.m2/s2, which is either."""
    one, other, either = map(parse_unit, (moment, energy, "kg.m2/s2"))
    assert not one.same_dimension(other)
    assert one.difference(other) == "a moment is not an energy"
    assert other.difference(one) == "an energy is not a moment"
    assert one.same_dimension(either)
    assert other.same_dimension(either)
    assert parse_unit(f"{moment}/rad").same_dimension(parse_unit(f"{energy}/rad"))


def test_dimension_and_not_spelling_decides() -> None:
    assert parse_unit("N").same_dimension(parse_unit("kg.m/s2"))
    assert parse_unit("deg").same_dimension(parse_unit("rad"))
    assert not parse_unit("N.m").same_dimension(parse_unit("N.m/rad"))
    assert not parse_unit("Hz").same_dimension(parse_unit("rad/s"))


@pytest.mark.parametrize(
    ("text", "si"),
    [("kN", "kg.m/s2"), ("t", "kg"), ("deg", "rad"), ("%", "1"), ("rpm", "rad/s"), ("1/h", "1/s")],
)
def test_coherent_unit_of_the_same_dimension(text: str, si: str) -> None:
    assert parse_unit(text).si_text == si


@pytest.mark.parametrize(
    ("text", "coherent"),
    [
        ("kN/m", "N/m"), ("MN/m", "N/m"), ("kN.s/mm2", "N.s/m2"), ("mm", "m"), ("kNm", "Nm"),
        ("t", "kg"), ("g.mm2", "kg.m2"), ("bar", "Pa"), ("daN", "N"), ("N.m/deg", "N.m/rad"),
        ("rpm", "rad/s"), ("kN/%", "kg.m/s2"), ("L/min", "m3/s"), ("°", "rad"),
    ],
)  # fmt: skip
def test_coherent_unit_is_spelled_as_the_given_one(text: str, coherent: str) -> None:
    assert parse_unit(text).coherent_text == coherent


@given(st.tuples(*[st.integers(-4, 4)] * len(BASE_UNITS)))
def test_si_text_of_any_dimension_parses_to_itself(powers: tuple[int, ...]) -> None:
    text = Unit("made", powers).si_text
    assert parse_unit(text) == Unit(text, powers, 1.0)
