"""Units in the configurations of kinds."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator

from m4e_fmi.files.document import rejected
from m4e_fmi.units import parse_unit


def _known(text: object) -> str:
    try:
        parse_unit(str(text))
    except ValueError as error:
        raise rejected(str(error), "write it like N.s/m or kg.m2") from None
    return str(text)


KnownUnit = Annotated[str, BeforeValidator(_known)]
"""The text of a unit that is understood: ``N.s/m``, ``mm``, ``1``."""
