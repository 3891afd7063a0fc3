"""The table of joint types, and the table of the docs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from m4e_fmi.joints import JOINT_TYPES

PAGE = Path(__file__).parents[3] / "docs" / "model_files.md"


ALL = [joint_type for table in JOINT_TYPES.values() for joint_type in table.values()]


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_docs_have_a_row_for_every_type_with_its_start_keys(dimensions: int) -> None:
    page = PAGE.read_text("utf-8")
    space = page.index("## Models in space")
    part = page[:space] if dimensions == 2 else page[space:]
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", part, re.MULTILINE)
    told = {name: set(re.findall(r"`(\w+)`", keys)) for name, keys in rows}
    types = JOINT_TYPES[dimensions]
    expected = {name: set(joint_type.start_keys) for name, joint_type in types.items()}
    assert {name: told.get(name) for name in expected} == expected


@pytest.mark.parametrize("dimensions", [2, 3])
def test_names_of_types_mean_one_type_each(dimensions: int) -> None:
    types = JOINT_TYPES[dimensions]
    others = [other for joint_type in types.values() for other in joint_type.other_names]
    assert len({*others, *types}) == len(others) + len(types)
    assert all(joint_type.name == name for name, joint_type in types.items())


def test_every_planar_type_is_one_of_space_too() -> None:
    assert {*JOINT_TYPES[2]} < {*JOINT_TYPES[3]}


def test_angles_come_last() -> None:
    """Which the topology and the recursion rely on."""
    for joint_type in ALL:
        angles = [c.is_angle for c in joint_type.coordinates]
        assert angles == sorted(angles)
        assert joint_type.turns == tuple(sorted(joint_type.turns))
        assert not joint_type.frees_rotation or joint_type.turns[-1]
