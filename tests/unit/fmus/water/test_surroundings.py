"""Water, waves, current and gravity that differ between components are told, with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML
from support.described import described

from m4e_fmi.cosim import load_system
from m4e_fmi.cosim.wiring.links import Link, Port, Wiring
from m4e_fmus.water.surroundings import differing

GIVEN: dict[str, Any] = YAML(typ="safe").load(Path(__file__).with_name("surroundings.yaml"))
LINK = Link(Port("hydro", "float.force_z"), Port("buoy", "body.float.force_z"), 0)
BUOY = described("buoy", ("g", "parameter", "m/s2"), ("body.float.force_z", "input", "N"))
CASES = [(group, case) for group in GIVEN for case in GIVEN[group]["cases"]]


@pytest.mark.parametrize(("group", "case"), CASES, ids=str)
def test_what_differs_is_told(group: str, case: dict[str, Any], tmp_path: Path) -> None:
    texts = dict(GIVEN[group]["files"])
    for old, new in case.get("change", {}).items():
        (name,) = (name for name, text in texts.items() if old in text)
        assert texts[name].count(old) == 1
        texts[name] = texts[name].replace(old, new)
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    links, fmus = ((LINK,), {"buoy": BUOY}) if group == "water" else ((), {})
    lines = differing(load_system(tmp_path / "system.yaml"), fmus, Wiring(links, (), (), ()))
    expected = case.get("told", [])
    assert len(lines) == len(expected)
    assert all(text in line for line, text in zip(lines, expected, strict=True))
