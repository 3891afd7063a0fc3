"""How many evaluations algebraic loops take: `python -m benchmark.loops`, in `tests/`.

Three iterations on the same loops x = g(x, t), none of which is given derivatives: quasi-Newton as
the master has it (`m4e_fmi.cosim.network.newton`: differences at first, then Broyden's update,
the matrix kept from one instant to the next), the same without differences (from the identity), and
Aitken's relaxation. An evaluation is one of all FMUs of the loop, a difference is one too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.network.newton import DIFFERENCE, TOLERANCE, NotConvergedError, QuasiNewton

INSTANTS, LIMIT = 20, 200
RATIOS = (0.1, 0.5, 0.9, 1.1, 2.0, 5.0, 20.0)

Course = Callable[[np.ndarray, float], np.ndarray]
"""g(x, t), the values of the sources of x."""


@dataclass
class Counted:
    """The residual of a loop at one instant, and how often it was evaluated."""

    g: Course
    time: float = 0.0
    count: int = 0

    def __call__(self, x: np.ndarray) -> np.ndarray:
        self.count += 1
        return self.g(x, self.time) - x


def quasi_newton(*, differences: bool) -> Callable[[Counted, np.ndarray, np.ndarray], np.ndarray]:
    """The master's iteration; without `differences`, its first matrix is that of g = 0."""
    newton = QuasiNewton()

    def solve(residual: Counted, x: np.ndarray, scale: np.ndarray) -> np.ndarray:
        def jacobian(x: np.ndarray, r: np.ndarray, again: bool) -> np.ndarray:
            if not differences and not again:
                return -np.eye(len(x))
            columns = []
            for k in range(len(x)):
                moved = x.copy()
                moved[k] += DIFFERENCE * scale[k]
                columns.append((residual(moved) - r) / (DIFFERENCE * scale[k]))
            return np.array(columns).T

        return newton.solve(residual, jacobian, x, scale)

    return solve


def aitken(*, sweep: bool) -> Callable[[Counted, np.ndarray, np.ndarray], np.ndarray]:
    """Fixed-point iteration, relaxed by Aitken's factor, which is kept too.

    With `sweep` each value is found from those before it; that is one evaluation as well.
    """
    factor = 1.0

    def swept(residual: Counted, x: np.ndarray) -> np.ndarray:
        residual.count += 1
        found = x.copy()
        for k in range(len(x)):
            found[k] = residual.g(found, residual.time)[k]
        return found - x

    def solve(residual: Counted, x: np.ndarray, scale: np.ndarray) -> np.ndarray:
        nonlocal factor
        evaluate = (lambda x: swept(residual, x)) if sweep else residual
        r = evaluate(x) / scale
        for _ in range(LIMIT):
            if np.abs(r).max() <= TOLERANCE:
                return x
            x = x + factor * r * scale
            before, r = r, evaluate(x) / scale
            change = r - before
            factor *= -float(before @ change) / max(float(change @ change), 1e-300)
            if not np.isfinite(r).all():
                break
        raise NotConvergedError(0, float(np.abs(r).max()), LIMIT)

    return solve


METHODS = {
    "quasi-Newton, differences": lambda: quasi_newton(differences=True),
    "quasi-Newton, from the identity": lambda: quasi_newton(differences=False),
    "Aitken, all at once": lambda: aitken(sweep=False),
    "Aitken, one after the other": lambda: aitken(sweep=True),
}


def evaluations(make: Callable, g: Course, size: int) -> tuple[float, float] | None:
    """Evaluations at the first instant, and their mean at later ones; None if one fails."""
    solve, residual, x = make(), Counted(g), np.zeros(size)
    counts = []
    for k in range(INSTANTS):
        residual.time, residual.count = 0.1 * k, 0
        try:
            with np.errstate(all="ignore"):
                x = solve(residual, x, np.maximum(np.abs(x), 1.0))
        except (NotConvergedError, np.linalg.LinAlgError):
            return None
        counts.append(residual.count)
    return counts[0], float(np.mean(counts[1:]))


def added_mass(ratio: float) -> Course:
    """Unknown force and acceleration: a = f − cos t, f = −ratio a."""
    return lambda x, t: np.array([x[1] - np.cos(t), -ratio * x[0]])


def linear(rng: np.random.Generator) -> tuple[Course, int]:
    """A loop of 2 to 8 unknowns with gains of either sign, of spectral radius 0.1 to 10."""
    size = int(rng.integers(2, 9))
    gains = rng.normal(size=(size, size))
    gains *= 10 ** rng.uniform(-1, 1) / np.abs(np.linalg.eigvals(gains)).max()
    phases = rng.uniform(0, 2 * np.pi, size)
    return (lambda x, t: gains @ x + np.cos(t + phases)), size


NONLINEAR: dict[str, tuple[Course, int]] = {
    "cubic spring and added mass 2": (
        lambda x, t: np.array([x[1] - np.cos(t), -2 * x[0] - 0.5 * x[0] ** 3]),
        2,
    ),
    "quadratic drag": (
        lambda x, t: np.array([x[1] + np.cos(t), -3 * x[0] * abs(x[0])]),
        2,
    ),
    "saturation": (lambda x, t: np.array([3 * np.tanh(x[1]) + t, -2 * x[0]]), 2),
    "exponential": (lambda x, t: np.array([np.exp(-x[1]) + t, 2 * x[0]]), 2),
}


def main() -> None:
    """Print evaluations, first and later, for each kind of loop."""
    rng = np.random.default_rng(1)
    cases: dict[str, list[tuple[Course, int]]] = {
        **{f"added mass, ratio {ratio:g}": [(added_mass(ratio), 2)] for ratio in RATIOS},
        "200 linear": [linear(rng) for _ in range(200)],
        **{name: [case] for name, case in NONLINEAR.items()},
    }
    for what, loops in cases.items():
        print(what)
        for name, make in METHODS.items():
            found = [evaluations(make, g, size) for g, size in loops]
            good = [counts for counts in found if counts]
            first, later = np.mean(good, axis=0) if good else (np.nan, np.nan)
            solved = f"{len(good)} of {len(loops)}"
            print(f"  {name:<32} solved {solved:<11} first {first:5.1f}, later {later:5.1f}")


if __name__ == "__main__":
    main()
