"""Names of ours for names in the files of other programs."""

from __future__ import annotations

import re

from m4e_fmi.model.elements import GROUND


def identifier(name: str) -> str:
    """A name of ours for any name: letters, digits and _, a letter first, never `ground`."""
    text = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
    if not text or not text[0].isalpha():
        text = f"n{text}"
    return f"{text}_body" if text == GROUND else text
