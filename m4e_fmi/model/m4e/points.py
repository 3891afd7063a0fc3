"""The paper's names of points: "BD10" or "BD1_0", "GR00" or "GR0_0", "CG22" or "CG2_2".

BD is a body's point (body number from 1, index of the point from 0), GR a point of the ground (only
the index counts), CG the centre of gravity of a body (only the body's number counts). The first
spelling is that of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody", section 5.2;
the second, of later versions of their code, is never ambiguous.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

_FORM = re.compile(r"(GR|BD|CG)(\d+)(?:_(\d+))?")


@dataclass(frozen=True)
class PointName:
    """A point of `body` (0: the ground); `index` is None for the centre of gravity."""

    body: int
    index: int | None

    @property
    def name(self) -> str:
        """Its name in a Model: GR0, BD1_0 or CG2."""
        if self.index is None:
            return f"CG{self.body}"
        return f"BD{self.body}_{self.index}" if self.body else f"GR{self.index}"


def point_name(text: object, declared: Collection[PointName], bodies: int) -> PointName:
    """The point that `text` names, of those `declared` or of the CGs of `bodies` bodies.

    ValueError, with a message and a remedy, for an unknown point, and for digits without "_" that
    can be read in more than one way.
    """
    found = _FORM.fullmatch(text) if isinstance(text, str) else None
    if not found:
        remedy = (
            'write "BD1_0" (body 1, point 0), "GR0_0" (ground, point 0) or "CG2_2" (CG, body 2)'
        )
        raise ValueError(f"{text!r} does not name a point", remedy)
    known = {*declared, *(PointName(body, None) for body in range(1, bodies + 1))}
    readings = [name for name in _readings(*found.groups()) if name in known]
    if not readings:
        names = ", ".join(map(_spelled, sorted(declared, key=lambda p: p.name)))
        meant = [_spelled(name) for name in known if name.name == text]  # as models call it
        remedy = f"points: {names or 'none'}; CG of a body"
        remedy = f'did you mean "{meant[0]}"?' if meant else remedy
        raise ValueError(f"there is no point {text!r}", remedy)
    if len(readings) > 1:
        spelled = " or ".join(f'"{_spelled(name)}"' for name in readings)
        raise ValueError(f"{text!r} can be read in several ways", f"write {spelled}")
    return readings[0]


def _readings(kind: str, first: str, second: str | None) -> list[PointName]:
    """Readings of the digits as body and point, whether or not there is such a point."""
    if kind == "GR":  # the digit after GR is the ground's, 0
        index = second if second is not None else first[1:]
        known = index and (second is not None or first[0] == "0")
        return [PointName(0, int(index))] if known else []
    if second is not None:
        splits = [(first, second)]
    else:
        splits = [(first[:k], first[k:]) for k in range(1, len(first))]
    if kind == "CG":  # "CG1212": the body's number twice
        twice = [body for body, other in splits if body == other]
        bodies = twice or [body for body, _ in splits]
        return [PointName(int(body), None) for body in bodies]
    return [PointName(int(body), int(index)) for body, index in splits]


def _spelled(name: PointName) -> str:
    if name.index is None:
        return f"{name.name}_{name.body}"
    return name.name if name.body else f"GR0_{name.index}"
