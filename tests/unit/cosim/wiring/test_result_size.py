"""How large results become: what is told, and when rows are thinned."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.cosim.wiring.prepared import HUGE, LARGE, thinned

Fmus = Callable[[str], Path]
COLUMNS = 4  # of a mass: time, x, vx, ax


@pytest.mark.parametrize(
    ("bytes_", "interval", "told", "every"),
    [
        (0.99 * LARGE, None, "", None),
        (1.1 * LARGE, None, "1.1 GB; a longer output_interval", None),
        (1.5 * HUGE, 0.001, "3.0 GB; a longer output_interval", 1),
        (11 * HUGE, None, "a row is written every 50 steps, 440 MB", 50),
    ],
)
def test_what_is_told_and_done(
    bytes_: float, interval: float | None, told: str, every: int | None
) -> None:
    steps = round(bytes_ / 8 / COLUMNS)
    settings = Simulation(steps * 0.001, 0.001, output_interval=interval)
    found, text = thinned(settings, COLUMNS)
    assert told in text
    assert bool(text) == bool(told)
    assert found.output_interval == (every and pytest.approx(every * 0.001, rel=1e-12))
    adaptive = replace(settings, output_interval=None, coupling_tolerance=1e-4)
    found, text = thinned(adaptive, COLUMNS)
    assert found == adaptive
    assert ("at least" in text) == (bytes_ > LARGE)


def test_a_thinned_run_says_so(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = Component("body", FmuFile(c_fmu("mass")), {"body.m.x": 1.0, "body.m.vx": 0.5})
    system = System("s", (body,), (), Simulation(1.0, 0.01))
    every = run(system, results=tmp_path / "all.nc").results()
    monkeypatch.setattr("m4e_fmi.cosim.wiring.prepared.HUGE", 101 * 8 * COLUMNS - 1)
    monkeypatch.setattr("m4e_fmi.cosim.wiring.prepared.LARGE", 51 * 8 * COLUMNS)
    told: list[str] = []
    outcome = run(system, results=tmp_path / "some.nc", tell=told.append)
    results = outcome.results()
    np.testing.assert_array_equal(results.time, every.time[::2])
    name = "body.body.m.x"
    assert results[name].values.tolist() == every[name].values[::2].tolist()
    (line,) = told
    assert "a row is written every 2 steps" in line
    assert line in outcome.notes
    assert results.attributes["notes"] == line
    assert line in str(prepare(system))
    intervals = [one.attributes["output_interval"] for one in (every, results)]
    assert intervals == ["every step", "0.02 s"]
