"""FMUs that lose their outputs when inputs are set: read earlier, they equal those of others.

Such an FMU shows zeros from the moment when anything is set until it has made its next step. Tools
that read outputs straight after each step, as FMPy does, never see them.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi2
from support.small_systems import Fmus
from unit.cosim.preparation.test_dependence import silenced

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Network,
    Simulation,
    System,
    load,
    prepare,
    run,
    start,
)
from m4e_fmi.errors import RunError

OUTPUTS = ("yz.y", "yz.z", "x.x")
"""Of these yz.z is not connected."""


def spiral(fmus: Fmus, options: str, version: str = "", **settings: Any) -> System:
    """Two of the three equations of Roessler, which need not be read after their inputs."""
    parts = (
        Component("yz", FmuFile(fmus(f"{version}roessler_yz{options}")), {"y": 1.0, "z": 0.5}),
        Component("x", FmuFile(fmus(f"{version}roessler_x{options}")), {"x": 2.0}),
    )
    links = ("yz.y -> x.y", "x.x -> yz.x")
    given: dict[str, Any] = {"stop_time": 2.0, "step_size": 0.05, **settings}
    return System("s", parts, links, Simulation(**given))


def recorded(system: System, path: Path) -> np.ndarray:
    """Times and outputs in the results (rows, 4)."""
    run(system, results=path, certify=False)
    results = load(path)
    return np.column_stack([results.time, *(results[name].values for name in OUTPUTS)])


@pytest.mark.verifies(
    "outputs of FMUs that show zeros once an input is set",
    independent="FMUs of the same equations that lose nothing",
    tolerance="identical",
)
@pytest.mark.parametrize(
    ("algorithm", "version", "loop"),
    [
        *product(["jacobi", "gauss_seidel", "corrector"], ["", "1:", "3:"], ["C"]),
        *product(["implicit"], ["", "3:"], ["C"]),  # for which FMUs have to go back
        *product(["jacobi", "gauss_seidel", "corrector"], [""], ["Python"]),
    ],
    indirect=["loop"],
)
@pytest.mark.usefixtures("loop")
def test_results_are_those_of_fmus_that_lose_nothing(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, version: str
) -> None:
    state = "" if version == "1:" else "+state"
    plain, losing = (
        recorded(spiral(c_fmu, f"{state}{o}", version, algorithm=algorithm), tmp_path / "r.nc")
        for o in ("", "+clears")
    )
    assert np.ptp(plain[:, 2]) > 0.1  # z, which is not connected, moves
    np.testing.assert_array_equal(losing, plain)


@pytest.mark.parametrize(
    ("settings", "own_step"),
    [
        ({"output_interval": 0.2}, None),
        ({"output_interval": 0.15}, None),  # of which the run is no multiple
        ({"coupling_tolerance": 1e-5}, None),
        ({"coupling_tolerance": 1e-5, "output_interval": 0.5}, None),
        ({"algorithm": "gauss_seidel", "coupling_tolerance": 1e-4}, None),
        ({}, 0.1),
        ({}, 0.025),
    ],
)
def test_rows_that_are_not_at_every_step(
    c_fmu: Fmus, tmp_path: Path, settings: dict[str, Any], own_step: float | None
) -> None:
    def system(options: str) -> System:
        found = spiral(c_fmu, f"+state{options}", **settings)
        first, second = found.components
        return replace(found, components=(replace(first, step_size=own_step), second))

    plain, losing = (recorded(system(options), tmp_path / "r.nc") for options in ("", "+clears"))
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

    Where the FMU declares no dependencies, that its outputs are lost is seen in the run.
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
    lost = "yz: setting inputs, even to the values that they have, changes y, z"
    assert (lost in str(outcome.notes)) is silent
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


def kept(fmus: Fmus, option: str, links: tuple[str, ...], algorithm: str, folder: Path) -> System:
    """A keeper between two integrators; it declares nothing."""
    parts = (
        Component("a", FmuFile(fmus("integrator")), {"y": 1.0}),
        Component("b", FmuFile(silenced(fmus(f"keeper{option}"), folder)), {"gain": -1.0}),
        Component("c", FmuFile(fmus("integrator"))),
    )
    return System("s", parts, links, Simulation(2.0, 0.05, algorithm))


@pytest.mark.parametrize("back", [("b.y -> a.u",), ()], ids=["ring", "chain"])
def test_outputs_that_show_a_step_when_inputs_are_set_are_not_lost(
    c_fmu: Fmus, tmp_path: Path, back: tuple[str, ...]
) -> None:
    courses = []
    for option in ("", "+refreshes"):
        links = ("a.y -> b.u", *back, "b.y -> c.u")
        run(kept(c_fmu, option, links, "gauss_seidel", tmp_path), results=tmp_path / "r.nc")
        courses.append(load(tmp_path / "r.nc")["c.y"].values)
    assert np.ptp(courses[0]) > 0.5
    np.testing.assert_allclose(courses[1], courses[0], atol=1e-12)


@pytest.mark.usefixtures("loop")
def test_nor_are_they_where_values_are_exchanged_twice_at_a_point(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    """After each step an input is set to the value that it has."""
    courses: list[list[float]] = []
    for option in ("", "+refreshes"):
        with start(
            kept(c_fmu, option, ("a.y -> b.u", "b.y -> c.u"), "jacobi", tmp_path)
        ) as stepped:
            courses.append([])
            for _ in range(40):
                stepped.step()
                stepped["a.u"] = 0.0
                courses[-1] += stepped["b.y"], stepped["c.y"]
    assert np.ptp(courses[0]) > 0.5
    np.testing.assert_allclose(courses[1], courses[0], atol=1e-12)


SLEEPERS = "sleeper", "free_sleeper", "blind_sleeper"
"""FMUs with outputs that are 0 up to 2 s: they declare dependencies, declare that there are none,
and declare nothing."""
ALGORITHMS = "jacobi", "gauss_seidel", "corrector", "implicit"
TO_OTHER = ("s.z -> other.u",)


def bare_loop(fmu: Path, start: dict[str, float], u: float, steps: int, size: float) -> np.ndarray:
    """y and z at all points of FMPy's bare loop: step, read, set."""
    description = fmpy.read_model_description(str(fmu))
    references = {v.name: v.valueReference for v in description.modelVariables}
    with tempfile.TemporaryDirectory() as folder:
        fmpy.extract(str(fmu), folder)
        assert description.coSimulation
        instance = fmi2.FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        instance.instantiate()
        instance.setupExperiment(startTime=0.0)
        for name, value in (start | {"u": u}).items():
            instance.setReal([references[name]], [value])
        instance.enterInitializationMode()
        instance.exitInitializationMode()
        rows = [[0.0, 0.0]]
        for step in range(steps):
            instance.setReal([references["u"]], [u])
            instance.doStep(step * size, size)
            rows.append(instance.getReal([references["y"], references["z"]]))
        instance.terminate()
        instance.freeInstance()
    return np.array(rows)


OPTIONS = "+clears", "+clears+partly", "+clears+inputs", "+clears+nans"
WAYS = (0.0, "here", ()), (0.0, "own", TO_OTHER), (0.5, "here", TO_OTHER), (0.5, "own", ())
"""Gain, process, and where z goes: nowhere, or to another component; each pair of two is there."""


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("model", SLEEPERS)
def test_outputs_that_are_lost_later_are_those_of_a_bare_loop(
    c_fmu: Fmus, tmp_path: Path, model: str, options: str
) -> None:
    """Nothing is to be lost before 2 s; from then on each set answers 0, or less than there is."""
    fmu = c_fmu(f"{model}+state{options}")
    shift = SLEEPERS.index(model) + OPTIONS.index(options)
    for k, algorithm in enumerate(ALGORITHMS, shift):
        gain, process, further = WAYS[k % 4]
        expected = bare_loop(fmu, {"gain": gain}, u=1.0, steps=30, size=0.125)
        assert np.ptp(expected[:, 0]) > 0.5
        parts = (
            Component("driver", FmuFile(c_fmu("integrator+state")), {"y": 1.0, "gain": 0.0}),
            Component("s", FmuFile(fmu), {"gain": gain}, process=process),
            Component("other", FmuFile(c_fmu("integrator+state"))),
        )
        settings = Simulation(3.75, 0.125, algorithm)
        system = System("s", parts, ("driver.y -> s.u", *further), settings)
        outcome = run(system, results=tmp_path / "r.nc", certify=False)
        found = load(tmp_path / "r.nc")
        for column, name in enumerate("yz"):
            values = found[f"s.{name}"].values
            np.testing.assert_allclose(values, expected[:, column], rtol=1e-9, atol=0)
        assert ("changes y, z" in str(outcome.notes)) is (model != "free_sleeper")


def test_alone_it_is_a_bare_loop_too(c_fmu: Fmus, tmp_path: Path) -> None:
    fmu = c_fmu("blind_sleeper+clears")
    expected = bare_loop(fmu, {"u": 1.0}, u=1.0, steps=30, size=0.125)
    for algorithm in ALGORITHMS[:3]:
        parts = (Component("s", FmuFile(fmu), {"u": 1.0}),)
        system = System("s", parts, (), Simulation(3.75, 0.125, algorithm))
        run(system, results=tmp_path / "r.nc", certify=False)
        found = load(tmp_path / "r.nc")
        np.testing.assert_allclose(found["s.y"].values, expected[:, 0], rtol=1e-9, atol=0)


def ring_with_sleeper(fmu: Path, algorithm: str, step: float = 0.05, **start: float) -> System:
    """a' = -y, and y = x + gain a with x' = a - x from 2 s on."""
    parts = (
        Component("a", FmuFile(fmu.parent / "integrator_state.fmu"), {"y": 1.0, "gain": -1.0}),
        Component("s", FmuFile(fmu), start),
    )
    return System("s", parts, ("a.y -> s.u", "s.y -> a.u"), Simulation(5.0, step, algorithm))


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("model", SLEEPERS)
@pytest.mark.parametrize(
    ("options", "loop"),
    [("+clears", "C"), ("+clears+nans", "C"), ("+clears+inputs", "Python")],
    indirect=["loop"],
)
@pytest.mark.usefixtures("loop")
def test_coupled_outputs_that_are_lost_later_are_right_within_the_stated_error(
    c_fmu: Fmus, model: str, options: str, algorithm: str, tmp_path: Path
) -> None:
    """Against the solution: x = 2/sqrt(3) exp(-s/2) sin(sqrt(3)/2 s), a = x + x', s = t - 2."""
    c_fmu("integrator+state")
    system = ring_with_sleeper(c_fmu(f"{model}+state{options}"), algorithm)
    certificate = run(system, results=tmp_path / "r.nc").certificate
    found = load(tmp_path / "r.nc")
    s, root = np.maximum(found.time - 2, 0), np.sqrt(3) / 2
    x = np.exp(-s / 2) * np.sin(root * s) / root
    a = np.exp(-s / 2) * (np.cos(root * s) + np.sin(root * s) / (2 * root))
    assert isinstance(certificate, CouplingErrorReport)
    stated = {str(error.source): error.error for error in certificate.errors}
    for name, exact in (("s.y", x), ("a.y", a)):
        error = np.abs(found[name].values - exact).max()
        assert error <= 3 * stated[name] + 1e-9, (name, error, stated)
        assert error < 0.1


def test_undeclared_gains_stay_found(c_fmu: Fmus) -> None:
    """Declared as none, in a chain; not declared, in a ring; and with lost outputs besides."""
    c_fmu("integrator+state")
    late = run(ring_with_sleeper(c_fmu("free_sleeper+state"), "gauss_seidel", gain=0.5))
    assert "s.y changed at t = " in str(late.warnings)
    parts = (
        Component("a", FmuFile(c_fmu("stage+state")), {"gain": -0.5}),
        Component("s", FmuFile(c_fmu("blind_sleeper+state")), {"gain": 0.5, "when": 0.0}),
    )
    links = ("a.y -> s.u, units ignored", "s.y -> a.u, units ignored")
    found = prepare(System("s", parts, links, Simulation(2.0, 0.125, "gauss_seidel")))
    assert "s: no dependencies are declared; probed, y follows u" in str(found.notes)
    assert found.structure.loops
    both = ring_with_sleeper(c_fmu("sleeper+state+clears+partly"), "gauss_seidel", gain=0.5)
    assert "changes y" in str(run(both).notes)


def test_a_loop_of_lost_outputs_ends_the_run(c_fmu: Fmus) -> None:
    """u of the stage is y of the sleeper, of which only its gain is left when u is set."""
    parts = (
        Component("a", FmuFile(c_fmu("stage+state")), {"gain": 0.5}),
        Component("s", FmuFile(c_fmu("sleeper+state+clears+partly")), {"gain": 0.5, "when": 0.5}),
    )
    links = ("a.y -> s.u, units ignored", "s.y -> a.u, units ignored")
    system = System("s", parts, links, Simulation(2.0, 0.125, "gauss_seidel"))
    with pytest.raises(RunError, match=r"s\.y at t = .* s is lost when inputs are set") as caught:
        run(system)
    assert "`dependencies` of s" in str(caught.value)
    needs = replace(parts[1], dependencies={"y": [], "z": []})
    run(System("s", (parts[0], needs), links, system.simulation))


@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("version", ["", "1:", "3:"])
def test_outputs_that_are_not_real_are_lost_alike(
    c_fmu: Fmus, tmp_path: Path, version: str
) -> None:
    """y = u + n of Integers, with the input that the step had; 0 after any set."""
    losing = FmuFile(c_fmu(f"{version}kinds+through+clears"))
    parts = (
        Component("a", FmuFile(c_fmu("2:kinds")), {"period": 0.25}),
        Component("b", losing, {"period": 0.5}),
        Component("c", losing),
    )
    links = ("a.y_int -> b.u_int", "b.y_int -> c.u_int")
    for algorithm in ALGORITHMS[:3]:
        settings = Simulation(2.0, 0.125, algorithm)
        system = System("s", parts, links, settings)
        run(system, results=tmp_path / "r.nc", certify=False)
        found = load(tmp_path / "r.nc")
        a, b, c = (found[f"{name}.y_int"].values for name in "abc")
        np.testing.assert_array_equal(b[1:], a[:-1] + np.floor(found.time[1:] / 0.5 + 1e-6))
        np.testing.assert_array_equal(c[1:], b[:-1])
        assert b[-1] > 5


def test_noise_of_an_fmu_ends_no_algebraic_loop(c_fmu: Fmus) -> None:
    """The sleeper's y changes by 1e-7 of it with each evaluation; nothing is lost."""
    parts = (
        Component("a", FmuFile(c_fmu("stage+state")), {"gain": 0.5}),
        Component("s", FmuFile(c_fmu("sleeper+state+noisy")), {"gain": 0.5, "when": 0.0}),
    )
    links = ("a.y -> s.u, units ignored", "s.y -> a.u, units ignored")
    settings = Simulation(1.00002, 1e-6, "gauss_seidel", start_time=1.0)
    outcome = run(System("s", parts, links, settings))
    assert "setting inputs" not in str(outcome.notes)


@pytest.mark.usefixtures("loop")
def test_discrete_inputs_of_a_longer_step_are_held_at_what_was_set_last(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    """b steps once in two steps of the system, in each of which its input changes."""
    parts = (
        Component("a", FmuFile(c_fmu("2:kinds")), {"period": 0.125}),
        Component("b", FmuFile(c_fmu("2:kinds+through")), {"period": 0.5}, step_size=0.25),
    )
    settings = Simulation(2.0, 0.125, "jacobi")
    outcome = run(System("s", parts, ("a.y_int -> b.u_int",), settings), results=tmp_path / "r.nc")
    found = load(tmp_path / "r.nc")
    times, a, b = (
        row[::2] for row in (found.time, found["a.y_int"].values, found["b.y_int"].values)
    )
    np.testing.assert_array_equal(b, a + np.floor(times / 0.5 + 1e-6))
    assert "setting inputs" not in str(outcome.notes)
