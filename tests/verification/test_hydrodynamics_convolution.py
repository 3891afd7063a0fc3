"""The radiation memory as a convolution: a reference that is not fitted, beside the state space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.floating_systems import Memory, released_exactly
from support.published_coefficients import DATA, RM3_MASS, flap, rm3, sphere

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Radiation
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.convolution import ConvolutionGroup, _duration
from m4e_adapters.hydrodynamics.memory.kernel import Kernel
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_fmi.cli import main
from m4e_fmi.cosim import load_system, prepare, run, system_program
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.simulate import simulate

BALL = 261.8e3  # kg
KINDS = ("state_space", "convolution")
Of = Callable[[str], dict[str, Memory]]


def in_heave(data: Coefficients) -> Coefficients:
    """The coefficients with the memory of heave alone."""
    n = len(data.added_mass_inf)
    keep = np.zeros((n, n))
    keep[1::3, 1::3] = 1.0
    names = ("added_mass", "radiation_damping", "added_mass_inf")
    return replace(data, **{name: getattr(data, name) * keep for name in names})


SOURCES: dict[str, Callable[[], Coefficients]] = {
    "sphere": sphere,
    "flap": flap,
    "rm3": lambda: in_heave(rm3()),
}


@pytest.fixture(scope="module")
def memories() -> Of:
    """Both memories of a source, from the equations of their programs."""
    known: dict[str, dict[str, Memory]] = {}

    def of(name: str) -> dict[str, Memory]:
        if name not in known:
            data = SOURCES[name]()
            known[name] = {
                kind: Memory.of(hydrodynamics_program(data, radiation=Radiation(memory=kind)), data)
                for kind in KINDS
            }
        return known[name]

    return of


def released(memory: Memory, name: str, time: np.ndarray) -> np.ndarray:
    """Displacements (n, m) [m, rad] at `time` (n,) [s] after a release."""
    data = SOURCES[name]()
    mass, start = np.diag(RM3_MASS), np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    stiffness, damping = data.hydrostatic_stiffness, np.zeros_like(data.hydrostatic_stiffness)
    if name == "sphere":
        mass, start = np.diag([BALL, BALL, 25 * BALL]), start[:3]
    elif name == "rm3":
        take_off = 1.2e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
        damping[np.ix_((1, 4), (1, 4))] = take_off
    else:
        own = 297376.0
        mass, start = own * np.diag([1.0, 1.0, 20.0]), np.array([1.0, 1.0, 0.2])
        stiffness = np.diag([0.27 * own, stiffness[1, 1], 18.0 * own])
    return memory.released(mass=mass, stiffness=stiffness, damping=damping, start=start, time=time)


def rms(difference: np.ndarray) -> np.ndarray:
    """Root mean square over the first axis, in the difference's unit."""
    return np.sqrt(np.square(difference).mean(axis=0))


@pytest.mark.verifies(
    "decay of a sphere from 1 m with a convolution: root mean square over 40 s",
    analytic="linear theory in the frequency domain, from A(ω) and B(ω) of WAMIT",
    tolerance="2e-4 m",
)
def test_a_sphere_decays_as_in_the_frequency_domain(memories: Of) -> None:
    data, time = sphere(), np.arange(0.0, 40.01, 0.05)
    exact = released_exactly(
        data, 1, mass=BALL, stiffness=data.hydrostatic_stiffness[1, 1], start=1.0, time=time
    )
    assert exact[0] == pytest.approx(1.0, abs=1e-3)
    assert np.ptp(exact) > 1.5
    for memory in memories("sphere").values():
        assert rms(released(memory, "sphere", time)[:, 1] - exact) < 2e-4


@pytest.mark.parametrize(
    ("name", "most"),
    [
        pytest.param(
            name,
            most,
            marks=pytest.mark.verifies(
                f"state space against convolution, {text}: root mean square of each motion over "
                "its range",
                independent="convolution with the memory of B",
                tolerance=f"{most:g}",
            ),
        )
        for name, most, text in (
            ("sphere", 1e-3, "sphere in heave"),
            ("rm3", 1e-3, "float and spar of RM3 in heave"),
            ("flap", 5e-3, "flap in surge, heave and pitch"),
        )
    ],
)
def test_state_space_and_convolution_move_alike(memories: Of, name: str, most: float) -> None:
    time = np.arange(0.0, 60.01, 0.05)
    courses = {kind: released(memory, name, time) for kind, memory in memories(name).items()}
    size = np.ptp(courses["convolution"], axis=0)
    apart = rms(courses["state_space"] - courses["convolution"])
    moving = size > 0
    assert moving.sum() == {"sphere": 1, "rm3": 2, "flap": 3}[name]
    assert (apart[moving] < most * size[moving]).all()
    assert (apart[moving] > 1e-7 * size[moving]).all()


@pytest.mark.verifies(
    "RM3 after a release by 1 m with the PTO, convolution: root mean square over range",
    independent="WEC-Sim",
    tolerance="1e-3",
)
def test_rm3_is_released_as_by_wec_sim(memories: Of) -> None:
    time, *expected = np.loadtxt(DATA / "rm3_decay_wec_sim.csv", delimiter=",", unpack=True)
    found = released(memories("rm3")["convolution"], "rm3", time)
    for column, start, given in zip((1, 4), (-0.72, -21.29), expected, strict=True):
        assert rms(found[:, column] + start - given) < 1e-3 * np.ptp(given)


@pytest.mark.verifies(
    "damping of both memories at resonance, sphere and RM3's float in heave, flap in its hinge",
    independent="B(ω) of WAMIT and Capytaine",
    tolerance="0.01",
)
@pytest.mark.parametrize(
    ("name", "turn", "resonance"),
    [
        ("sphere", [0.0, 1.0, 0.0], 1.43),
        ("rm3", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 1.2),
        ("flap", [5.0, 0.0, 1.0], 0.4),
    ],
)
def test_the_damping_at_resonance(
    memories: Of, name: str, turn: list[float], resonance: float
) -> None:
    data = SOURCES[name]()
    at = int(np.abs(data.omega - resonance).argmin())
    exact = turn @ data.radiation_damping[at] @ np.array(turn)
    for memory in memories(name).values():
        found = turn @ np.real(memory.transfer(data.omega[[at]])[0]) @ np.array(turn)
        assert found == pytest.approx(exact, rel=0.01)


def test_the_program_is_the_group_that_was_told(memories: Of) -> None:
    """K(jω) of the program's equations and of the group; and a past that cannot grow."""
    data = sphere()
    (group,) = fit_radiation(data, convolution=True).groups
    assert isinstance(group, ConvolutionGroup)
    memory = memories("sphere")["convolution"]
    assert len(memory.a) == group.order
    omega = np.linspace(0.0, 12.0, 40)
    apart = memory.transfer(omega)[:, 1, 1] - group.transfer(omega)[:, 0, 0]
    assert np.abs(apart).max() < 1e-9 * data.radiation_damping.max()
    assert np.linalg.eigvals(memory.a).real.max() < 0


@pytest.mark.verifies(
    "convolution, passive at all frequencies: least eigenvalue of Re K, over the largest |K|, 0 to "
    "100 rad/s; the damping added for that, over the largest B",
    independent="published data of three devices, WAMIT and Capytaine",
    tolerance="0; 5e-3",
)
@pytest.mark.parametrize("data", [sphere, flap, rm3])
def test_the_convolution_is_passive(data: Callable[[], Coefficients]) -> None:
    for group in fit_radiation(data(), convolution=True).groups:
        assert isinstance(group, ConvolutionGroup)
        omega = np.concatenate([np.linspace(0, 16, 6001), np.geomspace(16, 100, 2000)])
        assert np.linalg.eigvalsh(np.real(group.transfer(omega))).min() >= 0
        assert 0 < group.surcharge < 5e-3


def spoilt(noise: float) -> Coefficients:
    """The sphere with that scatter of B over its largest, root mean square."""
    data = sphere()
    largest = data.radiation_damping.max()
    errors = noise * largest * np.random.default_rng(3).standard_normal(len(data.omega))
    unit = np.diag([0.0, 1.0, 0.0])
    return replace(data, radiation_damping=data.radiation_damping + errors[:, None, None] * unit)


@pytest.mark.parametrize("noise", [1e-3, 4e-3])
def test_noise_is_told(noise: float) -> None:
    (group,) = fit_radiation(spoilt(noise), convolution=True).groups
    assert isinstance(group, ConvolutionGroup)
    # the cubic through four neighbours has a variance of 34/36 of that of each
    assert group.noise == pytest.approx(noise * np.sqrt(1 + 34 / 36), rel=0.35)


def test_a_memory_that_does_not_decay_is_refused() -> None:
    """Damping at one frequency alone: K is a cosine for ever."""
    one = np.ones((1, 1, 1))
    forever = Kernel(np.ones(1), one, 2.0, np.zeros((1, 1)), 60.0, np.eye(4)[0])
    with pytest.raises(InputError, match=r"nowhere above the noise.* 60 s that"):
        _duration(forever, 2.0)


def test_truncation_is_told() -> None:
    """A memory that decays slowly, K = c e^(−at) (cos bt − (a/b) sin bt), known up to π/Δω."""
    data, told = sphere(), list[str]()
    a, b, c = 0.12, 1.1, 2e4
    s = 1j * data.omega
    k = c * s / ((s + a) ** 2 + b**2)
    unit = np.diag([0.0, 1.0, 0.0])
    made = replace(
        data,
        radiation_damping=k.real[:, None, None] * unit,
        added_mass=data.added_mass_inf + (k.imag / data.omega)[:, None, None] * unit,
    )
    (group,) = fit_radiation(made, convolution=True, progress=told.append).groups
    assert isinstance(group, ConvolutionGroup)
    assert f"convolution over {group.duration:.3g} s" in told[0]
    assert "truncation" in told[0]
    # what a cut at T takes from K(jω) is at most, and at ω = b nearly, ∫ |K| from there on
    largest = k.real.max()
    envelope = c * np.hypot(1, a / b) * np.exp(-a * group.duration) / a / 2
    assert 0.3 * envelope < group.truncation * largest < 1.5 * envelope
    time = np.linspace(0.5, 0.9 * group.duration, 300)  # this B falls slower than a body's, as ω⁻²
    exact = c * np.exp(-a * time) * (np.cos(b * time) - a / b * np.sin(b * time))
    found = group.impulse_response(time)[:, 0, 0]
    np.testing.assert_allclose(found, exact, atol=0.01 * c)
    assert not group.impulse_response(np.array([1.01 * group.duration])).any()


def test_an_order_beside_a_convolution_is_refused() -> None:
    text = (
        "bodies: {ball: {shape: {sphere: {radius: 5}}, center_of_gravity: [0, -2]}}\n"
        "radiation: {memory: convolution, order: 6}\n"
    )
    with pytest.raises(InputError, match="'order' has no effect on a convolution") as caught:
        Document.parse(text).validate(HydrodynamicsConfig)
    assert caught.value.problems[0].line == 2


def test_a_memory_that_is_unknown_is_refused() -> None:
    text = (
        "bodies: {ball: {shape: {sphere: {radius: 5}}, center_of_gravity: [0, -2]}}\n"
        "radiation: {memory: convolved}\n"
    )
    with pytest.raises(InputError, match="memory"):
        Document.parse(text).validate(HydrodynamicsConfig)


def test_a_file_with_a_convolution(tmp_path: Path) -> None:
    """The key reaches the program: as many states as polynomials."""
    from m4e_fmus import hydrodynamics

    (tmp_path / "ball.h5").write_bytes((DATA / "oes10_sphere.h5").read_bytes())
    told: list[str] = []
    config = HydrodynamicsConfig.model_validate(
        {
            "coefficients": "ball.h5",
            "bodies": {"ball": {}},
            "radiation": {"memory": "convolution"},
        }
    )
    program = hydrodynamics.KIND.build(config, name="hydro", folder=tmp_path, progress=told.append)
    (line,) = (text for text in told if "ball heave" in text and "convolution" in text)
    count = int(line.split(" polynomials")[0].split()[-1])
    states = [v for v in program.states if "heave" in v.description]
    assert len(states) == count
    assert {v.unit for v in states} == {"m/s"}


SYSTEM = """\
name: release
components:
  body: {model: sphere.model.yaml}
  water:
    kind: hydrodynamics
    coefficients: oes10_sphere.h5
    bodies: {sphere: {}}
    radiation: {memory: convolution}
connections: [body.sphere <-> water.sphere, water.added_mass -> body.added_mass]
simulation: {stop_time: 10, step_size: 0.1}
"""
MODEL = """\
name: sphere
bodies: {sphere: {mass: 261800, inertia: 1.69e+6, added_mass: true}}
joints: {sea: {type: floating, child: sphere, initial: {z: -1}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A system with a convolution."""
    found = tmp_path_factory.mktemp("release")
    (found / "system.yaml").write_text(SYSTEM)
    (found / "sphere.model.yaml").write_text(MODEL)
    (found / "oes10_sphere.h5").write_bytes((DATA / "oes10_sphere.h5").read_bytes())
    return found


def test_its_fmu_keeps_its_state(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rollback, and saved states in new instances and processes, bit for bit."""
    assert main(["build", str(folder / "system.yaml"), "--build-folder", str(folder)]) == 0
    (path,) = folder.rglob("water.fmu")
    capsys.readouterr()
    assert main(["validate", str(path), "--only", "state"]) == 0
    assert "no errors, no warnings" in capsys.readouterr().out


def test_a_coupled_run_is_of_the_order_of_its_algorithm(folder: Path) -> None:
    """Against the whole system as one program: of second order or better."""
    system = load_system(folder / "system.yaml")
    height = "body.body.sphere.z"
    exact = simulate(system_program(system), stop_time=10.0, output_interval=0.2, tolerance=1e-10)
    errors = []
    for size in (0.2, 0.1):
        prepared = prepare(system.changed(step_size=size))
        found = run(prepared, results=folder / "run.nc").results()[height].values
        errors.append(np.abs(found[:: round(0.2 / size)] - exact[height]).max())
    assert errors[1] < errors[0] / 4
    assert errors[1] < 1e-4
