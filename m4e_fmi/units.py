"""Units: FMI's base-unit exponents and the factor to SI, from a unit's text.

Grammar: factors joined by ``.`` ``*`` or ``·``, at most one ``/`` (all after it divides), an
exponent as ``m2``, ``m^2`` or ``m²``; ``1`` is no unit. Prefixes from T to p; what is a unit itself
is no other one with a prefix (min, cd, Pa). ``Nm`` is N.m, ``Wh`` is W.h.
Source of the factors: the SI brochure, 9th edition; of customary units, which take no prefix, NIST
Special Publication 811 (2008), appendix B: the international foot and pound.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_PREFIXES = {
    "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 1e1, "d": 1e-1, "c": 1e-2, "m": 1e-3,
    "µ": 1e-6, "u": 1e-6, "n": 1e-9, "p": 1e-12,
}  # fmt: skip
SPELLINGS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻·*\u03bc\u2126", "0123456789-..\u00b5\u03a9")
"""Other characters of units, and those that stand for them here."""
_SYMBOL = re.compile(r"[A-Za-zµ°%Ω]+")
_FACTOR = re.compile(rf"({_SYMBOL.pattern})\^?(-?\d+)?$")


POWER = "W"
"""Unit of outputs that are powers."""
LONGEST_UNIT = 100
"""Characters of a unit's text; those of physics have up to 20."""
LARGEST_EXPONENT = 20
"""Size of an exponent in a unit's text; those of physics are up to 6."""


@dataclass(frozen=True)
class Unit:
    """A unit: SI value = `factor` × value in this unit. Exponents follow BASE_UNITS."""

    text: str
    exponents: tuple[int, ...]
    factor: float = 1.0

    def same_dimension(self, other: Unit) -> bool:
        """True if values in one unit can be converted to the other: see `difference`."""
        return not self.difference(other)

    def difference(self, other: Unit) -> str:
        """Why values in this unit cannot be converted to the other; empty if they can.

        A moment and an energy are of one dimension, and told apart by their units' names; units
        such as kg.m2/s2 may be of both.
        """
        if self.exponents != other.exponents:
            return f"{self.si_text} is not {other.si_text}"
        if {self._named, other._named} == {"a moment", "an energy"}:
            return f"{self._named} is not {other._named}"
        return ""

    @property
    def _named(self) -> str:
        """The quantity that the text names, of the two in kg.m2/s2; empty for neither or others."""
        if self.exponents != _NAMED["J"][0]:
            return ""
        symbols = _SYMBOL.findall(self.text)
        if any(symbol.endswith(("J", "W", "Wh")) for symbol in symbols):
            return "an energy"
        return "a moment" if any(symbol.endswith(("N", "Nm")) for symbol in symbols) else ""

    @property
    def si_text(self) -> str:
        """The coherent SI unit of the same dimension, spelled in base units."""
        up = [_power(b, e) for b, e in zip(BASE_UNITS, self.exponents, strict=True) if e > 0]
        down = [_power(b, -e) for b, e in zip(BASE_UNITS, self.exponents, strict=True) if e < 0]
        return (
            (".".join(up) or "1")
            + (f"/({'.'.join(down)})" if len(down) > 1 else "")
            + (f"/{down[0]}" if len(down) == 1 else "")
        )

    @property
    def coherent_text(self) -> str:
        """The same, spelled like this unit where that is possible: N/m of kN/m."""
        told = _WORD.sub(lambda word: _coherent(word[0]), self.text)
        try:
            same = parse_unit(told)
        except ValueError:
            return self.si_text
        alike = same.factor == 1.0 and same.same_dimension(self)
        return told if alike else self.si_text


def _coherent(word: str) -> str:
    """A unit without prefix, in place of one that has a prefix or another factor."""
    if word not in _NAMED:
        word = word[2 if word.startswith("da") else 1 :]
    return _COHERENT.get(word, word)


def _power(base: str, exponent: int) -> str:
    return base if exponent == 1 else f"{base}{exponent}"


def _exponents(**powers: int) -> tuple[int, ...]:
    return tuple(powers.get(base, 0) for base in BASE_UNITS)


_NAMED: dict[str, tuple[tuple[int, ...], float]] = {
    **{base: (_exponents(**{base: 1}), 1.0) for base in BASE_UNITS},
    "g": (_exponents(kg=1), 1e-3),
    "t": (_exponents(kg=1), 1e3),
    "N": (_exponents(kg=1, m=1, s=-2), 1.0),
    "Nm": (_exponents(kg=1, m=2, s=-2), 1.0),
    "Pa": (_exponents(kg=1, m=-1, s=-2), 1.0),
    "bar": (_exponents(kg=1, m=-1, s=-2), 1e5),
    "J": (_exponents(kg=1, m=2, s=-2), 1.0),
    "W": (_exponents(kg=1, m=2, s=-3), 1.0),
    "Wh": (_exponents(kg=1, m=2, s=-2), 3600.0),
    "Hz": (_exponents(s=-1), 1.0),
    "V": (_exponents(kg=1, m=2, s=-3, A=-1), 1.0),
    "C": (_exponents(A=1, s=1), 1.0),
    "Ohm": (_exponents(kg=1, m=2, s=-3, A=-2), 1.0),
    "Ω": (_exponents(kg=1, m=2, s=-3, A=-2), 1.0),
    "L": (_exponents(m=3), 1e-3),
    "l": (_exponents(m=3), 1e-3),
    "min": (_exponents(s=1), 60.0),
    "h": (_exponents(s=1), 3600.0),
    "deg": (_exponents(rad=1), math.pi / 180),
    "°": (_exponents(rad=1), math.pi / 180),
    "rev": (_exponents(rad=1), 2 * math.pi),
    "rpm": (_exponents(rad=1, s=-1), 2 * math.pi / 60),
    "kn": (_exponents(m=1, s=-1), 1852 / 3600),
    "%": (_exponents(), 0.01),
}
FOOT, POUND, GRAVITY = 0.3048, 0.45359237, 9.80665
"""The foot [m], the pound [kg] and the standard acceleration of gravity [m/s²], all exact."""
_POUND_FORCE = POUND * GRAVITY
_LENGTH, _FORCE, _PRESSURE = _exponents(m=1), *(_NAMED[name][0] for name in ("N", "Pa"))
_CUSTOMARY: dict[str, tuple[tuple[int, ...], float]] = {
    "in": (_LENGTH, FOOT / 12),
    "ft": (_LENGTH, FOOT),
    "yd": (_LENGTH, 3 * FOOT),
    "mi": (_LENGTH, 5280 * FOOT),
    "nmi": (_LENGTH, 1852.0),
    "lb": (_exponents(kg=1), POUND),
    "slug": (_exponents(kg=1), _POUND_FORCE / FOOT),
    "lbf": (_FORCE, _POUND_FORCE),
    "kip": (_FORCE, 1e3 * _POUND_FORCE),
    "kgf": (_FORCE, GRAVITY),
    "psi": (_PRESSURE, _POUND_FORCE / (FOOT / 12) ** 2),
    "ksi": (_PRESSURE, 1e3 * _POUND_FORCE / (FOOT / 12) ** 2),
    "psf": (_PRESSURE, _POUND_FORCE / FOOT**2),
    "mph": (_exponents(m=1, s=-1), 5280 * FOOT / 3600),
}
_NAMED |= _CUSTOMARY
_COHERENT = {
    "g": "kg", "t": "kg", "lb": "kg", "slug": "kg",
    "lbf": "N", "kip": "N", "kgf": "N",
    "bar": "Pa", "psi": "Pa", "ksi": "Pa", "psf": "Pa",
    "in": "m", "ft": "m", "yd": "m", "mi": "m", "nmi": "m",
    "deg": "rad", "°": "rad", "rev": "rad",
}  # fmt: skip
_WORD = re.compile(r"[A-Za-zµ°%Ω]+")
_BARE = {"kg", "min", "h", "kn", "%", *_CUSTOMARY}
"""Units that take no prefix."""
KNOWN = f"{', '.join(_NAMED)}, with the prefixes {', '.join(_PREFIXES)}"
"""All units and prefixes, for messages."""
TOO_LARGE = "the number is too large: write one below 1.8e308, in SI units"


@dataclass(frozen=True)
class Quantity:
    """A number with its unit; `offset` is what the unit adds after the factor (temperatures)."""

    value: float
    unit: Unit
    offset: float = 0.0

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit.text}"

    @property
    def si_number(self) -> str:
        """The number in SI units, in 12 digits; empty if that is not finite."""
        number = self.value * self.unit.factor
        return f"{number:.12g}" if math.isfinite(number) else ""

    def in_unit(self, unit: Unit, offset: float = 0.0) -> float:
        """The number in `unit`; ValueError if that is of another dimension."""
        if not self.unit.same_dimension(unit):
            raise ValueError(f"it is in {unit.text}: {self.unit.difference(unit)}")
        shift = (self.offset - offset) / unit.factor
        return self.value * (self.unit.factor / unit.factor) + shift


def parse_quantity(text: str) -> Quantity:
    """The quantity in a text such as ``"5 mm"``; ValueError for any other text."""
    number, _, unit = text.strip().partition(" ")
    try:
        value = float(number)
    except ValueError:
        message = f"{number!r} is not a number; a unit may follow after a space, as in '5 mm'"
        raise ValueError(message) from None
    return Quantity(value, parse_unit(unit.strip() or "1"))


def number_in(unit: str, given: float | str) -> float:
    """`given` as a number in `unit`: a number is in it already, a text has a unit of its own.

    ValueError for a text that is not a quantity, or of another dimension.
    """
    if isinstance(given, str | bool):
        return parse_quantity(str(given)).in_unit(parse_unit(unit))
    return float(given)


@cache
def parse_unit(text: str) -> Unit:
    """The unit that `text` names; ValueError with the part that is not understood."""
    if len(text) > LONGEST_UNIT:
        raise ValueError(f"unit {text[:LONGEST_UNIT]!r}…: units have up to {LONGEST_UNIT} letters")
    exponents = [0] * len(BASE_UNITS)
    factor = 1.0
    upper, *lower = text.translate(SPELLINGS).split("/")
    if len(lower) > 1:
        raise ValueError(f"unit {text!r}: more than one '/'; write m/(s.kg) as m/s.kg")
    for part, direction in ((upper, 1), (lower[0] if lower else "1", -1)):
        for piece in part.strip("() ").split("."):
            if piece.strip() == "1":
                continue
            powers, scale = _factor(piece.strip(), text)
            factor *= scale**direction
            exponents = [e + direction * p for e, p in zip(exponents, powers, strict=True)]
    if not 0.0 < factor < math.inf:
        raise ValueError(f"unit {text!r}: its factor is out of all scale")
    return Unit(text, tuple(exponents), factor)


def _factor(piece: str, text: str) -> tuple[tuple[int, ...], float]:
    match = _FACTOR.match(piece)
    if not match:
        raise ValueError(f"unit {text!r}: {piece!r} is not a unit")
    symbol, digits = match[1], match[2] or "1"
    power = int(digits) if len(digits) < 5 else LARGEST_EXPONENT + 1
    if abs(power) > LARGEST_EXPONENT:
        raise ValueError(f"unit {text!r}: exponents are up to {LARGEST_EXPONENT}")
    scale = 1.0
    if symbol not in _NAMED:
        length = 2 if symbol.startswith("da") else 1
        scale, symbol = _PREFIXES.get(symbol[:length], 0.0), symbol[length:]
    if symbol not in _NAMED or not scale or (scale != 1.0 and symbol in _BARE):
        raise ValueError(f"unit {text!r}: {match[1]!r} is not a unit known here; known: {KNOWN}")
    powers, own = _NAMED[symbol]
    return tuple(power * e for e in powers), (scale * own) ** power
