"""Dimensions of expressions, and of coordinates; mistakes of units are in tests/corpus."""

from __future__ import annotations

from pathlib import Path

import pytest

from m4e_fmi.errors import InputError
from m4e_fmi.model import load_model

UNITS = {
    "m": "kg", "L": "cm", "k": "kN/m", "c": "N.s/m", "F": "N", "J": "kg.m2", "w": "rpm",
    "phi": "deg", "kt": "N.m/rad", "n": "1", "g": "m/s2", "share": "%",
}  # fmt: skip
SPACE = """name: d
dimensions: 3
parameters:
{parameters}
bodies: {{b: {{mass: m, inertia: [1, 1, 1]}}}}
joints: {{pin: {{type: {kind}, child: b, axis: [0, 0, 1]{more}}}}}
loads:
  load: {load}
"""
KINDS = {"cylindrical": "", "planar": ", direction: [1, 0, 0]"}


def in_space(folder: Path, kind: str, load: str) -> Path:
    path = folder / "d.model.yaml"
    parameters = "\n".join(f"  {n}: {{value: 0.5, unit: {u!r}}}" for n, u in UNITS.items())
    path.write_text(
        SPACE.format(parameters=parameters, kind=kind, more=KINDS[kind], load=load), "utf-8"
    )
    return path


@pytest.mark.parametrize(
    ("kind", "slide", "turn"), [("cylindrical", "q1", "q2"), ("planar", "q2", "q3")]
)
def test_units_follow_the_coordinate_of_a_joint_with_several(
    tmp_path: Path, kind: str, slide: str, turn: str
) -> None:
    right = (
        ("joint_effort", slide, "effort: F"),
        ("joint_effort", turn, "effort: F*L"),
        ("joint_friction", slide, "effort: F, velocity: L*w"),
        ("joint_friction", turn, "effort: F*L, velocity: w"),
        ("joint_stop", slide, "stiffness: k, upper: L"),
        ("joint_stop", turn, "stiffness: kt, upper: phi"),
    )
    for load, along, numbers in right:
        text = f"{{type: {load}, joint: pin, along: {along}, {numbers}}}"
        assert load_model(in_space(tmp_path, kind, text)).loads
        other = turn if along == slide else slide
        with pytest.raises(InputError, match="expected") as caught:
            load_model(in_space(tmp_path, kind, text.replace(along, other)))
        assert len(caught.value.problems) == numbers.count(":")
