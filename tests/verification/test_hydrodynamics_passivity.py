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
from m4e_adapters.hydrodynamics.flow import cache
from m4e_adapters.hydrodynamics.memory import group_fit, soundness
from m4e_adapters.hydrodynamics.memory.group_fit import RadiationGroup
from m4e_adapters.hydrodynamics.memory.passivity import singular_frequencies
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory, fit_radiation
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
    assert np.linalg.eigvalsh(np.real(k)).min() >= -1e-12 * np.abs(k).max()
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
    found = np.einsum("i,wij,j->w", turn, np.real(transfer(memory, data.omega[band])), turn)
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


def test_an_added_mass_inf_that_is_negative_is_refused() -> None:
    """As of a table with another sign convention; the fit of A∞ cannot mend the couplings."""
    data = rm3()
    coupled = data.added_mass_inf.copy()
    coupled[1, 4] = coupled[4, 1] = 1.3 * np.sqrt(coupled[1, 1] * coupled[4, 4])
    still = replace(
        data,
        added_mass=np.broadcast_to(coupled, data.added_mass.shape),
        radiation_damping=np.zeros_like(data.radiation_damping),
        added_mass_inf=coupled,
    )
    with pytest.raises(InputError, match="float heave, spar heave is negative, by 30 %"):
        fit_radiation(still)


def shortened(data: Coefficients, kept: np.ndarray) -> Coefficients:
    """`data` at some frequencies only."""
    names = ("omega", "added_mass", "radiation_damping", "excitation")
    return replace(data, **{name: getattr(data, name)[kept] for name in names})


def test_data_that_end_early_are_told() -> None:
    """The damping of the sphere is largest at 1.2 rad/s and half of that at 2.1 rad/s."""
    data = sphere()
    for end, expected in ((1.5, True), (2.3, False)):
        told: list[str] = []
        fit_radiation(shortened(data, data.omega <= end), progress=told.append)
        warnings = [text for text in told if "still more than half" in text]
        assert bool(warnings) == expected
        assert not expected or "ball heave at 1.5 rad/s (9" in warnings[0]


@pytest.mark.parametrize("kept", [slice(0, 1), slice(0, 5), slice(80, None)])
def test_too_few_frequencies_are_refused(kept: slice) -> None:
    data = sphere()
    with pytest.raises(InputError, match="a radiation memory needs 8 or more"):
        fit_radiation(shortened(data, np.arange(len(data.omega))[kept]))


def test_no_real_data_at_a_steep_peak_are_left_out() -> None:
    """A flap in deep water: its damping doubles from one frequency of the table to the next."""
    omega = np.arange(1, 41) * 0.0927
    s = 1j * omega
    peak, plateau = s / ((s + 0.15) ** 2 + 1.3**2), 0.1 * s / ((s + 1.0) ** 2 + 1.5**2)
    known = np.ones((1, 40), dtype=bool)
    values = (peak + plateau)[None, :] / np.abs(peak).max()
    assert soundness.on_the_line(omega, values, known).all()
    for spoilt in ([20], [30], [20, 21]):
        wrong = values.copy()
        wrong[0, spoilt] += 0.2
        trusted = soundness.on_the_line(omega, wrong, known)
        assert np.flatnonzero(~trusted).tolist() == spoilt


def spoilt_beyond(end: float) -> Coefficients:
    """The flap's damping with a wave of 30 % beyond a frequency [rad/s], as of coarse panels."""
    data = flap()
    data = shortened(data, np.arange(len(data.omega)) % 5 == 0)
    more = data.omega > end
    damping = data.radiation_damping.copy()
    damping[more] *= 1 + 0.3 * np.sin(9 * (data.omega[more] - end))[:, None, None]
    return replace(data, radiation_damping=damping)


def test_data_that_panels_do_not_resolve_do_not_spoil_the_fit() -> None:
    """Beyond 2.6 rad/s; below it is as good as with good data, at the flap's resonance, too."""
    spoilt = spoilt_beyond(2.6)
    turn = np.array([FLAP_ARM, 0.0, 1.0])
    errors = []
    for data in (spoilt, replace(spoilt, resolved=(2.6,))):
        told: list[str] = []
        memory = fit_radiation(data, order=10, progress=told.append)
        band = (data.omega >= 0.25) & (data.omega <= 2.6)
        found = np.einsum("i,wij,j->w", turn, np.real(transfer(memory, data.omega[band])), turn)
        exact = np.einsum("i,wij,j->w", turn, data.radiation_damping[band], turn)
        errors.append(np.abs(found / exact - 1).max())
    assert errors[0] > 0.05
    assert errors[1] < 0.01
    assert "where the panels resolve the waves, up to 2.6 rad/s" in told[0]
    assert "warning" not in told[0]


def test_pitch_of_a_ball_about_its_centre_has_no_memory() -> None:
    """It is of panels only, no memory of any body, and refuses nothing."""
    data = sphere()
    noise = np.diag([0.0, 0.0, 5e-5 * data.buoyancy[1] / 9.81 * 41.6])
    growing = np.linspace(0.0, 1.0, len(data.omega))[:, None, None]
    made = replace(
        data,
        radiation_damping=data.radiation_damping + growing * noise,
        added_mass=data.added_mass + noise,
        added_mass_inf=data.added_mass_inf + noise,
    )
    told: list[str] = []
    memory = fit_radiation(made, order=4, progress=told.append)
    assert [group.motions for group in memory.groups] == [(1,)]
    assert not any("ball pitch" in text for text in told)


def two_spheres(every: int = 1) -> Coefficients:
    """The sphere and one four times as large, far apart; each `every`th frequency up to 3 rad/s.

    By Froude's law: A of the large one at ω is 4³ that of the small one at 2ω.
    """
    one = sphere()
    omega = one.omega[: len(one.omega) // 2][every - 1 :: every]
    first, second = (np.isin(np.round(one.omega, 9), np.round(w, 9)) for w in (omega, 2 * omega))

    def both(small: np.ndarray, large: np.ndarray) -> np.ndarray:
        nothing = np.zeros_like(small)
        return np.block([[small, nothing], [nothing, large]])

    turns = np.array([1.0, 1.0, 4.0])  # moments per angle grow by another square of the length
    size = np.outer(turns, turns)
    return replace(
        one,
        bodies=("small", "large"),
        centers=np.array([[0.0, -2.0], [1e4, -8.0]]),
        omega=omega,
        added_mass=both(one.added_mass[first], 64 * size * one.added_mass[second]),
        radiation_damping=both(
            one.radiation_damping[first], 32 * size * one.radiation_damping[second]
        ),
        added_mass_inf=both(one.added_mass_inf, 64 * size * one.added_mass_inf),
        excitation=np.zeros((len(omega), 6), dtype=complex),
        hydrostatic_stiffness=both(
            one.hydrostatic_stiffness, 16 * size * one.hydrostatic_stiffness
        ),
        buoyancy=np.concatenate([one.buoyancy, 64 * one.buoyancy]),
        resolved=(3.0, 1.486),
    )


def test_a_small_body_does_not_extend_the_memory_of_a_large_one() -> None:
    """Damping of the large one is of no use above k a = 4.5, as of panels that are coarse for it:
    both memories are those that each body has alone."""
    data = two_spheres()
    damping = data.radiation_damping.copy()
    wild = 1 + 0.5 * np.sin(30 * data.omega)
    damping[:, 4, 4] *= np.where(data.omega > 1.5, wild, 1.0)
    memory = fit_radiation(replace(data, radiation_damping=damping))
    assert [group.motions for group in memory.groups] == [(1,), (4,)]
    for body, end in ((0, 2.9), (1, 1.45)):
        band = (data.omega > 0.2) & (data.omega < end)
        heave = 3 * body + 1
        found = np.real(transfer(memory, data.omega[band]))[:, heave, heave]
        exact = data.radiation_damping[band, heave, heave]
        assert np.abs(found - exact).max() < 0.01 * exact.max()


def test_a_small_body_does_not_vouch_for_the_frequencies_of_a_large_one() -> None:
    """Of 14 frequencies, 7 are where the large one radiates; of 16, 8 are."""
    with pytest.raises(InputError) as caught:
        fit_radiation(two_spheres(every=4))
    (problem,) = caught.value.problems
    assert "body 'large': 7 of the 14 frequencies are up to 1.486 rad/s" in problem.message
    assert problem.remedy.startswith("use a frequencies.count of 16 or more")
    assert problem.keys == ("frequencies", "count")
    assert (np.linspace(2.8 / 16, 2.8, 16) <= 1.486).sum() == 8


def test_a_body_without_memory_is_named() -> None:
    data = two_spheres()
    calm = data.radiation_damping.copy()
    calm[:, 3:, 3:] = 0.0
    told: list[str] = []
    fit_radiation(replace(data, radiation_damping=calm), progress=told.append)
    assert [text for text in told if "no radiation memory" in text] == [
        "note: body 'large' has no radiation memory: it makes almost no waves"
    ]


def test_an_added_mass_that_disagrees_is_fitted_and_told() -> None:
    data = sphere()
    told: list[str] = []
    wrong = replace(data, added_mass_inf=1.05 * data.added_mass_inf)
    memory = fit_radiation(wrong, progress=told.append)
    assert "A(ω) and A∞ disagree, A∞ is by the fit: ball heave 1.30" in told[0]
    assert memory.added_mass_inf[1, 1] == pytest.approx(data.added_mass_inf[1, 1], rel=2e-3)
    memory = fit_radiation(data)
    assert memory.added_mass_inf[1, 1] == data.added_mass_inf[1, 1]


def test_a_large_change_of_the_added_mass_is_warned_of() -> None:
    data, told = sphere(), []
    fit_radiation(replace(data, added_mass_inf=1.2 * data.added_mass_inf), progress=told.append)
    assert told[0].startswith("warning: radiation of ball heave")
    assert "A∞ is by the fit: ball heave 1.30" in told[0]


def fits_in_turn(monkeypatch: pytest.MonkeyPatch, *fits: RadiationGroup) -> None:
    """Let the fits of a group to its data, to resolved ones, to smooth ones be these; keep none."""
    rest = iter(fits)
    monkeypatch.setattr(cache, "found", lambda *_: None)
    monkeypatch.setattr(cache, "keep", lambda *_: None)
    monkeypatch.setattr(group_fit, "_fitted", lambda *_: next(rest))


def test_an_added_mass_of_unresolved_data_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the resolved data agree with the A∞ given: A∞ of two rafts was wrong by a quarter."""
    data = replace(sphere(), resolved=(2.0,))
    good = fit_radiation(data).groups[0]
    assert isinstance(good, RadiationGroup)
    changed = replace(good, surplus=0.2 * good.inertia[:, None])
    changed = replace(changed, misfit=replace(good.misfit, error=0.01))
    fits_in_turn(monkeypatch, changed, good)
    assert fit_radiation(data).groups == (good,)


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
