"""Free points that come out of the water."""

from __future__ import annotations

from pathlib import Path

from support.lines_in_waves import started

from m4e_adapters.moordyn import ready_mooring

STILL = [(0.0, 0.0)]


def test_a_buoy_is_told_once_when_it_rises() -> None:
    path = Path(__file__).parents[3] / "data" / "moordyn" / "buoy_between_lines.txt"
    lines = started(ready_mooring(path, fairleads={}))
    lines.start([(100.0, -150.0)], STILL)  # pulled below
    assert not any("above the water" in text for text in lines.warnings)
    for k in range(40):
        lines.advance(0.5 * k, 0.5, [(100.0, -150.0 + 3.5 * k)], [(0.0, 7.0)])
    for k in range(40, 80):
        lines.advance(0.5 * k, 0.5, [(100.0, -10.0)], STILL)
    assert len(lines.surfaced()) == 1
    assert lines.surfaced() == []
    lines.close()
