"""Wrong URDF files, and word for word what is said about each: urdf_errors.txt.

Each is a good file with one thing changed. `pytest --update` writes the messages anew.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.golden import check_messages, refused

from m4e_fmi.model import load_model

GOLDEN = Path(__file__).with_name("urdf_errors.txt")
GOOD = (Path(__file__).parents[1] / "data" / "robots" / "many_joints.urdf").read_text("utf-8")
HINGE = '<joint name="hinge" type="revolute">'
TOOL = '<link name="tool"/>'
TOOL_ON_CRANK = '<parent link="crank"/><child link="tool"/>'
CASES = {
    "not XML": ("</robot>", ""),
    "another root": (GOOD, '<?xml version="1.0"?>\n<sdf name="many joints"/>\n'),
    "macros": ('xyz="0.1 0 0.2"', 'xyz="${l} 0 0.2"'),
    "three words": ('xyz="0.1 0 0.2"', 'xyz="0.1 0"'),
    "no number": ('xyz="0.1 0 0.2"', 'xyz="0.1 0 a"'),
    "not finite": ('<mass value="0.7"/>', '<mass value="nan"/>'),
    "no mass": ('<mass value="0.7"/>', ""),
    "negative mass": ('<mass value="0.7"/>', '<mass value="-0.7"/>'),
    "massless link that moves": ('<mass value="0.7"/>', '<mass value="0"/>'),
    "moments that no body has": ('ixx="0.01" iyy="0.02" izz="0.015"', 'ixx="1" iyy="2" izz="9"'),
    "no value": ('<mass value="0.7"/>', "<mass/>"),
    "unknown type": (HINGE, HINGE.replace("revolute", "revolut")),
    "no type": (HINGE, '<joint name="hinge">'),
    "mimic": (HINGE, f'{HINGE}<mimic joint="turn" multiplier="2"/>'),
    "unknown link": ('<parent link="wheel"/>', '<parent link="weel"/>'),
    "no parent": ('<parent link="wheel"/>', ""),
    "two parents": (TOOL_ON_CRANK, '<parent link="tool"/><child link="crank"/>'),
    "a loop": ('<parent link="world"/>', '<parent link="crank"/>'),
    "a link that hangs on nothing": (TOOL, f'{TOOL}<link name="spare"/>'),
    "two links of a name": (TOOL, f'{TOOL}<link name="rail"/>'),
    "names that become the same": ('"strap"', '"slide-"'),
    "no axis": ('<axis xyz="1 2 3"/>', '<axis xyz="0 0 0"/>'),
    "negative damping": (HINGE, f'{HINGE}<dynamics damping="-1"/>'),
    "a base that floats on a link": (HINGE, HINGE.replace("revolute", "floating")),
}  # fmt: skip


def test_messages(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    def message(change: tuple[str, str]) -> str:
        return refused(tmp_path / "robot.urdf", GOOD, dict([change]), load_model)

    check_messages(GOLDEN, CASES, message, request)
