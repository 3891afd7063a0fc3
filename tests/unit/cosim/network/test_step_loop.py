"""The loop over macro steps: the same bits and the same failures by C and by Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.python_executor import PythonExecutor, use_python

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, load, run
from m4e_fmi.cosim.network.schedule import Schedule
from m4e_fmi.errors import RunError

Fmus = Callable[[str], Path]
Models = Mapping[str, tuple[str, Mapping[str, float]]]
Both = Callable[[Callable[[], Any]], list[Any]]

SYSTEMS: dict[str, tuple[Models, tuple[str, ...]]] = {
    "two masses": (
        {"a": ("mass", {"stiffness": 1.0, "body.m.x": 1.0}), "b": ("partner", {"damping": 0.1})},
        ("a.m <-> b.end",),
    ),
    "moved input": (
        {"b": ("moving_partner", {}), "a": ("mass", {"stiffness": 1.0, "body.m.x": 1.0})},
        ("a.m <-> b.end",),
    ),
    "line": ({"a": ("mass", {"body.m.x": 1.0}), "b": ("line", {})}, ("a.m <-> b.end",)),
    "feed-through": (
        {"c": ("stage", {"gain": 0.5}), "b": ("stage", {"gain": 3.0}), "a": ("stage", {"u": 5.0})},
        ("a.y -> b.u", "b.y -> c.u"),
    ),
    "other units": (
        {"a": ("mass", {"body.m.x": 1.0}), "b": ("mm_spring", {"stiffness": 2e-3})},
        (
            "a.body.m.x -> b.end.x",
            "a.body.m.vx * 0.9 -> b.end.vx",
            "b.end.force_x -> a.body.m.force_x",
        ),
    ),
    "cycle": (
        {"a": ("integrator", {"y": 1.0}), "b": ("integrator", {"gain": -1.0})},
        ("a.y * 1.1 + 0.25 -> b.u", "b.y -> a.u"),
    ),
    "alone": ({"a": ("mass", {"body.m.vx": 1.0})}, ()),
    "own steps": (
        {
            "a": ("mass", {"stiffness": 1.0, "body.m.x": 1.0}),
            "b": ("moving_partner", {}),
            "c": ("integrator", {}),
        },
        ("a.m <-> b.end", "b.x -> c.u, units ignored"),
    ),
}
OWN_STEPS = {"own steps": {"b": "1/300 s", "c": "0.04 s"}}


def made(fmus: Fmus, name: str, simulation: Simulation, options: str = "") -> System:
    models, connections = SYSTEMS[name]
    own = OWN_STEPS.get(name, {})
    parts = tuple(
        Component(n, FmuFile(fmus(m + options)), start, step_size=own.get(n))
        for n, (m, start) in models.items()
    )
    return System("test", parts, connections, simulation)


@pytest.fixture
def both(monkeypatch: pytest.MonkeyPatch) -> Both:
    """`both(what)` does it by the loop in C, and by the one in Python."""

    def done(what: Callable[[], Any]) -> list[Any]:
        first = what()
        use_python(monkeypatch)
        assert isinstance(Schedule(()).executor, PythonExecutor)
        return [first, what()]

    return done


WAYS = [
    ("jacobi", ""),
    ("gauss_seidel", ""),
    ("corrector", "+state"),
    ("corrector", "+state+inputs"),
]


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize(("algorithm", "options"), WAYS)
def test_c_and_python_give_the_same_bits(
    c_fmu: Fmus, tmp_path: Path, both: Both, name: str, algorithm: str, options: str
) -> None:
    # rows at every third step; the last step is shorter, and a row of its own
    settings = Simulation(2.145, 0.01, algorithm, output_interval=0.03)
    system = made(c_fmu, name, settings, options)
    (first, by_c), (second, by_p) = both(
        lambda: (outcome := run(system, results=tmp_path / "r.nc"), outcome.results())
    )
    assert (first.steps, first.energy) == (second.steps, second.energy)
    assert first.certificate == second.certificate
    assert first.steps == 215
    np.testing.assert_array_equal(by_c.time, by_p.time)
    np.testing.assert_array_equal(by_c.time, [*(3 * k / 100 for k in range(72)), 2.145])
    for variable, series in by_c.series.items():
        np.testing.assert_array_equal(series.values, by_p[variable].values)
        assert np.abs(series.values).max() > 0 or (name, variable) == ("alone", "a.body.m.ax")


@pytest.mark.parametrize(("algorithm", "options"), WAYS)
def test_observing_changes_no_bit(c_fmu: Fmus, algorithm: str, options: str) -> None:
    system = made(c_fmu, "two masses", Simulation(2.0, 0.01, algorithm), options)
    seen: list[float] = []

    def observe(time: float, network: Network) -> None:
        seen.append(time)
        assert network.time == time
        assert all(instance.time == time for instance in network.instances.values())

    watched: Outcome = run(system, observers=[observe])
    assert seen == [k / 100 for k in range(201)]
    alone = run(system)
    assert watched.energy == alone.energy
    assert watched.certificate == alone.certificate


@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
@pytest.mark.parametrize("interval", [0.01, 0.05])
def test_a_discarded_step_among_many_is_made_again(
    c_fmu: Fmus, tmp_path: Path, both: Both, options: str, interval: float
) -> None:
    source = Component("a", FmuFile(c_fmu(f"switch{options}")), {"when": 1.2345})
    integral = Component("b", FmuFile(c_fmu(f"integrator{options}")))
    settings = Simulation(2.0, 0.01, output_interval=interval)
    system = System("test", (source, integral), ("a.y -> b.u",), settings)

    def values() -> np.ndarray:
        outcome = run(system, results=tmp_path / "r.nc")
        results = outcome.results()
        # one step more, which is no row of its own; then points are where they would have been
        assert (outcome.steps, outcome.rejected) == (201, 1)
        count = round(2 / interval)
        np.testing.assert_array_equal(results.time, 2 * np.arange(count + 1) / count)
        return results["b.y"].values

    one, other = both(values)
    np.testing.assert_array_equal(one, other)
    late = 2.0 - 1.2345
    # straight lines on either side of the kink, which is met to a nanosecond
    exact = 1.2345**2 / 2 + 1.2345 * late - late**2 / 2
    assert one[-1] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("what", [2, 3, 4, 9])
def test_failures_are_the_same(c_fmu: Fmus, tmp_path: Path, both: Both, what: int) -> None:
    """At a step in the midst of those that are made at once."""
    parts = (
        Component("body", FmuFile(c_fmu("mass")), {}),
        Component("pump", FmuFile(c_fmu("rogue")), {"what": float(what), "when": 0.77}),
        Component("next", FmuFile(c_fmu("stage")), {}),
    )
    system = System("test", parts, ("pump.y -> next.u",), Simulation(2.0, 0.01))

    def told() -> tuple[str, str]:
        with pytest.raises(RunError) as caught:
            run(system, results=tmp_path / "r.nc")
        np.testing.assert_array_equal(load(tmp_path / "r.nc").time, np.arange(77) / 100)
        return caught.value.message, caught.value.remedy

    one, other = both(told)
    assert one == other
    assert "pump" in one[0]
    assert "0.77 s" in one[0]
