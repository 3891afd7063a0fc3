"""Steps that are made again for the coupling error leave no trace in the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run, start
from m4e_fmi.cosim.error_estimate import step_doubling
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
    with start(pair(c_fmu)) as execution:
        straight = [point["a.body.m.x"] for point in execution]
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
