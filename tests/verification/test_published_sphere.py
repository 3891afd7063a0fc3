"""examples/sphere_decay: decays, responses and powers beside exact theory and published curves.

Here with coefficients of a file (WAMIT); the example's own, from its shape: `tests/verify`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import hemisphere
from support.coefficient_files import SPHERE
from support.published_sphere import (
    check_damped_power,
    check_responses,
    curves,
    example_with_coefficients,
)

from m4e_fmi.cosim import load_system, run


@pytest.mark.verifies(
    "decays of a sphere from 1, 3 and 5 m, linear: RMS, of the release",
    analytic="exact solution of linear potential theory (multipoles)",
    tolerance="3e-3",
)
def test_linear_decays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = example_with_coefficients(tmp_path, monkeypatch, SPHERE)
    for release in example.RELEASES:
        times, heave = example.linear_decay(release)
        exact = release * hemisphere.decay(times)
        assert np.sqrt(np.mean((heave - exact) ** 2)) < 3e-3 * release


def test_the_exact_decay_has_its_known_zeros_and_extremes() -> None:
    """Of another evaluation of the same theory, to 1 ms and 5 digits."""
    zeros = np.array([1.139, 3.390, 5.578, 7.748, 9.923, 12.096])
    assert np.abs(hemisphere.decay(zeros)).max() < 1e-3  # of 1.3/s
    extremes = hemisphere.decay(np.array([2.210, 4.418, 6.595, 8.770, 13.119]))
    known = [-0.8671, 0.63498, -0.4649, 0.34666, 0.19170]
    np.testing.assert_allclose(extremes, known, atol=1e-4)


@pytest.mark.verifies(
    "heave of a sphere in ten regular waves, free and with take-off: 0.5 %; mean power 1 %",
    analytic="exact linear potential theory (multipoles)",
    tolerance="5e-3; 1e-2",
)
def test_responses_and_power(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = example_with_coefficients(tmp_path, monkeypatch, SPHERE)
    check_responses(example)
    check_damped_power(example)


@pytest.mark.verifies(
    "damping that absorbs most from ten regular waves",
    published="IEA OES Task 10",
    tolerance="2e-3",
)
def test_the_published_dampings_are_the_impedance(monkeypatch: pytest.MonkeyPatch) -> None:
    _, rows = curves(monkeypatch).table("heave_responses")
    omega, dampings = 2 * np.pi / rows[:, 0], rows[:, 1]
    np.testing.assert_allclose(np.abs(hemisphere.impedance(omega)), dampings, rtol=2e-3)


@pytest.mark.verifies(
    "heave of the sphere in ten regular waves, free and with take-off",
    published="IEA OES Task 10, InWave (Lin)",
    tolerance="0.03",
)
def test_the_published_responses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the scatter of five codes, which is 16 % at 4 s and 5 % on the average."""
    example = example_with_coefficients(tmp_path, monkeypatch, SPHERE)
    names, rows = example.table("heave_responses")
    for kind, damping in (("free", 0.0), ("damped", 1.0)):
        found = example.responses(rows[:, 0], damping * rows[:, 1])
        published = rows[:, names.index(f"InWave (Lin) {kind}")]
        np.testing.assert_allclose(found, published, rtol=0.03)


@pytest.mark.verifies(
    "energy over the connections of the sphere in a sea: lost or made, of what was exchanged",
    analytic="what one gives the other receives",
    tolerance="1e-3",
)
def test_the_energy_balance_in_a_sea(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And the mean power of ten minutes beside that of the linear response to the sea."""
    example = example_with_coefficients(tmp_path, monkeypatch, SPHERE)
    system = load_system(tmp_path / "absorber.yaml").changed(stop_time=120.0)
    outcome = run(system, results=tmp_path / "sea.nc", build_directory=tmp_path, certify=False)
    assert {bond.connection for bond in outcome.energy} == {
        "body.sphere <-> water.sphere",
        "body.pto <-> pto.pto",
    }
    for bond in outcome.energy:
        assert bond.exchanged > 1e5
        assert abs(bond.received - bond.given) < 1e-3 * bond.exchanged
    linear, simulated = example.sea_power()
    # ten minutes hold some 130 waves; the power of a realisation varies by some 10 %
    assert simulated == pytest.approx(linear, rel=0.2)
