"""Runs in real time: points at their wall time, lateness, Ctrl-C in a wait."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time as clock
from pathlib import Path

import numpy as np
import pytest
from support.interrupted import differences
from support.small_systems import Fmus, oscillator

from m4e_fmi.cosim import Network, Simulation, load, run
from m4e_fmi.errors import InputError
from m4e_fmi.report.text.summaries import run_summary

NO_ESTIMATE = "what is run in real time is not repeated"


def test_no_point_comes_before_its_time(c_fmu: Fmus, tmp_path: Path) -> None:
    walls: list[tuple[float, float]] = []

    def seen(time: float, _: Network) -> None:
        walls.append((time, clock.perf_counter()))

    given = oscillator(c_fmu, Simulation(2.0, 0.01))
    outcome = run(given, real_time=4.0, results=tmp_path / "paced.nc", observers=[seen])
    times, passed = np.array(walls).T
    assert (passed - passed[0] - times / 4.0 > -0.005).all()  # the first may be a little late
    lateness = outcome.real_time
    assert lateness is not None
    assert (lateness.factor, lateness.points) == (4.0, 201)
    assert 0.0 <= lateness.mean <= lateness.largest < 0.4
    assert not lateness.is_slow
    assert NO_ESTIMATE in str(outcome.certificate)
    assert "4 × real time" in run_summary(outcome)
    found, free = outcome.results(), run(given, results=tmp_path / "free.nc").results()
    assert found.attributes["real_time"] == str(lateness)
    assert all(np.array_equal(found[n].values, free[n].values) for n in free.series)


def test_a_run_that_is_too_slow_goes_on_and_says_so(c_fmu: Fmus) -> None:
    def slow(_: float, __: Network) -> None:
        clock.sleep(0.03)

    outcome = run(oscillator(c_fmu, Simulation(0.1, 0.01)), real_time=1.0, observers=[slow])
    lateness = outcome.real_time
    assert lateness is not None
    assert lateness.late == 10
    assert 0.15 < lateness.last == lateness.largest < 2.0
    assert "too slow" in str(lateness)


@pytest.mark.parametrize("last", [None, 50.0])
def test_a_run_of_which_a_part_was_in_real_time_has_no_estimate(
    c_fmu: Fmus, tmp_path: Path, last: float | None
) -> None:
    given = oscillator(c_fmu, Simulation(1.0, 0.01, checkpoint_interval=0.5), "+state+bytes")
    place = tmp_path / "r.nc"
    first = run(given, real_time=50.0, results=place)
    middle = run(given.changed(stop_time=2.0), results=place, resume=True)
    assert NO_ESTIMATE in str(middle.certificate)
    assert middle.real_time is None
    told = f"{first.real_time}, up to t = 1 s"
    assert load(place).attributes["real_time"] == told
    outcome = run(given.changed(stop_time=3.0), real_time=last, results=place, resume=True)
    assert NO_ESTIMATE in str(outcome.certificate)
    lines = load(place).attributes["real_time"].splitlines()
    more = [f"from t = 2 s on: {outcome.real_time}"] if last else []
    assert lines == [f"{told}, up to t = 2 s", *more]
    run(given.changed(stop_time=3.0), results=tmp_path / "whole.nc")
    other = {name.partition("@")[2] for name in differences(tmp_path / "whole.nc", place)}
    assert other == {"coupling_error", "coupling_error_from", "real_time", "record_end"}


def test_what_is_made_again_does_not_wait(c_fmu: Fmus, tmp_path: Path) -> None:
    """These FMUs cannot save their states, so the first 20 s are made again, at once."""
    given = oscillator(c_fmu, Simulation(20.0, 0.01, checkpoint_interval=5.0), "+state")
    place = tmp_path / "r.nc"
    run(given, real_time=1000.0, results=place)
    began = clock.perf_counter()
    again = run(given.changed(stop_time=20.5), real_time=1.0, results=place, resume=True)
    assert clock.perf_counter() - began < 10.0
    assert again.real_time is not None
    assert again.real_time.points == 51


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
def test_ctrl_c_ends_a_wait(c_fmu: Fmus) -> None:
    began = clock.perf_counter()
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        run(oscillator(c_fmu, Simulation(1000.0, 100.0)), real_time=1.0)
    assert clock.perf_counter() - began < 10.0


@pytest.mark.parametrize("factor", [0.0, float("nan"), float("inf")])
def test_factors_that_are_none(c_fmu: Fmus, factor: float) -> None:
    with pytest.raises(InputError, match="real time factor"):
        run(oscillator(c_fmu, Simulation(1, 0.1)), real_time=factor)
