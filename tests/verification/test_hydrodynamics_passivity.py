"""The radiation memory of published coefficients: passive, and accurate where bodies move."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from support.published_coefficients import (
    DATA,
    FLAP_ARM,
    RM3_MASS,
    flap,
    linear_system,
    rm3,
    sphere,
    transfer,
)

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.passivity import singular_frequencies
from m4e_adapters.hydrodynamics.radiation import RadiationMemory, fit_radiation
from m4e_fmi.errors import InputError

SOURCES: dict[str, Callable[[], Coefficients]] = {"sphere": sphere, "flap": flap, "rm3": rm3}


@pytest.fixture(scope="module")
def fitted() -> Callable[[str], tuple[RadiationMemory, list[str]]]:
    """The memory of a source, and what was told of it."""
    known: dict[str, tuple[RadiationMemory, list[str]]] = {}

    def fit(name: str) -> tuple[RadiationMemory, list[str]]:
        if name not in known:
            told: list[str] = []
            known[name] = fit_radiation(SOURCES[name](), progress=told.append), told
        return known[name]

    return fit


Fitted = Callable[[str], tuple[RadiationMemory, list[str]]]


@pytest.mark.verifies(
    "passive radiation memory: least eigenvalue of Re K, over the largest |K|, 0 to 400 rad/s",
    independent="published data of three devices, WAMIT and Capytaine",
    tolerance="1e-12",
)
@pytest.mark.parametrize("name", SOURCES)
def test_the_memory_is_passive_at_all_frequencies(fitted: Fitted, name: str) -> None:
    memory, _ = fitted(name)
    k = transfer(memory, np.concatenate([np.linspace(0, 10, 4001), np.linspace(10, 400, 8001)]))
    assert np.linalg.eigvalsh(k.real).min() >= -1e-12 * np.abs(k).max()
    assert np.linalg.eigvalsh(memory.added_mass_inf).min() > -1e-12 * memory.added_mass_inf.max()


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.parametrize("frequency", [0.2, 0.5, 1.0, 2.0, 4.0])
def test_still_water_makes_no_energy(fitted: Fitted, name: str, frequency: float) -> None:
    """With any springs all motions decay, or stay."""
    memory, _ = fitted(name)
    data = SOURCES[name]()
    own = data.buoyancy[1::3] / data.gravity
    mass = np.diag(RM3_MASS if name == "rm3" else np.array([own[0], own[0], 20 * own[0]]))
    springs = frequency**2 * np.diag((mass + memory.added_mass_inf).diagonal())
    none = np.zeros_like(mass)
    roots = np.linalg.eigvals(linear_system(memory, mass=mass, stiffness=springs, damping=none))
    assert roots.real.max() <= 1e-9 * np.abs(roots).max()


@pytest.mark.verifies(
    "damping of a bottom-hinged flap in its hinge, 0.25 to 1 rad/s, no option set",
    independent="Capytaine 2.3.1 (WEC-Sim Applications)",
    tolerance="0.03",
)
def test_the_damping_of_a_flap_in_its_hinge(fitted: Fitted) -> None:
    memory, _ = fitted("flap")
    data = flap()
    band = (data.omega >= 0.25) & (data.omega <= 1.0)
    turn = np.array([FLAP_ARM, 0.0, 1.0])
    found = np.einsum("i,wij,j->w", turn, transfer(memory, data.omega[band]).real, turn)
    exact = np.einsum("i,wij,j->w", turn, data.radiation_damping[band], turn)
    assert np.abs(found / exact - 1).max() < 0.03


@pytest.mark.verifies(
    "RM3's published coefficients in all planar motions, no frequency cut: float and spar after a "
    "release by 1 m with the PTO, root mean square of the difference over range",
    independent="WEC-Sim",
    tolerance="1e-3",
)
def test_rm3_is_released_as_by_wec_sim(fitted: Fitted) -> None:
    memory, told = fitted("rm3")
    assert "reciprocity" in told[0]
    pto = np.zeros((6, 6))
    pto[np.ix_((1, 4), (1, 4))] = 1.2e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    matrix = linear_system(
        memory, mass=np.diag(RM3_MASS), stiffness=rm3().hydrostatic_stiffness, damping=pto
    )
    time, *expected = np.loadtxt(DATA / "rm3_decay_wec_sim.csv", delimiter=",", unpack=True)
    step, y = expm(matrix * (time[1] - time[0])), np.zeros(len(matrix))
    y[1] = 1.0
    course = [y]
    for _ in time[1:]:
        course.append(step @ course[-1])
    for column, start, given in zip((1, 4), (-0.72, -21.29), expected, strict=True):
        difference = np.array(course)[:, column] + start - given
        assert np.sqrt(np.square(difference).mean()) < 1e-3 * np.ptp(given)


def test_the_frequencies_at_which_a_matrix_is_singular_are_found() -> None:
    """Re 1/(jω + a) = a/(ω² + a²): of two terms, and of two by two with known null vectors."""
    poles = np.array([-1.0 + 0j, -3.0 + 0j])
    # 1/(1 + w2) - 2 (3/(9 + w2)) = 0 where 9 + w2 = 6 + 6 w2
    (one,) = singular_frequencies(poles, np.array([[1.0, -2.0]]), 1)
    assert one == pytest.approx(np.sqrt(3 / 5), rel=1e-9)
    first, second = np.array([1.0, -2.0]), np.array([1.0, -1.0])  # the second: at w2 = 3
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    full = np.einsum("ia,ak,ja->ijk", turn, np.array([first, second]), turn)
    rows, columns = np.triu_indices(2)
    found = singular_frequencies(poles, full[rows, columns], 2)
    np.testing.assert_allclose(found, [np.sqrt(3 / 5), np.sqrt(3)], rtol=1e-9)
    assert not len(singular_frequencies(poles, np.array([[1.0, 1.0]]), 1))


def test_negative_damping_is_left_out_and_named() -> None:
    data = sphere()
    spoilt = data.radiation_damping.copy()
    at = [int(np.argmin(np.abs(data.omega - w))) for w in (1.4, 1.45)]
    spoilt[at, 1, 1] *= -0.5
    told: list[str] = []
    memory = fit_radiation(replace(data, radiation_damping=spoilt), progress=told.append)
    assert "warning: the radiation damping of ball heave is negative at 1.4, 1.45 rad/s" in told[0]
    assert "lid" in told[0]
    good = fit_radiation(data)
    omega = np.linspace(0.2, 3.0, 50)
    difference = np.abs(transfer(memory, omega) - transfer(good, omega)).max()
    assert difference < 5e-3 * np.abs(transfer(good, omega)).max()


def test_damping_that_is_negative_at_many_frequencies_is_refused() -> None:
    data = sphere()
    spoilt = data.radiation_damping.copy()
    spoilt[(data.omega > 1.0) & (data.omega < 1.8)] *= -1
    with pytest.raises(InputError, match=r"ball heave is negative at 1\.05, 1\.1") as caught:
        fit_radiation(replace(data, radiation_damping=spoilt))
    assert "finer mesh" in caught.value.problems[0].remedy


def test_an_added_mass_that_disagrees_is_fitted_and_told() -> None:
    data = sphere()
    told: list[str] = []
    wrong = replace(data, added_mass_inf=1.05 * data.added_mass_inf)
    memory = fit_radiation(wrong, progress=told.append)
    assert "A(ω) and A∞ disagree, A∞ is by the fit: ball heave 1.30" in told[0]
    assert memory.added_mass_inf[1, 1] == pytest.approx(data.added_mass_inf[1, 1], rel=2e-3)
    memory = fit_radiation(data)
    assert memory.added_mass_inf[1, 1] == data.added_mass_inf[1, 1]


def test_cross_terms_that_are_noise_are_dropped() -> None:
    """What one half says of two motions and the other does not couples nothing."""
    data = sphere()
    rng = np.random.default_rng(1)
    mass, damping = data.added_mass.copy(), data.radiation_damping.copy()
    mass[:, 0, 0] = data.added_mass[:, 1, 1]
    damping[:, 0, 0] = data.radiation_damping[:, 1, 1]
    infinite = data.added_mass_inf.copy()
    infinite[0, 0] = infinite[1, 1]
    for values, share in ((mass, 0.02), (damping, 0.02)):
        noise = rng.normal(size=(len(data.omega), 2, 2)) * share * values[:, 1, 1].max()
        values[:, [0, 1], [1, 0]] += noise[:, [0, 1], [1, 0]]
    made = replace(data, added_mass=mass, radiation_damping=damping, added_mass_inf=infinite)
    memory = fit_radiation(made)
    assert [group.motions for group in memory.groups] == [(0,), (1,)]
