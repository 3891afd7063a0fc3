"""The table of joint types, and the table of the docs."""

from __future__ import annotations

import re
from pathlib import Path

from m4e_fmi.joints import JOINT_TYPES

PAGE = Path(__file__).parents[3] / "docs" / "model_files.md"


def test_the_docs_have_a_row_for_every_type_with_its_start_keys() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE.read_text("utf-8"), re.MULTILINE)
    told = {name: set(re.findall(r"`(\w+)`", keys)) for name, keys in rows}
    expected = {name: set(joint_type.start_keys) for name, joint_type in JOINT_TYPES.items()}
    assert {name: told.get(name) for name in expected} == expected


def test_names_of_types_mean_one_type_each() -> None:
    others = [other for joint_type in JOINT_TYPES.values() for other in joint_type.other_names]
    assert len({*others, *JOINT_TYPES}) == len(others) + len(JOINT_TYPES)
    assert all(joint_type.name == name for name, joint_type in JOINT_TYPES.items())


def test_the_only_angle_is_the_last_coordinate() -> None:
    """Which the topology and the recursion rely on."""
    for joint_type in JOINT_TYPES.values():
        assert not any(c.is_angle for c in joint_type.coordinates[:-1])
        assert not joint_type.frees_rotation or joint_type.coordinates[-1].is_angle
