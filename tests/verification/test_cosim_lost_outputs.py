"""FMUs that lose their outputs when inputs are set: read earlier, they equal those of others.

Such an FMU shows zeros from the moment when anything is set until it has made its next step. Tools
that read outputs straight after each step, as FMPy does, never see them.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from unit.cosim.preparation.test_dependence import silenced

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Network,
    Simulation,
    System,
    load,
    run,
    start,
)

Fmus = Callable[[str], Path]
OUTPUTS = ("yz.y", "yz.z", "x.x")
"""Of these yz.z is not connected."""


def spiral(fmus: Fmus, options: str, version: str = "", **settings: Any) -> System:
    """Two of the three equations of Roessler, which need not be read after their inputs."""
    parts = (
        Component("yz", FmuFile(fmus(f"{version}roessler_yz{options}")), {"y": 1.0, "z": 0.5}),
        Component("x", FmuFile(fmus(f"{version}roessler_x{options}")), {"x": 2.0}),
    )
    links = ("yz.y -> x.y", "x.x -> yz.x")
    return System(
        "s", parts, links, Simulation(**{"stop_time": 2.0, "step_size": 0.05, **settings})
    )


def recorded(system: System, path: Path) -> np.ndarray:
    """Times and outputs in the results (rows, 4)."""
    run(system, results=path)
    results = load(path)
    return np.column_stack([results.time, *(results[name].values for name in OUTPUTS)])


@pytest.mark.verifies(
    "outputs of FMUs that show zeros once an input is set",
    independent="FMUs of the same equations that lose nothing",
    tolerance="identical",
)
@pytest.mark.parametrize(
    ("algorithm", "version", "by_python"),
    [
        *product(["jacobi", "gauss_seidel", "corrector"], ["", "1:", "3:"], [False]),
        *product(["implicit"], ["", "3:"], [False]),  # for which FMUs have to go back
        *product(["jacobi", "gauss_seidel", "corrector"], [""], [True]),
    ],
)
def test_results_are_those_of_fmus_that_lose_nothing(
    c_fmu: Fmus,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    algorithm: str,
    version: str,
    by_python: bool,
) -> None:
    if by_python:
        monkeypatch.setattr("m4e_fmi.cosim.exchange.step_loop.library", lambda: None)
    state = "" if version == "1:" else "+state"
    plain, losing = (
        recorded(spiral(c_fmu, f"{state}{o}", version, algorithm=algorithm), tmp_path / "r.nc")
        for o in ("", "+clears")
    )
    assert np.ptp(plain[:, 2]) > 0.1  # z, which is not connected, moves
    np.testing.assert_array_equal(losing, plain)


@pytest.mark.parametrize(
    "settings",
    [
        {"output_interval": 0.2},
        {"output_interval": 0.15},  # of which the run is no multiple
        {"coupling_tolerance": 1e-5},
        {"coupling_tolerance": 1e-5, "output_interval": 0.5},
        {"algorithm": "gauss_seidel", "coupling_tolerance": 1e-4},
    ],
)
def test_rows_that_are_not_at_every_step(
    c_fmu: Fmus, tmp_path: Path, settings: dict[str, Any]
) -> None:
    plain, losing = (
        recorded(spiral(c_fmu, f"+state{o}", **settings), tmp_path / "r.nc")
        for o in ("", "+clears")
    )
    np.testing.assert_array_equal(losing, plain)


def test_components_with_steps_of_their_own(c_fmu: Fmus, tmp_path: Path) -> None:
    def sampled(options: str, step: float) -> System:
        system = spiral(c_fmu, options)
        first, second = system.components
        components = (Component("yz", first.source, first.start, step_size=step), second)
        return System("s", components, system.connections, system.simulation)

    for step in (0.1, 0.025):
        plain, losing = (
            recorded(sampled(f"+state{o}", step), tmp_path / "r.nc") for o in ("", "+clears")
        )
        np.testing.assert_array_equal(losing, plain)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector"])
def test_observers_and_python_read_the_same(c_fmu: Fmus, tmp_path: Path, algorithm: str) -> None:
    system = spiral(c_fmu, "+state+clears", algorithm=algorithm)
    rows = recorded(system, tmp_path / "r.nc")
    seen: list[list[float]] = []

    def observe(time: float, network: Network) -> None:
        seen.append([time, *(network.read(name) for name in OUTPUTS)])

    run(system, observers=[observe])
    with start(system) as stepped:
        read = [[point.time, *(point[name] for name in OUTPUTS)] for point in stepped]
    np.testing.assert_array_equal(seen, rows)
    np.testing.assert_array_equal(read, rows)


def test_a_value_set_between_steps_takes_nothing_from_others(c_fmu: Fmus) -> None:
    """An input that is not connected is set in x: what yz gives stays, and so does x itself."""
    with start(spiral(c_fmu, "+state+clears")) as stepped:
        for _ in range(3):
            stepped.step()
        before = [stepped[name] for name in OUTPUTS]
        kept = stepped.save()
        stepped["x.z"] = 0.25
        assert [stepped[name] for name in OUTPUTS] == before
        stepped.step()
        after = [stepped[name] for name in OUTPUTS]
        stepped.restore(kept)
        assert [stepped[name] for name in OUTPUTS] == before
    with start(spiral(c_fmu, "+state")) as stepped:
        for _ in range(3):
            stepped.step()
        stepped["x.z"] = 0.25
        stepped.step()
        assert after == [stepped[name] for name in OUTPUTS]


@pytest.mark.parametrize("silent", [False, True])
@pytest.mark.parametrize("version", ["", "1:", "3:"])
def test_alone_it_gives_what_fmpy_gives(
    c_fmu: Fmus, tmp_path: Path, version: str, silent: bool
) -> None:
    """An input of FMPy's that is held over each step is what jacobi holds: the same bits.

    Where the FMU declares no dependencies, that its outputs are lost is found by probing.
    """
    fmu = c_fmu(f"{version}roessler_yz+clears")
    if silent:
        fmu = silenced(fmu, tmp_path)
    parts = (
        Component("driver", FmuFile(c_fmu("switch")), {"when": 0.5}),
        Component("yz", FmuFile(fmu), {"y": 1.0, "z": 0.5}),
    )
    system = System("s", parts, ("driver.y -> yz.x",), Simulation(1.0, 0.125, "jacobi"))
    outcome = run(system, results=tmp_path / "r.nc")
    assert ("setting inputs loses y, z" in str(outcome.notes)) is silent
    found = load(tmp_path / "r.nc")
    # FMPy takes the value of an input before its jump at the jump itself
    signal = np.zeros(9, dtype=[("time", "f8"), ("x", "f8")])
    signal["time"], signal["x"] = found.time, found["driver.y"].values
    expected = fmpy.simulate_fmu(
        str(fmu),
        stop_time=1.0,
        output_interval=0.125,
        start_values={"y": 1.0, "z": 0.5},
        input=signal,
        output=["y", "z"],
    )
    for name in ("y", "z"):
        np.testing.assert_allclose(found[f"yz.{name}"].values, expected[name], rtol=1e-12, atol=0)


def test_outputs_that_show_a_step_when_inputs_are_set_are_not_lost(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    """Of FMUs that declare nothing: in a chain and in a ring."""
    courses = []
    for option in ("", "+refreshes"):
        keeper = silenced(c_fmu(f"keeper{option}"), tmp_path)
        parts = (
            Component("a", FmuFile(c_fmu("integrator")), {"y": 1.0}),
            Component("b", FmuFile(keeper), {"gain": -1.0}),
            Component("c", FmuFile(c_fmu("integrator"))),
        )
        links = ("a.y -> b.u", "b.y -> a.u", "b.y -> c.u")
        for ring in (links, links[::2]):
            system = System("s", parts, ring, Simulation(2.0, 0.05, "gauss_seidel"))
            run(system, results=tmp_path / "r.nc")
            courses.append(load(tmp_path / "r.nc")["c.y"].values)
    assert np.ptp(courses[2]) > 0.5
    np.testing.assert_allclose(courses[2], courses[0], atol=1e-12)
    np.testing.assert_allclose(courses[3], courses[1], atol=1e-12)
