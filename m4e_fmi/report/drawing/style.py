"""Colours that all pictures share."""

from __future__ import annotations

COLOURS = ("#1f5f8b", "#d1495b", "#2a9d8f", "#e9a23b", "#6c5b9e", "#5b6770")
BODY_COLOURS = (*COLOURS, "#8d5a3b", "#7c8c2c")
INK, GREY, GRID, PAPER = "#22303c", "#7b8794", "#e6eaee", "#ffffff"
FORCE = "#c8322b"


def pale(colour: str) -> tuple[float, float, float]:
    """The same colour, for areas: a quarter of it on white."""
    parts = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
    red, green, blue = (0.28 * part + 0.72 for part in parts)
    return red, green, blue
