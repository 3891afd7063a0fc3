"""The writer of results: which of its rows in memory are the last ones of the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare
from m4e_fmi.cosim.master.master import Master
from m4e_fmi.cosim.results.writer import LEAST_ROWS, ResultsWriter

Fmus = Callable[[str], Path]


@pytest.mark.parametrize("back", [10, 30, 63, 70])
def test_recent_rows_are_of_the_present_course(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, back: int
) -> None:
    """The run goes back to its row `back` when a block of rows is full, and half of the next."""
    monkeypatch.setattr("m4e_fmi.cosim.results.writer.MOST_ROWS", LEAST_ROWS)
    system = System("s", (Component("a", FmuFile(c_fmu("mass"))),), (), Simulation(1.0, 0.01))
    p = prepare(system)
    with (
        Master(p) as master,
        ResultsWriter(tmp_path / "r.nc", master.network, {}) as writer,
    ):

        def go(first: int, last: int) -> None:
            for time in range(first, last):
                writer.keep(np.array([float(time)]))
                recent, columns = writer.recent(1000)
                count = len(recent)
                assert recent.tolist() == list(range(time + 1 - count, time + 1))
                assert all(len(values) == count for values in columns.values())

        go(0, back)
        mark = writer.mark()
        go(back, 100)
        writer.back(mark)
        go(back, 200)
        assert len(writer.recent(1000)[0]) == LEAST_ROWS
