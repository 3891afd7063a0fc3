"""Algebraic loops: through scaled connections, and without a single solution, which zeros solve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system

from m4e_fmi.cosim import Simulation, run
from m4e_fmi.cosim.network.newton import ROUGH, TOLERANCE, NotConvergedError, QuasiNewton
from m4e_fmi.errors import RunError


@pytest.mark.parametrize("options", ["+state", "+state+jacobian"])
def test_an_algebraic_loop_through_scaled_connections_is_solved(c_fmu: Fmus, options: str) -> None:
    """a.y = a.u + t, b.y = b.u + t with a.u = b.y/2 + 1 and b.u = a.y/2: a.y = 4/3 + 2 t."""
    names = dict.fromkeys(["a", "b"], f"stage{options}")
    links, settings = ("b.y * 0.5 + 1 -> a.u", "a.y * 0.5 -> b.u"), Simulation(0.4, 0.1, "implicit")
    loop = system(c_fmu, names, *links, simulation=settings)
    for time, output, given in observed(loop, "a.y", "a.u")[0]:
        assert output == pytest.approx(4 / 3 + 2 * time, abs=10 * TOLERANCE)
        assert given == pytest.approx(output - time, abs=1e-12)


@pytest.mark.parametrize("algorithm", ["gauss_seidel", "implicit"])
@pytest.mark.parametrize("options", ["+state", "+state+jacobian"])
def test_an_algebraic_loop_of_an_input_with_several_sources(
    c_fmu: Fmus, algorithm: str, options: str
) -> None:
    """Added masses of 0.2 and 0.3 kg that come back as forces are as one of 0.5 kg."""
    found = []
    for added in ({"b": 0.5}, {"b": 0.2, "c": 0.3}):
        names = {"a": f"mass{options}", "d": f"spring{options}"}
        names |= dict.fromkeys(added, f"added_mass{options}")
        start = {"a": {"body.m.x": 1.0}} | {
            n: {"added": mass, "stiffness": 0.0} for n, mass in added.items()
        }
        links = [f"{n}.end.force_x -> a.body.m.force_x" for n in (*added, "d")]
        links += [f"a.body.m.x -> {n}.end.x" for n in (*added, "d")]
        links += [f"a.body.m.ax -> {n}.end.ax" for n in added]
        settings = Simulation(0.5, 0.01, algorithm)
        given = system(c_fmu, names, *links, start=start, simulation=settings)
        found.append(np.array(observed(given, "a.body.m.x", "a.body.m.ax")[0]))
    assert found[1] == pytest.approx(found[0], abs=50 * TOLERANCE)
    assert found[0][0, 2] == pytest.approx(-1 / 1.5, abs=1e-8)


@pytest.mark.parametrize("model", ["stage", "stage+jacobian"])
@pytest.mark.parametrize(
    ("a", "b", "singular"),
    [(1.0, 1.0, True), (3.0, 1.0 / 3.0, True), (1e6, 1e-6, True), (-1.0, 1.0, False),
     (1.001, 1.0, False), (1e6, -1e-6, False)],
)  # fmt: skip
def test_a_loop_with_the_gain_1_is_refused(
    c_fmu: Fmus, model: str, a: float, b: float, singular: bool
) -> None:
    names, start = dict.fromkeys(["a", "b"], model), {"a": {"gain": a}, "b": {"gain": b}}
    settings = Simulation(0.3, 0.1)
    loop = system(c_fmu, names, "a.y -> b.u", "b.y -> a.u", start=start, simulation=settings)
    if singular:
        with pytest.raises(RunError, match=r"the algebraic loop of [ab]\.u.* is singular at t = 0"):
            run(loop)
    else:
        run(loop)


def solved(function: Callable[[np.ndarray], np.ndarray], scale: list[float]) -> np.ndarray:
    """The x at which function(x) = x, by the iteration alone, with Jacobians by differences."""

    def residual(x: np.ndarray) -> np.ndarray:
        return function(x) - x

    def jacobian(x: np.ndarray, r: np.ndarray, again: bool) -> np.ndarray:
        del again
        steps = 1e-6 * np.diag(scale)
        return np.column_stack([(residual(x + step) - r) / step.max() for step in steps])

    newton = QuasiNewton()
    x = newton.solve(residual, jacobian, np.zeros(len(scale)), np.array(scale))
    assert newton.roughness <= ROUGH
    return x


def test_what_is_zero_by_symmetry_stays_zero() -> None:
    """Three equations of 1e6 about the first unknown, a fourth that is not connected with them."""
    rng = np.random.default_rng(3)
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = rng.normal(size=(3, 3))
    matrix[3, 3] = 7.3
    found = solved(lambda x: matrix @ x + [1e6, 2.0, -3.0, 0.0], [1.0] * 4)
    assert found[3] == 0.0
    assert found[:3] == pytest.approx(np.linalg.solve(np.eye(3) - matrix[:3, :3], [1e6, 2.0, -3.0]))


@pytest.mark.parametrize(
    ("function", "scale"),
    [
        # x + 0.1 = x: the iterates go far, and what they miss does not become small by that
        (lambda x: x[::-1] + 0.1, [1.0, 1.0]),
        (lambda x: x[::-1] + 0.1, [1e-9, 1e-9]),
        (lambda x: np.where(x < 1.0, 2.0, 0.0), [1.0]),  # a jump
    ],
)
def test_no_solution_is_never_taken_for_one(
    function: Callable[[np.ndarray], np.ndarray], scale: list[float]
) -> None:
    with pytest.raises(NotConvergedError) as caught:
        solved(function, scale)
    assert caught.value.size > 1e-3
