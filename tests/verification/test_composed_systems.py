"""Coupled runs beside the solution of the same equations as one program."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model
from support.cart_systems import ALGORITHMS, cart_system
from support.example_systems import EXAMPLES, example_system, hydraulic_kinds
from support.sampling import blocks
from support.whole_solution import Reference, reference

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.cosim import System, load_system, run, system_program
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program
from m4e_fmi.report import linear_text
from m4e_fmi.simulate import simulate

NOISE = 1e-8
"""Tolerance of the FMUs' own steps, which is no coupling error."""


EXAMPLE_RUNS = {
    "sphere_decay": (5.0, ""),
    "arm": (0.4, ""),
    "hydraulic_pto": (6.0, ""),
    "moored_buoy": (4.0, "mooring"),
}
"""Stop times [s] of examples, and what they have that is no equation."""


@pytest.fixture(scope="module", autouse=True)
def _kinds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with hydraulic_kinds(tmp_path_factory.mktemp("site")):
        yield


def compared(system: System, folder: Path) -> Reference:
    outcome = run(system, build_directory=folder / "build", results=folder / "results.nc")
    return reference(outcome, system_program(system))


@pytest.mark.verifies(
    "coupling errors of 10 random systems, by all algorithms; 25 (make verify)",
    independent="the same equations as one program, DOP853 at 1e-11",
    tolerance="3 times the stated error",
)
@pytest.mark.parametrize("seed", blocks(10, 25))
def test_stated_errors_of_random_systems(seed: int, tmp_path: Path) -> None:
    found = compared(cart_system(tmp_path, seed), tmp_path)
    assert found.errors
    for error in found.errors:
        assert error.actual <= 3 * error.stated + NOISE, str(error.source)


@pytest.fixture(scope="module", params=EXAMPLE_RUNS)
def example(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[System, Program, Path]:
    stop_time, without = EXAMPLE_RUNS[request.param]
    system = example_system(f"{request.param}/system.yaml", without=without)
    program = system_program(system)
    return system.changed(stop_time=stop_time), program, tmp_path_factory.mktemp("example")


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_stated_errors_of_examples(
    example: tuple[System, Program, Path], algorithm: str, tmp_path: Path
) -> None:
    """Of all connections, not only the worst; buoys without their lines, which are no equations."""
    system, program, folder = example
    changed = system.changed(algorithm=algorithm)
    outcome = run(changed, build_directory=folder, results=tmp_path / "results.nc")
    found = reference(outcome, program)
    assert found.errors
    for error in found.errors:
        assert error.actual <= 3 * error.stated + NOISE, str(error.source)


STOPPED = """\
name: {name}
gravity: 9.81
bodies: {{cart: {{mass: {mass}, inertia: 1}}}}
joints: {{rail: {{type: prismatic, child: cart, direction: [1, 0], initial: {{q: {q}, u: 1}}}}}}
loads:
  stop: {{type: joint_stop, joint: rail, stiffness: 2000, upper: 0.2, lower: -0.2, damping: 20}}
  rub: {{type: joint_friction, joint: rail, effort: 1.0, velocity: 0.01}}
"""
CONTACTS = """\
name: contacts
components:
  a: {model: a.model.yaml}
  b: {model: b.model.yaml}
  jumps: {kind: table, times: [0, 0.5, 0.5, 1, 1.5], beyond: held,
    signals: {f: {unit: N, values: [1, 1, 4, 4, -2]}}}
  held: {kind: table, times: [0, 0.3, 0.73, 1.2], between: held, beyond: held,
    signals: {f: {unit: N, values: [0, 2, -2, 1]}}}
connections:
  - a.joint.rail.q * 20 -> b.joint.rail.effort, units ignored
  - b.joint.rail.q * 20 -> a.joint.rail.effort, units ignored
  - jumps.f -> a.body.cart.force_x
  - held.f -> b.body.cart.force_x
simulation: {stop_time: 2, step_size: 0.005}
"""


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_stated_errors_with_stops_friction_and_jumps(algorithm: str, tmp_path: Path) -> None:
    for name, mass, q in (("a", 2, 0.0), ("b", 1, 0.1)):
        text = STOPPED.format(name=name, mass=mass, q=q)
        (tmp_path / f"{name}.model.yaml").write_text(text, encoding="utf-8")
    path = tmp_path / "system.yaml"
    path.write_text(CONTACTS, encoding="utf-8")
    system = load_system(path).changed(algorithm=algorithm)
    found = compared(system, tmp_path)
    assert len(found.errors) == 4
    for error in found.errors:
        assert error.actual <= 3 * error.stated + NOISE, str(error.source)
    alone = simulate(system_program(system), stop_time=2.0, tolerance=1e-10)
    assert np.max(np.abs(alone["a.joint.rail.q"])) > 0.2
    assert alone.energy is not None
    assert alone.energy.relative < 1e-7


def test_rows_between_the_output_times_are_not_compared(tmp_path: Path) -> None:
    """Adaptive steps end at times that the solution has no row of."""
    system = cart_system(tmp_path, 1).changed(algorithm="corrector", coupling_tolerance=1e-6)
    outcome = run(system, build_directory=tmp_path / "build", results=tmp_path / "results.nc")
    gaps = np.diff(outcome.results().time)
    assert gaps.min() < 0.9 * gaps.max()
    found = reference(outcome, system_program(system))
    assert 1 < found.compared < found.rows == len(outcome.results().time)
    assert f"at {found.compared} of {found.rows} rows" in str(found)
    for error in found.errors:
        assert error.actual <= 3 * error.stated + NOISE, str(error.source)


def test_energy_of_all_parts_is_balanced(tmp_path: Path) -> None:
    system = cart_system(tmp_path, 1)
    result = simulate(system_program(system), stop_time=2.0, tolerance=1e-11)
    assert result.energy is not None
    assert result.energy.relative < 1e-9
    kinetic = sum(result[f"m{k}.energy.kinetic"] for k in range(2))
    potential = sum(result[f"m{k}.energy.potential"] for k in range(2))
    assert result.energy.total == pytest.approx(kinetic + potential, rel=1e-14)


def test_the_linear_equations_are_those_of_differences(tmp_path: Path) -> None:
    """A of a system with a controller and a take-off, by central differences of its rates."""
    program = system_program(cart_system(tmp_path, 1))
    linear = linearize(program)
    # the energy that the take-off counts is no state of the linear equations
    names = [v.name for v in linear.states]
    assert {v.name for v in program.states} - set(names) == {"pto.energy"}

    def rates(at: dict[str, float]) -> np.ndarray:
        return linearize(program, at=at).rates

    start = {v.name: v.start for v in program.states}
    for column, name in enumerate(names):
        h = 1e-5
        change = (
            rates(start | {name: start[name] + h}) - rates(start | {name: start[name] - h})
        ) / (2 * h)
        assert linear.A[:, column] == pytest.approx(change, rel=1e-7, abs=1e-6)


def test_mass_matrices_of_all_parts_stand_beside_the_other_states(tmp_path: Path) -> None:
    program = system_program(cart_system(tmp_path, 1))
    linear = linearize(program)
    found, n = linear.mechanical, linear.degrees_of_freedom
    assert found is not None
    assert (n, found.M.shape, found.S.shape) == (4, (4, 4), (4, len(linear.states) - 8))
    # carts with their bobs: no inertia is shared between two models
    assert not found.M[:2, 2:].any()
    speed = np.random.default_rng(0).normal(size=n)
    names = [v.name for v in linear.states[n : 2 * n]]
    at = dict(zip(names, speed, strict=True))
    energies = linearize(program, at=at, outputs=["m0.energy.kinetic", "m1.energy.kinetic"])
    assert 0.5 * speed @ found.M @ speed == pytest.approx(energies.values.sum(), rel=1e-13)


def test_the_table_has_the_modes_of_the_motions() -> None:
    """Surge, heave and pitch of the sphere of the memory's many modes; heave as of a decay."""
    program = system_program(load_system(EXAMPLES / "sphere_decay" / "system.yaml"))
    linear = linearize(program, at=equilibrium(program))
    found = modes(linear)
    assert found.participation.sum(axis=0) == pytest.approx(np.ones(len(found.eigenvalues)))
    text = linear_text(linear, found, title="equilibrium")
    rows = [line for line in text.splitlines() if "body.body.sphere." in line and "i" in line[-2:]]
    assert [row.split()[4] for row in rows] == ["body.body.sphere.z", "body.body.sphere.theta"]
    assert "and 16 in which other states" in text
    decay = simulate(program, stop_time=15.0, output_interval=0.01, tolerance=1e-10)
    z = decay["body.body.sphere.z"] + 2.0
    up = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    crossings = decay.time[up] - z[up] * 0.01 / (z[up + 1] - z[up])
    eigenvalue = found.eigenvalues[int(rows[0].split()[0]) - 1]
    # after the first swings only the least damped motion is left
    assert crossings[-1] - crossings[-2] == pytest.approx(2 * np.pi / eigenvalue.imag, rel=1e-3)


def test_the_one_fmu_has_the_same_derivatives(tmp_path: Path) -> None:
    """A by directional derivatives of the FMU of the whole, in model exchange."""
    program = system_program(cart_system(tmp_path, 1))
    linear = linearize(program)
    path = build_fmu(program, tmp_path / "whole.fmu", native=True)
    described: Any = fmpy.read_model_description(str(path))
    fmu = FMU2Model(
        guid=described.guid,
        unzipDirectory=fmpy.extract(str(path), str(tmp_path / "unpacked")),
        modelIdentifier=described.modelExchange.modelIdentifier,
        instanceName="whole",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    states = {d.variable.derivative.name: d.variable for d in described.derivatives}
    rates = [states[v.name].valueReference for v in linear.states]
    A = [
        fmu.getDirectionalDerivative(rates, [states[v.name].derivative.valueReference], [1.0])
        for v in linear.states
    ]
    fmu.terminate()
    fmu.freeInstance()
    assert pytest.approx(linear.A, rel=1e-12, abs=1e-12) == np.array(A).T
