"""Members that are told of, and their wet lengths."""

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


HULL = "bodies: {hull: {center_of_gravity: [0, 0]}}\n"
LEG = "{ends: [[0, -9], [0, 2]], diameter: 1, drag: 1"


def told(text: str) -> list[str]:
    lines: list[str] = []
    morison_program(config(text), name="legs", folder=Path(), progress=lines.append)
    return lines


def test_doubts_are_told() -> None:
    waves = "waves: {spectrum: regular, height: 0.1, period: 1.6}\ncurrent: {speed: 1}\n"
    lines = told(f"{waves}members: {{leg: {LEG}}}}}")
    assert any("no Doppler shift" in line for line in lines)
    assert any("holds up to 0.2 of their length" in line for line in lines)
    heavy = told(f"{HULL}members: {{leg: {LEG}, body: hull}}}}")
    assert any("count twice" in line for line in heavy)
    light = f"{HULL}members: {{leg: {LEG}, body: hull, added_mass: 0, inertia: 0}}}}"
    assert told(light) == []
    made = morison_program(config(light), name="legs", folder=Path(), progress=silent)
    assert not any("added_mass" in v.name for v in made.outputs)


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
