"""FMUs of models in space: right by the validation, their attitudes those of the simulation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.crane import crane
from support.fmu_instances import FILES, KINDS, Instance

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, load_system, run, save_system
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.validation import validate_fmu
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

STATES = ("e0", "e1", "e2", "e3", "omega_x", "omega", "omega_z")


BRICK = np.array([1.0, 2.0, 3.0])


@pytest.fixture(scope="module")
def built(fmu: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs of all kinds of crane and brick."""
    folder, program = tmp_path_factory.mktemp("built"), model_program(crane())
    cranes = {
        f"crane {name}": build_fmu(program, folder / f"{name}.fmu", **kind.build)
        for name, kind in FILES.items()
    }
    return cranes | {f"brick {name}": fmu(name, "brick") for name in FILES}


@pytest.mark.parametrize("name", ["brick python", "crane native 3"])
def test_validation_finds_nothing_wrong(built: dict[str, Path], name: str) -> None:
    assert validate_fmu(built[name]).of_severity("error", "warning") == ()


@pytest.mark.parametrize("file", ["arm/arm.urdf", "gyroscope/gyroscope.model.yaml"])
def test_validation_takes_rounding_for_nothing(file: str, tmp_path: Path) -> None:
    """The arm's first link turns about Z: its acceleration along Z is 0 but for rounding.

    Sums in the gyroscope's reactions cancel, and round with the size of the seed.
    """
    model = load_model(Path(__file__).parents[2] / "examples" / file)
    fmu = build_fmu(model_program(model), tmp_path / "model.fmu", native=True, fmi="3")
    report = validate_fmu(fmu, only=("dependencies", "directional"))
    assert report.of_severity("error", "warning") == ()


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_tumbles_in_fmpy(built: dict[str, Path], kind: str) -> None:
    """Angular momentum and energy of a free body stay, and |e| is 1: it needs no normalisation.

    CVode keeps 1e-8 in each of some 1,500 steps.
    """
    file, _, exchange = kind.partition(", ")
    states = [f"body.brick.{state}" for state in STATES]
    found = fmpy.simulate_fmu(
        str(built[f"brick {file}"]),
        fmi_type="ModelExchange" if exchange else "CoSimulation",
        stop_time=30.0,
        output_interval=0.1,
        relative_tolerance=1e-8,
        output=states,
    )
    columns = np.vstack([np.atleast_2d(found[name].T) for name in states])
    e, omega = columns[:4].T, columns[4:].T
    np.testing.assert_allclose((e**2).sum(axis=1), 1.0, atol=1e-6)
    body_to_world = Rotation.from_quat(e[:, [1, 2, 3, 0]])
    turning = body_to_world.inv().apply(omega)
    momentum = body_to_world.apply(turning * BRICK)
    size = np.linalg.norm(momentum[0])
    assert np.abs(momentum - momentum[0]).max() < 1e-4 * size
    energy = (turning**2 * BRICK).sum(axis=1)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)
    assert turning[:, 1].min() < -1.5  # it turned over: the axis between is unstable
    assert turning[:, 1].max() > 1.5


@pytest.mark.parametrize("kind", ["native 2", "native 3"])
def test_directional_derivatives_of_a_quaternions_rate(
    built: dict[str, Path], load: Callable[..., Instance], kind: str
) -> None:
    """ė = ½ (0, ω) e + (1 − |e|²) e by e and ω, at a quaternion that is not of length 1."""
    e, omega = np.array([0.7, -0.2, 0.4, 0.3]), np.array([0.5, -1.1, 0.8])
    seed = np.array([0.3, 0.1, -0.6, 0.2, 1.0, -0.4, 0.7])
    start: dict[str, Any] = dict(
        zip([f"body.brick.{s}" for s in STATES], [*e, *omega], strict=True)
    )
    rates = [f"der(body.brick.e{k})" for k in range(4)]
    instance = load(kind, built[f"brick {kind}"]).initialise(start)
    found = instance.slopes(rates, list(start), list(seed))
    de, dw = seed[:4], seed[4:]
    expected = (
        0.5 * _product(dw, e) + 0.5 * _product(omega, de) + (1 - e @ e) * de - 2 * (e @ de) * e
    )
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


def _product(omega: np.ndarray, e: np.ndarray) -> np.ndarray:
    """The quaternion product of (0, ω) and e."""
    return np.array([-omega @ e[1:], *(omega * e[0] + np.cross(omega, e[1:]))])


@pytest.mark.parametrize("kind", FILES)
def test_as_a_component_of_a_system(built: dict[str, Path], kind: str) -> None:
    """By the names of FMI 2.0 whichever the version; as the simulation of the model alone."""
    names = [f"crane.{owner}.{s}" for owner in ("joint.hook", "body.hull") for s in STATES]
    rows: list[list[float]] = []
    part = Component("crane", FmuFile(built[f"crane {kind}"]))
    system = System("alone", (part,), (), Simulation(1.0, 0.1))
    run(system, observers=[lambda _, network: rows.append([network.read(n) for n in names])])
    exact = simulate(crane(), stop_time=1.0, output_interval=0.1, tolerance=1e-11)
    expected = np.array([exact[name.removeprefix("crane.")] for name in names]).T
    np.testing.assert_allclose(rows, expected, atol=1e-6)


@pytest.mark.parametrize("kind", ["native 2", "native 3"])
def test_as_an_ssp_package(built: dict[str, Path], tmp_path: Path, kind: str) -> None:
    """Start values of parts of vectors and quaternions, and connections of vectors, come back."""
    start = {"body.brick.e0": 0.6, "body.brick.e2": 0.8, "body.brick.omega_z": 0.5}
    parts = (
        Component("brick", FmuFile(built[f"brick {kind}"]), start),
        Component("crane", FmuFile(built[f"crane {kind}"]), {"body.arm.moment_x": 0.7}),
    )
    moments = zip(("_x", "", "_z"), "xyz", strict=True)
    links = (
        *(f"crane.joint.hook.reaction_{a} -> brick.body.brick.force_{a}" for a in "xyz"),
        *(
            f"crane.joint.hook.reaction_moment{a} -> brick.body.brick.moment_{b}"
            for a, b in moments
        ),
    )
    system = System("pair", parts, links, Simulation(0.5, 0.05))
    again = load_system(save_system(system, tmp_path / "pair.ssp"))
    names = [f"brick.body.brick.{state}" for state in (*STATES, "x", "y", "z")]
    found = []
    for each in (system, again):
        rows: list[list[float]] = []
        run(each, observers=[lambda _, network, r=rows: r.append([network.read(n) for n in names])])
        found.append(np.array(rows))
    np.testing.assert_array_equal(found[1], found[0])
    at = [names.index(f"brick.{name}") for name in start]
    np.testing.assert_array_equal(found[0][0, at], list(start.values()))
    weight = 9.80665 * 0.5**2 / 2  # of the load, whose support pushes the brick as much: 1 kg
    assert found[0][-1, names.index("brick.body.brick.z")] > 0.5 * weight
