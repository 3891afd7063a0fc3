"""Convergence studies of bodies with exact solutions: computed anew, or from tests/data.

`make verify` computes them (tests/verify/test_refined_coefficients.py); `pytest --update` there
writes the tables anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from m4e_adapters.hydrodynamics import Coefficients, Hull, Refinement, make_hull, solve_hulls
from m4e_adapters.hydrodynamics.config import Body, Water
from m4e_adapters.hydrodynamics.refinement import COARSE, FINE, study
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency

DATA = Path(__file__).parents[1] / "data" / "hydrodynamics" / "refined"
RADIUS, RHO, G = 5.0, 1000.0, 9.81
BED, APART, SUNK = 15.0, 20.0, 7.5  # m: depth of the piles, distance of two, depth of the sphere


@dataclass(frozen=True)
class Case:
    """Bodies of these `shapes`, `panels` of each divided by `finer`², in waves of these k a [1].

    Those in water of a `depth` [m] stand on the sea bed: they are fixed, but we look at their
    forces.
    """

    shapes: tuple[dict, ...]
    panels: int
    ka: tuple[float, ...]
    depth: float = math.inf
    finer: tuple[int, ...] = FINE

    @property
    def wavenumbers(self) -> np.ndarray:
        """Those of the waves, (nω,) [1/m]."""
        return np.array(self.ka) / RADIUS

    @property
    def omega(self) -> np.ndarray:
        """Their angular frequencies, (nω,) [rad/s]."""
        return angular_frequency(self.wavenumbers, depth=self.depth, gravity=G)

    @property
    def water(self) -> Water:
        """The water that the bodies are in."""
        return Water(density=RHO, gravity=G, depth=self.depth)


def _pile(x: float) -> dict:
    return {"cylinder": {"radius": RADIUS, "draft": BED, "center_x": x}}


CASES = {
    "hemisphere": Case(
        ({"sphere": {"radius": RADIUS}},), 50, (0.1, 0.3, 0.5, 0.7, 1.0, 1.3, 1.6, 2.0)
    ),
    "submerged_sphere": Case(
        ({"sphere": {"radius": RADIUS, "center_z": -SUNK}},),
        62,
        (0.1, 0.3, 0.5, 0.7, 1.0, 1.3, 1.6, 2.0),
    ),
    "pile": Case((_pile(0.0),), 50, (0.3, 0.6, 1.0, 1.5), BED),
    "two_piles": Case((_pile(-APART / 2), _pile(APART / 2)), 48, (0.3, 0.6, 1.0, 1.4), BED, COARSE),
}


def computed(name: str, progress: Callable[[str], object] = print) -> Refinement:
    """The study of a case, by the solver."""
    case = CASES[name]
    meshes = [_hulls(case, finer) for finer in case.finer]
    found = [
        solve_hulls(hulls, water=case.water, omega=case.omega, progress=progress)
        for hulls in meshes
    ]
    return study([sum(len(h.panels.faces) for h in hulls) for hulls in meshes], found)


def _hulls(case: Case, finer: int = 1) -> list[Hull]:
    hulls = []
    for k, shape in enumerate(case.shapes):
        ((_, keys),) = shape.items()
        x = keys.get("center_x", 0.0)
        on_bed = math.isfinite(case.depth)
        given = {"shape": shape, "panels": case.panels}
        given |= {"fixed": True} if on_bed else {"center_of_gravity": [x, -2.0]}
        hull = make_hull(
            f"body{k}",
            Body.model_validate(given),
            Path(),
            depth=case.depth,
            finer=finer,
            progress=_silent,
        )
        hulls.append(replace(hull, fixed=False, center=(x, -case.depth / 2)) if on_bed else hull)
    return hulls


def _silent(_: str) -> None:
    pass


def stored(name: str) -> Refinement:
    """The study of a case with the tables of tests/data."""
    rows = np.loadtxt(DATA / f"{name}.csv", delimiter=",")
    panels = sorted(set(rows[:, 0].astype(int).tolist()))
    return study(panels, [_read(rows[rows[:, 0] == count], CASES[name]) for count in panels])


def _read(rows: np.ndarray, case: Case) -> Coefficients:
    n = 3 * len(case.shapes)
    resolved, omega, table = rows[0, 1], rows[:, 2], rows[:, 3:]
    a, b = (table[:, k * n * n : (k + 1) * n * n].reshape(-1, n, n) for k in (0, 1))
    real, imaginary = table[:, 2 * n * n :].reshape(-1, 2, n).swapaxes(0, 1)
    hulls = _hulls(case)
    finite = np.isfinite(omega)
    return Coefficients(
        bodies=tuple(hull.name for hull in hulls),
        centers=np.array([hull.center for hull in hulls]),
        omega=omega[finite],
        added_mass=a[finite],
        radiation_damping=b[finite],
        added_mass_inf=a[~finite][0],
        excitation=(real + 1j * imaginary)[finite],
        hydrostatic_stiffness=np.zeros((n, n)),
        buoyancy=np.zeros(n),
        density=RHO,
        depth=case.depth,
        gravity=G,
        resolved=(float(resolved),) * len(hulls),
    )


def write(name: str, found: Refinement) -> None:
    """The table of a study, in tests/data."""
    lines = [
        "# panels, frequency that they resolve [rad/s], omega [rad/s], added mass by rows, damping "
        "by rows, excitation: real and imaginary parts; SI; surge, heave, pitch"
    ]
    for count, c in zip(found.panels, found.meshes, strict=True):
        zero = np.zeros_like(c.added_mass_inf)
        tables = [*zip(c.omega, c.added_mass, c.radiation_damping, c.excitation, strict=True)]
        for omega, a, b, x in [*tables, (math.inf, c.added_mass_inf, zero, 0j * c.excitation[0])]:
            numbers = [*a.ravel(), *b.ravel(), *x.real, *x.imag]
            head = [count, f"{min(c.resolved):.6g}", f"{omega:.10g}"]
            lines.append(",".join([*map(str, head), *(f"{v:.8g}" for v in numbers)]))
    DATA.mkdir(exist_ok=True)
    (DATA / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def largest(values: np.ndarray | Sequence[float]) -> float:
    """The largest magnitude of `values` (…) in their units."""
    return float(np.abs(values).max())
