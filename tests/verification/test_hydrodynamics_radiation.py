"""The radiation memory: fits of WAMIT's sphere and of exact functions, and the force in time."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.published_coefficients import sphere as sphere_by_wamit

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import Drag, Radiation
from m4e_adapters.hydrodynamics.load.program import hydrodynamics_program
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_adapters.hydrodynamics.memory.passivity import MARGIN
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation
from m4e_fmi.errors import InputError
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python

RHO, G, RADIUS = 1000.0, 9.81, 5.0
ADDED_MASS_INF = 130876.8
FIT = 1e-3  # what the automatic order promises where the data allow it


@pytest.fixture(scope="module", name="sphere")
def coefficients() -> Coefficients:
    """IEA OES Task 10 sphere by WAMIT."""
    return sphere_by_wamit()


def retardation(c: Coefficients) -> np.ndarray:
    """K(jω) = B + jω(A − A∞) of the data."""
    surplus = c.added_mass - c.added_mass_inf
    return c.radiation_damping + 1j * c.omega[:, None, None] * surplus


@pytest.mark.verifies(
    "fit of the radiation memory, stable and passive",
    independent="WAMIT's sphere of IEA OES Task 10",
    tolerance="1e-3",
)
def test_the_fit_is_accurate_stable_and_passive(sphere: Coefficients) -> None:
    (group,) = fit_radiation(sphere).groups
    assert isinstance(group, RadiationGroup)
    assert group.motions == (1,)
    assert group.order <= 8
    assert np.all(np.real(group.poles) < 0)
    used = sphere.omega <= sphere.memory_limit
    omega, exact = sphere.omega[used], retardation(sphere)[used, 1, 1]
    difference = group.transfer(omega)[:, 0, 0] - exact
    assert np.abs(difference).max() < FIT * np.abs(exact).max()
    of_damping = np.abs(np.real(difference)).max() / sphere.radiation_damping[used, 1, 1].max()
    of_mass = np.abs(np.imag(difference) / omega).max() / sphere.added_mass_inf[1, 1]
    assert group.error == pytest.approx(max(of_damping, of_mass), rel=1e-6)
    fine = np.linspace(0.0, 40.0, 8001)
    real = np.real(group.transfer(fine)[:, 0, 0])
    assert real.min() >= -1e-3 * sphere.radiation_damping.max()


def test_more_poles_fit_better(sphere: Coefficients) -> None:
    errors = [fit_radiation(sphere, order=order).groups[0].error for order in (2, 4, 6)]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]


@pytest.mark.verifies("fit of a rational memory", analytic="its poles", tolerance="1e-4")
def test_a_rational_function_is_found_exactly(sphere: Coefficients) -> None:
    """K(s) = c s/((s + a)² + b²) is passive and K(0) = 0: two poles are all there is to find.

    But for the margin of passivity: Re K(0) is that share of its largest.
    """
    omega, a, b, c = sphere.omega, 0.6, 1.1, 2e4
    s = 1j * omega
    k = c * s / ((s + a) ** 2 + b**2)
    unit = np.diag([0.0, 1.0, 0.0])
    given: dict[str, Any] = {
        **vars(sphere),
        "bodies": ("ball",),
        "radiation_damping": k.real[:, None, None] * unit,
        "added_mass": sphere.added_mass_inf + (k.imag / omega)[:, None, None] * unit,
    }
    (group,) = fit_radiation(Coefficients(**given), order=2).groups
    assert isinstance(group, RadiationGroup)
    assert group.error < 2 * MARGIN
    assert group.poles[0] == pytest.approx(-a + 1j * b, rel=1e-4)
    time = np.linspace(0, 10, 50)
    exact = c * np.exp(-a * time) * (np.cos(b * time) - a / b * np.sin(b * time))
    np.testing.assert_allclose(group.impulse_response(time)[:, 0, 0], exact, atol=1e-4 * c)


def test_an_irregular_frequency_is_left_out(sphere: Coefficients) -> None:
    spoilt = sphere.radiation_damping.copy()
    at = int(np.argmin(np.abs(sphere.omega - 1.5)))
    spoilt[at] *= 1.3
    given: dict[str, Any] = {**vars(sphere), "bodies": ("ball",), "radiation_damping": spoilt}
    data = Coefficients(**given)
    told: list[str] = []
    (group,) = fit_radiation(data, order=6, progress=told.append).groups
    assert group.doubtful == (pytest.approx(1.5),)
    assert "1.5 rad/s" in told[0]
    exact = retardation(sphere)[at, 1, 1]
    largest = np.abs(retardation(sphere)[:, 1, 1]).max()
    found = group.transfer(sphere.omega[at : at + 1])[0, 0, 0]
    assert abs(found - exact) < FIT * largest


def test_a_useless_fit_is_refused(sphere: Coefficients) -> None:
    """One pole cannot follow a memory that oscillates."""
    with pytest.raises(InputError, match="radiation of ball heave: order 1") as caught:
        fit_radiation(sphere, order=1)
    assert "radiation.order" in caught.value.problems[0].remedy


def run(program: Program, motion, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Radiation force in heave [N] of a given velocity(t), at 0.1 s, by the program's own rates."""
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    names = [v.name for v in program.inputs]
    wanted = [v.name for v in program.outputs].index("ball.radiation_force_z")

    def inputs(t: float) -> list[float]:
        u = [v.start for v in program.inputs]
        u[names.index("ball.vz")] = motion(t)
        return u

    time = np.arange(0.0, end, 0.1)
    start = np.zeros(len(program.states))
    solution = solve_ivp(
        lambda t, x: form.rates(t, x.tolist(), inputs(t), p, c),
        (0.0, end),
        start,
        t_eval=time,
        rtol=1e-9,
        atol=1e-9,
        max_step=0.05,
    )
    force = [
        form.outputs(t, x, inputs(t), p, c)[wanted]
        for t, x in zip(time.tolist(), solution.y.T.tolist(), strict=True)
    ]
    return time, np.array(force)


@pytest.mark.verifies(
    "memory force in time after a pulse of velocity",
    independent="direct convolution with the cosine transform of the damping",
    tolerance="0.01",
)
def test_memory_force_against_convolution(sphere: Coefficients) -> None:
    """A pulse of velocity; the convolution is done with K(t) = 2/π ∫ B cos ωt dω from the table."""
    program = hydrodynamics_program(sphere)

    def velocity(t: float) -> float:
        return float(np.sin(1.2 * t) * np.exp(-(((t - 5.0) / 3.0) ** 2)))

    time, force = run(program, velocity, 25.0)
    step = 0.02
    fine = np.arange(0.0, 25.0, step)
    phases = np.cos(np.outer(fine, sphere.omega))
    kernel = 2 / np.pi * np.trapezoid(sphere.radiation_damping[:, 1, 1] * phases, sphere.omega)
    history = np.array([velocity(t) for t in fine])
    direct = -np.convolve(kernel, history)[: len(fine)] * step
    direct += 0.5 * step * kernel * history[0] + 0.5 * step * kernel[0] * history  # trapezoid
    # the table ends at 6 rad/s, where B is 0.5 % of its largest value and K(t) wiggles by as much
    np.testing.assert_allclose(force, np.interp(time, fine, direct), atol=0.01 * abs(direct).max())


def test_a_steady_velocity_feels_no_memory(sphere: Coefficients) -> None:
    _, force = run(hydrodynamics_program(sphere), lambda _: 1.0, 200.0)
    assert abs(force[-1]) < FIT * sphere.radiation_damping.max()
    assert abs(force).max() > 0.1 * sphere.radiation_damping.max()


def test_parts_of_the_force(sphere: Coefficients) -> None:
    """Away from the reference pose, without memory: buoyancy − K ξ − c |v| v, and A∞ beside it."""
    program = hydrodynamics_program(
        sphere, drag={"ball": Drag(heave=2e4)}, radiation=Radiation(order=4)
    )
    form = load_python(program)
    p = [v.start for v in program.parameters]
    c = form.constants(p)
    values = {"ball.z": -2.0 + 0.5, "ball.vz": -2.0}
    u = [values.get(v.name, v.start) for v in program.inputs]
    x = [0.0] * len(program.states)
    outputs = dict(
        zip([v.name for v in program.outputs], form.outputs(0.0, x, u, p, c), strict=True)
    )
    expected = RHO * G * (2 / 3 * np.pi * RADIUS**3 - np.pi * RADIUS**2 * 0.5) + 2e4 * 4.0
    assert outputs["ball.force_z"] == pytest.approx(expected, rel=1e-12)
    assert outputs["ball.force_x"] == 0.0
    assert outputs["wave.elevation"] == 0.0
    published = dict(zip([v.name for v in program.calculated], form.calculated(p, c), strict=True))
    assert published["added_mass[2,2]"] == ADDED_MASS_INF
    assert sum(name.startswith("added_mass") for name in published) == 9
    assert published["ball.neutral_mass"] == pytest.approx(
        2 / 3 * np.pi * RADIUS**3 * RHO, rel=1e-12
    )
    assert not any("acceleration" in v.name or v.name.endswith(".az") for v in program.inputs)
    assert all(v.derivative_of is None for v in program.inputs)
