"""Types of numbers that several keys share, such as positive ones."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BeforeValidator, Field

DEEP = "deep"
AUTO = "auto"


def _depth(value: object) -> object:
    return math.inf if value == DEEP else value


def _order(value: object) -> object:
    return None if value == AUTO else value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
"""A place [m]; the squares of such numbers are finite."""
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Depth = Annotated[Annotated[float, Field(gt=0)], BeforeValidator(_depth)]
Order = Annotated[Annotated[int, Field(ge=1, le=16)] | None, BeforeValidator(_order)]
Place = tuple[Coordinate, ...]
"""[x, z], or [x, y, z] where `dimensions` is 3."""
