"""Wet lengths of members."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from support.hulls import silent
from support.programs import Evaluated

from m4e_adapters.morison import MorisonConfig, morison_program
from m4e_fmi.files.document import Document


def config(text: str) -> MorisonConfig:
    return Document.parse(text).validate(MorisonConfig)


def test_a_member_is_wet_up_to_the_surface() -> None:
    """Still water: none above, all below, and a horizontal one in proportion to its section."""

    def wet_length(ends: str) -> float:
        text = f"members: {{leg: {{ends: {ends}, diameter: 2, drag: 1}}}}"
        made = morison_program(config(text), name="legs", folder=Path(), progress=silent)
        return Evaluated(made).outputs({})["leg.wet_length"]

    assert wet_length("[[0, -9], [0, 4]]") == pytest.approx(9.0, abs=1e-5)
    assert wet_length("[[0, 4], [0, -9]]") == pytest.approx(9.0, abs=1e-5)
    assert wet_length("[[0, -9], [0, -4]]") == pytest.approx(5.0)
    assert wet_length("[[0, 9], [0, 4]]") == 0.0
    for z, share in ((1.2, 0.0), (0.5, 0.25), (0.0, 0.5), (-0.5, 0.75), (-3.0, 1.0)):
        assert wet_length(f"[[0, {z}], [10, {z}]]") == pytest.approx(10 * share, abs=1e-4)
    assert wet_length("[[0, -6], [8, 6]]") == pytest.approx(math.hypot(8, 12) / 2, rel=1e-2)
