"""FMUs of models in space: right by the validation, their attitudes those of the simulation."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]  it has no types
from scipy.spatial.transform import Rotation
from support.crane import crane
from support.fmu_instances import FILES, KINDS, Instance

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, load_system, run, save_system
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.description.terminals import TERMINALS
from m4e_fmi.fmu.validation import validate_fmu
from m4e_fmi.model import Body, Joint, Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

STATES = ("e0", "e1", "e2", "e3", "omega_x", "omega", "omega_z")


BRICK = np.array([1.0, 2.0, 3.0])


def brick() -> Model:
    """A free body that turns about the axis of its middle moment of inertia, nearly."""
    return Model(
        "brick",
        {"brick": Body(1.0, (1.0, 2.0, 3.0))},
        {
            "free": Joint(
                "floating", "brick",
                initial={"phi": 0.3, "theta": -0.2, "psi": 0.5, "omega_x": 0.01, "omega": 2.0},
            )
        },
        gravity=0.0,
        dimensions=3,
    )  # fmt: skip


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs of all kinds of crane and brick."""
    folder = tmp_path_factory.mktemp("built")
    return {
        f"{make.__name__} {name}": build_fmu(
            model_program(make()), folder / f"{make.__name__} {name}.fmu", **kind.build
        )
        for make in (crane, brick)
        for name, kind in FILES.items()
    }


def values(instance: Instance) -> list[float]:
    return instance.get(instance.reals())


@pytest.mark.parametrize("name", ["brick python", "brick native 2", "crane native 3"])
def test_validation_finds_nothing_wrong(built: dict[str, Path], name: str) -> None:
    assert validate_fmu(built[name]).of_severity("error", "warning") == ()


def test_validation_takes_rounding_for_nothing(tmp_path: Path) -> None:
    """The arm's first link turns about Z: its acceleration along Z is 0 but for rounding."""
    arm = load_model(Path(__file__).parents[2] / "examples" / "arm" / "arm.urdf")
    fmu = build_fmu(model_program(arm), tmp_path / "arm.fmu", native=True, fmi="3")
    report = validate_fmu(fmu, only=("dependencies", "derivatives", "directional"))
    assert report.of_severity("error", "warning") == ()


ARRAYS = {
    "body.hull.position": 3, "body.hull.quaternion": 4, "body.hull.attitude": 3,
    "body.hull.velocity": 3, "body.hull.angular_velocity": 3, "body.hull.acceleration": 3,
    "body.hull.angular_acceleration": 3, "body.hull.force": 3, "body.hull.moment": 3,
    "joint.hook.quaternion": 4, "joint.hook.angular_velocity": 3, "joint.hook.reaction": 3,
    "joint.hook.reaction_moment": 3, "point.deck.force": 3, "load.line.force": 3,
    "der(body.hull.quaternion)": 4, "der(joint.hook.quaternion)": 4,
    "der(joint.hook.angular_velocity)": 3,
}  # fmt: skip


def test_vectors_and_quaternions_are_arrays_of_fmi_3(built: dict[str, Path]) -> None:
    description: Any = fmpy.read_model_description(str(built["crane native 3"]))
    shapes = {v.name: v.shape for v in description.modelVariables}
    assert {name: shapes[name] for name in ARRAYS} == {n: (k,) for n, k in ARRAYS.items()}
    alone = [name for name in shapes if name.rpartition(".")[2] in ("e0", "omega_x", "phi")]
    assert alone == []
    rates = {v.name: v.derivative.name for v in description.modelVariables if v.derivative}
    assert rates["der(body.hull.quaternion)"] == "body.hull.quaternion"
    assert rates["body.hull.angular_acceleration"] == "body.hull.angular_velocity"
    with zipfile.ZipFile(built["crane native 3"]) as archive:
        root = etree.fromstring(archive.read(TERMINALS))
    terminals = {t.get("name"): [m.get("memberName") for m in t] for t in root.iter("Terminal")}
    assert {"force", "moment", "position", "quaternion", "attitude", "angular_velocity"} <= set(
        terminals["body.hull"]
    )
    assert set(terminals["point.deck"]) == {"force", "position", "velocity", "acceleration"}


@pytest.mark.parametrize("kind", KINDS)
def test_a_body_tumbles_in_fmpy(built: dict[str, Path], kind: str) -> None:
    """Angular momentum and energy of a free body stay, and |e| is 1: it needs no normalisation.

    CVode keeps 1e-8 in each of some 1,500 steps.
    """
    file, _, exchange = kind.partition(", ")
    states = [f"body.brick.{state}" for state in STATES]
    arrays = ["body.brick.quaternion", "body.brick.angular_velocity"]
    names = arrays if "3" in kind else states
    found = fmpy.simulate_fmu(
        str(built[f"brick {file}"]),
        fmi_type="ModelExchange" if exchange else "CoSimulation",
        stop_time=30.0,
        output_interval=0.1,
        relative_tolerance=1e-8,
        output=names,
    )
    columns = np.vstack([np.atleast_2d(found[name].T) for name in names])
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


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_after_restoring_is_the_step_before(
    built: dict[str, Path], load: Callable[..., Instance], kind: str
) -> None:
    """To the bit, quaternions included, after steps in between that led elsewhere."""
    instance = load(kind, built[f"crane {kind.partition(',')[0]}"]).initialise()
    instance.step(0.0, 0.5)
    saved, before = instance.save(), values(instance)
    instance.step(0.5, 0.5)
    after = values(instance)
    for state in (saved, instance.unpack(instance.pack(saved))):
        instance.step(1.0, 0.7)
        assert values(instance) != after
        instance.restore(state)
        assert values(instance) == before
        instance.step(0.5, 0.5)
        assert values(instance) == after


@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.exchange])
def test_states_of_model_exchange_survive(
    built: dict[str, Path], load: Callable[..., Instance], kind: str
) -> None:
    """Rates after setting the states as read before; FMI 3.0 has them in the order of arrays."""
    instance = load(kind, built[f"crane {kind.partition(',')[0]}"]).initialise()
    x, rates, saved = instance.states(), instance.rates(), instance.save()
    instance.put_states(x + 0.1)
    assert np.abs(instance.rates() - rates).max() > 0.01
    instance.restore(saved)
    np.testing.assert_array_equal(instance.states(), x)
    np.testing.assert_array_equal(instance.rates(), rates)


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
    if "3" in kind:
        start = {"body.brick.quaternion": e, "body.brick.angular_velocity": omega}
        rates = ["der(body.brick.quaternion)"]
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
