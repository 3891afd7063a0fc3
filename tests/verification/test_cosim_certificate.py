"""The certificate against the true errors of random linear pairs, whose course is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from m4e_fmi.cosim import Component, FmuFile, Network, Simulation, System, run

Fmus = Callable[[str], Path]

STOP, STEP = 4.0, 0.05
PORTS = ("a.body.m.x", "a.body.m.vx")


def pair(fmus: Fmus, algorithm: str, rng: np.random.Generator) -> tuple[System, np.ndarray]:
    """Two masses with random springs, dampers and start; the matrix of x1, v1, x2, v2."""
    m, k, d, kp, kc, dc = rng.uniform((0.5, 0, 0, 0.5, 0.2, 0), (2, 4, 0.5, 4, 4, 0.3))
    a = Component(
        "a",
        FmuFile(fmus("mass+state")),
        {"mass": m, "stiffness": k, "damping": d, "body.m.x": 1.0},
    )
    b = Component(
        "b",
        FmuFile(fmus("partner+state")),
        {"stiffness": kp, "coupling": kc, "damping": dc, "x": 0.0},
    )
    matrix = np.array(
        [
            [0, 1, 0, 0],
            [-(k + kc) / m, -(d + dc) / m, kc / m, dc / m],
            [0, 0, 0, 1],
            [kc, dc, -kp - kc, -dc],
        ]
    )
    return System("s", (a, b), ("a.m <-> b.end",), Simulation(STOP, STEP, algorithm)), matrix


@pytest.mark.verifies(
    "stated coupling error of random pairs, over or under the true one by at most a factor",
    analytic="matrix exponential",
    tolerance="1.5",
)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_true_error_is_what_is_stated(c_fmu: Fmus, algorithm: str) -> None:
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(5):
        system, matrix = pair(c_fmu, algorithm, rng)
        found: list[list[float]] = []

        def observe(_: float, network: Network, found: list = found) -> None:
            found.append([*map(network.read, PORTS), network.read("b.end.force_x")])

        outcome = run(system, observers=[observe], check=True)
        assert outcome.certificate is not None
        (stated,) = outcome.certificate.errors
        points = np.arange(len(found)) * STEP
        states = np.array([expm(t * matrix)[:, 0] for t in points])
        start = system.components[0].start
        m, k, d = (float(str(start[name])) for name in ("mass", "stiffness", "damping"))
        force = m * (states @ matrix[1]) + k * states[:, 0] + d * states[:, 1]
        exact = np.column_stack((states[:, :2], force))
        errors = np.abs(np.array(found) - exact).max(axis=0) / np.ptp(exact, axis=0)
        ratios.append(errors.max() / stated.error)
    # where the next order counts, the estimate is off by a part of itself
    assert max(ratios) < 1.5
    assert min(ratios) > 0.5


def test_the_line_names_the_worst_and_what_half_the_step_gives(c_fmu: Fmus) -> None:
    system, _ = pair(c_fmu, "corrector", np.random.default_rng(1))
    outcome = run(system, check=True)
    certificate = outcome.certificate
    assert certificate is not None
    worst = certificate.errors[0]
    assert worst.connection == "a.m <-> b.end"
    finer = run(system.changed(step_size=STEP / 2), check=True).certificate
    assert finer is not None
    # third order or better: an eighth at most
    assert worst.error / finer.errors[0].error > 7
    line = f"largest coupling error {worst.error:.1e} of range, at {worst.source}"
    assert str(certificate).startswith(line)
    assert str(certificate).endswith(f"halve the step for {worst.error / 8:.1e}")
    assert run(system).certificate is None


def test_adaptive_steps_are_checked_at_an_eighth_of_the_tolerance(c_fmu: Fmus) -> None:
    system, matrix = pair(c_fmu, "corrector", np.random.default_rng(2))
    adaptive = system.changed(step_size=0.5, output_interval=0.5, coupling_tolerance=1e-4)
    found: dict[float, float] = {}

    def observe(time: float, network: Network) -> None:
        found[time] = network.read("a.body.m.x")

    outcome = run(adaptive, observers=[observe], check=True)
    assert outcome.certificate is not None
    times = np.arange(0, 9) * 0.5
    exact = np.array([expm(t * matrix)[0, 0] for t in times])
    true = np.abs([found[t] for t in times] - exact).max() / np.ptp(exact)
    assert true < 3 * outcome.certificate.errors[0].error
    assert outcome.certificate.errors[0].error < 1e-2
