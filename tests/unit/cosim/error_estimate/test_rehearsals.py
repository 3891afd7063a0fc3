"""Steps that are made again for the coupling error leave no trace in the run."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run, start
from m4e_fmi.cosim.error_estimate import step_doubling
from m4e_fmi.cosim.error_estimate.coverage import Coverage
from m4e_fmi.cosim.error_estimate.kinks import NOISE, rougher
from m4e_fmi.cosim.error_estimate.repeated_steps import Recorded, RepeatedRun
from m4e_fmi.cosim.master.master import Master

Fmus = Callable[[str], Path]


def pair(fmus: Fmus) -> System:
    a = Component("a", FmuFile(fmus("mass+state")), {"body.m.x": 1.0, "stiffness": 1.0})
    b = Component("b", FmuFile(fmus("partner+state")))
    return System("s", (a, b), ("a.m <-> b.end",), Simulation(4.0, 0.05))


def test_an_interrupted_rehearsal_leaves_the_run_where_it_is(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step_doubling, "FIRST", 20)
    straight = [point["a.body.m.x"] for point in _points(pair(c_fmu))]
    usual, calls = RepeatedRun.along, []

    def interrupted(self: RepeatedRun, *arguments: object) -> Recorded:
        calls.append(1)
        found = usual(self, *arguments)  # type: ignore[arg-type]
        if len(calls) == 1:
            raise KeyboardInterrupt
        return found

    monkeypatch.setattr(RepeatedRun, "along", interrupted)
    found = []
    with start(pair(c_fmu)) as execution:
        found.append(execution["a.body.m.x"])
        while not execution.done:
            try:
                execution.step()
            except KeyboardInterrupt:  # before the step, which can be made then
                assert len(calls) == 1
                continue
            found.append(execution["a.body.m.x"])
    assert calls
    assert found == straight
    assert str(execution.outcome.certificate) == str(run(pair(c_fmu)).certificate)


def _points(system: System) -> list[dict[str, float]]:
    with start(system) as execution:
        return [{"a.body.m.x": point["a.body.m.x"]} for point in execution]


def test_a_signal_ends_a_rehearsal(c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_doubling, "FIRST", 20)
    usual = RepeatedRun._steps
    steps = []

    def slow(self: RepeatedRun, *arguments: object) -> np.ndarray:
        steps.append(1)
        if len(steps) == 3:
            signal.raise_signal(signal.SIGINT)
        return usual(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(RepeatedRun, "_steps", slow)
    monkeypatch.setattr(RepeatedRun, "_loop", None)
    with pytest.raises(KeyboardInterrupt):
        run(pair(c_fmu))
    assert len(steps) == 3


def test_a_kink_in_the_first_steps_of_a_stretch_counts() -> None:
    values = np.zeros((40, 1))
    values[:, 0] = np.sin(0.05 * np.arange(40))
    for step in range(5):
        kinked = values + np.where(np.arange(40) > step, 0.3, 0.0)[:, None]
        run = Recorded(np.arange(40), kinked)
        assert len(rougher(np.array([step]), run, NOISE * run.largest))


def test_what_could_not_be_followed_is_said_with_its_beginning() -> None:
    coverage = Coverage(0, 0).lose(3_000_000_000, "steps fail")
    assert "kinks are not followed from t = 3 s on: steps fail" in str(coverage)


def test_delayed_switches_are_the_same_with_and_without_rehearsals(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(step_doubling, "FIRST", 3)
    parts = tuple(
        Component(name, FmuFile(c_fmu("kinds+state")), {"period": 0.3} if name == "a" else {})
        for name in "ab"
    )
    links = ("a.y_bool -> b.u_bool, delayed", "a.y_real -> b.u_real")
    ready = prepare(System("s", parts, links, Simulation(1.5, 0.1, "jacobi")))
    courses: list[list[float]] = []
    for certify in (True, False):
        with Master(ready, certify=certify) as master:
            last: list[float] = []
            master.run(observers=[lambda _, network, last=last: last.append(network.last)])
        courses.append(last)
    assert courses[0] == courses[1]
    assert courses[0].count(0.0) >= 6  # at a switch, and a step later


def test_adaptive_steps_tell_of_switches(c_fmu: Fmus) -> None:
    parts = tuple(
        Component(name, FmuFile(c_fmu("kinds+state")), {"period": 0.731} if name == "a" else {})
        for name in "ab"
    )
    links = ("a.y_bool -> b.u_bool", "a.y_real -> b.u_real")
    settings = Simulation(1.2, 0.1, "jacobi", coupling_tolerance=1e-3)
    with start(System("s", parts, links, settings)) as execution:
        for _ in execution:
            pass
        switches = execution._master._time_loop.switches
    assert switches.count >= 1
