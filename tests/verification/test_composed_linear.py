"""Linear equations and sensitivities of composed systems, against their FMU and differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model
from support.cart_systems import cart_system

from m4e_fmi.analysis import (
    Linearization,
    Linearizer,
    eigenvalue_sensitivity,
    equilibrium,
    linearize,
    modes,
    sensitivity,
    trajectory_sensitivity,
)
from m4e_fmi.cosim import system_program
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program
from m4e_fmi.runtime.engine import Control, ensemble
from m4e_fmi.simulate import simulate

SEEDS = range(1, 7)
PUSH = "push"
OUTPUTS = ["m0.body.bob.z", "m0.body.bob.ax", "m1.joint.rail.q", "m1.energy.total", "place"]


def with_own_ports(folder: Path, seed: int) -> Program:
    """A random system with an own input on two carts, an own output, its take-off left open."""
    system = cart_system(folder, seed)
    targets = ("m0.body.cart.force_z", "m1.body.cart.force_x")
    system = replace(system, inputs={PUSH: targets}, outputs={"place": "m0.body.bob.x"})
    opened = ["pto"] if "pto" in [c.name for c in system.components] else []
    return system_program(system, keep_open=opened)


def own_and_open_inputs(program: Program) -> list[str]:
    names = [v.name for v in program.inputs]
    assert PUSH in names
    chosen = [PUSH, "m0.joint.hinge.effort", "m0.point.tip.force_x", "m0.point.tip.force_z"]
    return [name for name in chosen if name in names]


def moved(program: Program, seed: int) -> dict[str, float]:
    """A point in motion, with inputs that are not zero."""
    r = np.random.default_rng(seed)
    states = {v.name: v.start + r.uniform(-0.3, 0.3) for v in program.states}
    return states | {name: r.uniform(-2, 2) for name in own_and_open_inputs(program)}


def by_differences(
    evaluated: Callable[[dict[str, float]], np.ndarray], at: dict[str, float], names: list[str]
) -> np.ndarray:
    """Central differences of two steps, extrapolated to fourth order: one column for each name."""

    def slope(name: str, h: float) -> np.ndarray:
        up, down = (evaluated(at | {name: at[name] + s}) for s in (h, -h))
        return (up - down) / (2 * h)

    steps = {name: 1e-3 * max(1.0, abs(at[name])) for name in names}
    return np.column_stack([(4 * slope(n, h) - slope(n, 2 * h)) / 3 for n, h in steps.items()])


def whole_matrix(linear: Linearization) -> np.ndarray:
    return np.block([[linear.A, linear.B], [linear.C, linear.D]])


@pytest.mark.verifies(
    "A, B, C, D of 6 whole systems, by own inputs, open inputs and parameters",
    independent="central differences of fourth order",
    tolerance="1e-7",
)
@pytest.mark.parametrize("seed", SEEDS)
def test_all_four_matrices_are_those_of_differences(seed: int, tmp_path: Path) -> None:
    """Of own inputs, open inputs and parameters; energies are quadratic, accelerations are not."""
    program = with_own_ports(tmp_path, seed)
    inputs = [*own_and_open_inputs(program), "m0.k", "m1.c"]
    start = {v.name: v.start for v in (*program.states, *program.inputs, *program.parameters)}
    at = start | moved(program, seed)
    linearizer = Linearizer(program, inputs=inputs, outputs=OUTPUTS)
    linear = linearizer.at(at)
    columns = [*(v.name for v in linear.states), *inputs]

    def evaluated(values: dict[str, float]) -> np.ndarray:
        found = linearizer.at(values)
        return np.concatenate([found.rates, found.values])

    found, exact = whole_matrix(linear), by_differences(evaluated, at, columns)
    scale = np.abs(exact).max(axis=1, keepdims=True)
    assert (np.abs(found - exact) <= 1e-7 * scale).all()


class OneFmu:
    """The FMU of a program in model exchange, at values of states and inputs."""

    def __init__(self, program: Program, folder: Path, at: dict[str, float]) -> None:
        path = build_fmu(program, folder / "whole.fmu", native=True)
        described: Any = fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in described.modelVariables}
        self.rates = {
            d.variable.derivative.name: d.variable.valueReference for d in described.derivatives
        }
        self.fmu: Any = FMU2Model(
            guid=described.guid,
            unzipDirectory=fmpy.extract(str(path), str(folder / "unpacked")),
            modelIdentifier=described.modelExchange.modelIdentifier,
            instanceName="whole",
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.setReal([self.references[name] for name in at], list(at.values()))
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def slopes(self, rows: list[int], columns: list[str]) -> np.ndarray:
        given = [self.references[name] for name in columns]
        found = [self.fmu.getDirectionalDerivative(rows, [known], [1.0]) for known in given]
        return np.array(found).T

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.mark.parametrize("seed", SEEDS)
def test_all_four_matrices_are_those_of_the_one_fmu(seed: int, tmp_path: Path) -> None:
    program = with_own_ports(tmp_path, seed)
    at, inputs = moved(program, seed), own_and_open_inputs(program)
    linear = linearize(program, at=at, inputs=inputs, outputs=OUTPUTS)
    states = [v.name for v in linear.states]
    one = OneFmu(program, tmp_path, at)
    rows = [*(one.rates[name] for name in states), *(one.references[name] for name in OUTPUTS)]
    exact = one.slopes(rows, [*states, *inputs])
    one.close()
    scale = np.abs(exact).max(axis=1, keepdims=True)
    assert np.abs(linear.B).max() > 0.0
    assert np.abs(linear.D).max() > 0.0
    assert (np.abs(whole_matrix(linear) - exact) <= 1e-12 * scale).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_no_eigenvalue_is_zero(seed: int, tmp_path: Path) -> None:
    """Energy that is counted is no state; every motion and sum of these systems has a stiffness."""
    program = system_program(cart_system(tmp_path, seed))
    linear = linearize(program, at=equilibrium(program))
    assert not [v.name for v in linear.states if v.name.endswith("energy")]
    assert np.abs(modes(linear).eigenvalues).min() > 1e-6


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_sensitivities_of_eigenvalues(seed: int, tmp_path: Path) -> None:
    """A take-off counts its energy: a state of the program that is none of the linear equations."""
    program = system_program(cart_system(tmp_path, seed))
    at = equilibrium(program).values
    found = eigenvalue_sensitivity(program, by=["m0.k"], at=at)
    h = 1e-4 * at["m0.k"]
    up, down = (
        modes(linearize(program, at={**at, "m0.k": at["m0.k"] + s})).eigenvalues for s in (h, -h)
    )
    exact = (up - down) / (2 * h)
    assert found.values[:, 0] == pytest.approx(exact, rel=1e-6, abs=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("seed", [1, 2])
def test_sensitivities_of_the_equilibrium_and_of_the_motion(seed: int, tmp_path: Path) -> None:
    program = with_own_ports(tmp_path, seed)
    at = dict(equilibrium(program).values)
    by = ["m0.k", PUSH]
    found = sensitivity(program, of=["m0.joint.rail.q"], by=by, at=at, moving=True)

    def settled(values: dict[str, float]) -> np.ndarray:
        return np.array([equilibrium(program, at=values)["m0.joint.rail.q"]])

    assert found.values == pytest.approx(by_differences(settled, at, by), rel=1e-6)

    start = {v.name: v.start for v in (*program.parameters, *program.inputs, *program.states)}
    by = [*by, "m1.joint.rail.q"]
    times: dict[str, Any] = {"stop_time": 2.0, "output_interval": 0.1, "tolerance": 1e-11}
    motion = trajectory_sensitivity(program, of=["m0.body.bob.z"], by=by, **times)

    def ended(values: dict[str, float]) -> np.ndarray:
        given: dict[str, float | str] = {name: values[name] for name in by}
        return np.asarray(simulate(program, start_values=given, **times)["m0.body.bob.z"])

    exact = by_differences(ended, start, by)
    scale = np.abs(exact).max(axis=0)
    assert (np.abs(motion.derivatives[:, 0] - exact) <= 1e-6 * scale).all()


def test_an_ensemble_has_the_motions_of_simulate(tmp_path: Path) -> None:
    program = system_program(cart_system(tmp_path, 1))
    names = [v.name for v in program.parameters]
    times = np.linspace(0.0, 2.0, 21)
    stiff = np.linspace(20.0, 60.0, 11)
    parameters = np.tile([v.start for v in program.parameters], (len(stiff), 1))
    parameters[:, names.index("m0.k")] = stiff
    states = np.tile([v.start for v in program.states], (len(stiff), 1))
    control = Control(rtol=1e-11, atol=1e-11)
    runs = ensemble(program, times, parameters=parameters, states=states, control=control)
    place = [v.name for v in program.states].index("m0.joint.hinge.q")
    for k, run in zip(stiff, runs, strict=True):
        alone = simulate(
            program,
            stop_time=2.0,
            output_interval=0.1,
            start_values={"m0.k": float(k)},
            tolerance=1e-11,
        )
        assert np.abs(run.states[:, place] - alone["m0.joint.hinge.q"]).max() < 1e-8
