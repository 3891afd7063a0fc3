"""Converted and scaled connections: every algorithm gives what the same system in SI gives."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, run
from m4e_fmi.cosim.exchange.newton import TOLERANCE

Fmus = Callable[[str], Path]

ROUNDING = 1e-12
"""Of numbers of size 1 after 50 steps, each of which adds some 1e-16."""


def pair(fmus: Fmus, spring: str, options: str, stiffness: float, *connections: str) -> System:
    parts = (
        Component("body", FmuFile(fmus(f"mass{options}")), {"body.m.x": 1.0, "stiffness": 1.0}),
        Component("spring", FmuFile(fmus(f"{spring}{options}")), {"stiffness": stiffness}),
    )
    return System("pair", parts, connections, Simulation(5, 0.1))


def motion(system: System, algorithm: str) -> tuple[list[tuple[float, float]], Outcome]:
    """Position and force at every communication point."""
    seen: list[tuple[float, float]] = []

    def observe(_: float, network: Network) -> None:
        seen.append((network.read("body.body.m.x"), network.read("spring.end.force_x")))

    outcome = run(system.changed(algorithm=algorithm), observers=[observe])
    return seen, outcome


@pytest.mark.parametrize("options", ["", "+state", "+state+inputs", "+state+jacobian"])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_millimetres_reach_the_same_place(c_fmu: Fmus, algorithm: str, options: str) -> None:
    if algorithm == "implicit" and not options:
        pytest.skip("implicit needs rollback")
    whole = "body.m <-> spring.end"
    plain, expected = motion(pair(c_fmu, "spring", options, 3.0, whole), algorithm)
    converted, outcome = motion(pair(c_fmu, "mm_spring", options, 3e-3, whole), algorithm)
    # implicit solves each step to residuals of 1e-9 of the largest value
    tolerance = 50 * TOLERANCE if algorithm == "implicit" else ROUNDING
    np.testing.assert_allclose(converted, plain, rtol=0, atol=tolerance)
    (bond,), (wanted,) = outcome.energy, expected.energy
    assert bond.given == pytest.approx(wanted.given, abs=tolerance)
    assert bond.received == pytest.approx(wanted.received, abs=tolerance)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_factor_and_offset_reach_the_same_place(c_fmu: Fmus, algorithm: str) -> None:
    # k = 3 against a wall at 0.5 m: force = -1.5 (2 x - 1) by way of the connections
    scaled = (
        "body.body.m.x * 2 - 1 -> spring.end.x",
        "body.body.m.vx * 2 -> spring.end.vx",
        "spring.end.force_x * 0.5 -> body.body.m.force_x",
    )
    seen, _ = motion(pair(c_fmu, "spring", "+state", 3.0, *scaled), algorithm)
    at_half = ("body.body.m.x -> spring.end.x", "spring.end.force_x + 1.5 -> body.body.m.force_x")
    plain, _ = motion(pair(c_fmu, "spring", "+state", 3.0, *at_half), algorithm)
    place, force = np.array(seen).T
    # implicit solves each step to residuals of 1e-9 of the largest value
    tolerance = 50 * TOLERANCE if algorithm == "implicit" else ROUNDING
    np.testing.assert_allclose(place, np.array(plain)[:, 0], rtol=0, atol=tolerance)
    np.testing.assert_allclose(force, -3.0 * (2 * place - 1), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("options", ["+state", "+state+jacobian"])
def test_an_algebraic_loop_through_scaled_connections_is_solved(c_fmu: Fmus, options: str) -> None:
    # a.y = a.u + t, b.y = b.u + t with a.u = b.y/2 + 1 and b.u = a.y/2: a.y = 4/3 + 2 t
    parts = tuple(Component(name, FmuFile(c_fmu(f"stage{options}"))) for name in "ab")
    loop = ("b.y * 0.5 + 1 -> a.u", "a.y * 0.5 -> b.u")
    system = System("loop", parts, loop, Simulation(0.4, 0.1, "implicit"))
    seen: list[tuple[float, float, float]] = []
    run(
        system,
        observers=[lambda t, network: seen.append((t, network.read("a.y"), network.read("a.u")))],
    )
    for time, output, given in seen:
        assert output == pytest.approx(4 / 3 + 2 * time, abs=10 * TOLERANCE)
        assert given == pytest.approx(output - time, abs=1e-12)
