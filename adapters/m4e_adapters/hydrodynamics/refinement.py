"""Convergence study: coefficients of finer and finer panels, their limit, and their error.

The error of the direct method has a part of first order in the size h of the panels, that of the
edge at the waterline, and one of second order. Three meshes remove both:

    x(h) = x₀ + c₁ h + c₂ h²,  h = 1/√(number of panels)

The difference between x₀ and the limit that two meshes give with order 1.5, times `SAFETY`, is the
stated error of x₀; with the distance of x from x₀, it is that of x. At infinite frequency, where
the edge may rule, order 1 counts too, times `SAFETY_OF_EDGE`, unless the three meshes show an order
of at least 1.5. Two meshes alone give x₀ with order 1.5,
and its error from orders 1 and 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from pathlib import Path
from typing import TypedDict

import numpy as np

from m4e_adapters.hydrodynamics.build import coefficients_of, frequency_table
from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, make_hull, make_hulls, sliding_hulls
from m4e_fmi.errors import InputError

SAFETY, SAFETY_OF_EDGE = 1.5, 3.0
MIDDLE = 1.5  # order between that of the waterline's edge and that of the method
ORDERS = np.linspace(0.3, 4.0, 75)  # tried
COARSE, FINE = (1, 2, 3), (2, 3, 4)  # parts of a panel's side; the second if there are many
FEWEST = 48  # panels of a shape
MOST_PANELS = 4000  # of a finer mesh
SMALL = 1e-3  # of a coupling beside the motions that it couples: of no interest
NOISE = 1e-7  # of a coefficient's scale, by which meshes differ for no reason

Progress = Callable[[str], object]
TABLES = ("added_mass", "radiation_damping", "excitation")


@dataclass(frozen=True)
class Convergence:
    """Convergence of one table of coefficients, (n, n) of matrices and (n,) of excitation.

    Attributes
    ----------
    scale : largest value over the frequencies [SI]; of couplings that of the motions they couple.
    errors : (meshes, …) stated errors of each mesh [SI], their largest values over the frequencies.
    remaining : that of the limit [SI].
    order : observed order in the size of the panels [1]; nan where meshes do not differ.
    """

    scale: np.ndarray
    errors: np.ndarray
    remaining: np.ndarray
    order: np.ndarray

    @property
    def error(self) -> np.ndarray:
        """The stated error (n, n) or (n,) of the finest mesh [SI]."""
        return self.errors[-1]


class Row(TypedDict):
    """Convergence of one coefficient: its `largest` value [SI] over the frequencies.

    Stated `errors` of each mesh and the `error_of_limit`, over that value [1]; observed `order`
    [1], None where meshes do not differ.
    """

    quantity: str
    motions: str
    largest: float
    errors: list[float]
    error_of_limit: float
    order: float | None


@dataclass(frozen=True)
class Refinement:
    """Coefficients of two or three meshes, from the coarsest to the finest, and their limit.

    Attributes
    ----------
    panels : number of panels of each mesh, all bodies together.
    meshes : coefficients of each.
    limit : those extrapolated to panels of no size, in space for `wave_direction` only.
    highest : the frequency [rad/s] up to which errors are stated: the coarsest mesh resolves these
        waves.
    added_mass, radiation_damping, added_mass_inf, excitation : their convergence.
    """

    panels: tuple[int, ...]
    meshes: tuple[Coefficients, ...]
    limit: Coefficients
    highest: float
    added_mass: Convergence
    radiation_damping: Convergence
    added_mass_inf: Convergence
    excitation: Convergence

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> Iterator[str]:
        """The study as a table: a line for each coefficient that matters."""
        counts = ", ".join(map(str, self.panels))
        yield f"meshes of {counts} panels; errors up to {self.highest:.4g} rad/s, as stated, over"
        yield "the largest value of the limit; observed order in the size of the panels"
        heads = "".join(f" {count:>9}" for count in self.panels)
        yield f"{'':<42} {'largest':>11}{heads} {'limit':>9}  order"
        for row in self.rows():
            told = "    -" if row["order"] is None else f" {row['order']:4.2f}"
            every = (*row["errors"], row["error_of_limit"])
            errors = "".join(f" {100 * e:7.2g} %" for e in every)
            name = f"{row['quantity']} {row['motions']}"
            yield f"{name:<42} {row['largest']:11.5g}{errors} {told}"

    def rows(self) -> Iterator[Row]:
        """The convergence of each coefficient that matters."""
        names, table = self.limit.motions, self.limit.added_mass_inf
        for quantity in (*TABLES[:2], "added_mass_inf"):
            for i, j in combinations_with_replacement(range(len(names)), 2):
                pair = names[i] if i == j else f"{names[i]} - {names[j]}"
                both = math.sqrt(abs(table[i, i] * table[j, j]))
                if i == j or abs(table[i, j]) > SMALL * both:
                    yield self._row(quantity, pair, (i, j))
        for i, name in enumerate(names):
            yield self._row("excitation", name, (i,))

    def _row(self, quantity: str, motions: str, place: tuple[int, ...]) -> Row:
        found: Convergence = getattr(self, quantity)
        scale, order = float(found.scale[place]), float(found.order[place])
        return {
            "quantity": quantity,
            "motions": motions,
            "largest": scale,
            "errors": (found.errors[:, *place] / (scale or 1.0)).tolist(),
            "error_of_limit": float(found.remaining[place]) / (scale or 1.0),
            "order": None if math.isnan(order) else order,
        }


def refinement(
    config: HydrodynamicsConfig, *, folder: Path, progress: Progress = print
) -> Refinement:
    """The coefficients with fewer panels too, or with finer ones if there are mesh files.

    The finest mesh of built-in shapes has about their `panels`: the others take half of its work.
    With mesh files and unions the coarsest has those of a build. The curvature that they lack stays
    lacking. InputError as of a build, and for panels that resolve no wave of the table.
    """
    if config.coefficients is not None:
        raise InputError.single(
            f"coefficients of the file {config.coefficients!r} have no panels to refine",
            "give the bodies a 'shape' in place of 'coefficients'",
            keys=("coefficients",),
        )
    meshes = similar_hulls(config, folder, progress=progress)
    omega = frequency_table(config, meshes[-1], folder=folder)
    found: list[Coefficients] = []
    for hulls in meshes:
        progress(f"mesh of {_count(hulls)} panels")
        found.append(coefficients_of(config, hulls, omega=omega, progress=progress))
    return study([_count(hulls) for hulls in meshes], found)


def similar_hulls(
    config: HydrodynamicsConfig, folder: Path, *, progress: Progress
) -> list[list[Hull]]:
    """The hulls of all bodies with coarse panels, and with these divided; InputError."""
    given = make_hulls(config, folder, progress=progress)
    parts, bodies = COARSE, dict(config.bodies)
    if any(body.shape.kind in ("mesh", "union") for body in bodies.values()):
        count = sum(len(hull.panels.faces) for hull in given)
        parts = parts[: 3 if parts[-1] ** 2 * count <= MOST_PANELS else 2]
    else:
        if min(body.panels for body in bodies.values()) >= FEWEST * FINE[-1] ** 2:
            parts = FINE
        for name, body in bodies.items():
            fewer = round(body.panels / parts[-1] ** 2)
            bodies[name] = body.model_copy(update={"panels": fewer})
    depth = config.water.depth
    meshes = []
    for finer in parts:
        hulls = [
            make_hull(name, body, folder, depth=depth, finer=finer, progress=lambda _: None)
            for name, body in bodies.items()
        ]
        hulls, problems = sliding_hulls(hulls, bodies)
        InputError.raise_for(problems)
        meshes.append(hulls)
    return meshes


def _count(hulls: Sequence[Hull]) -> int:
    return sum(len(hull.panels.faces) for hull in hulls)


def study(panels: Sequence[int], meshes: Sequence[Coefficients]) -> Refinement:
    """The study of coefficients of meshes with these numbers of panels."""
    highest = min(float(np.min(meshes[0].resolved)), meshes[0].memory_limit)
    kept = meshes[0].omega <= highest
    if not kept.any():
        raise InputError.single(
            f"the mesh of {panels[0]} panels resolves waves up to {highest:.4g} rad/s only, the "
            f"frequencies begin at {meshes[0].omega[0]:.4g} rad/s",
            "use more panels",
        )
    sizes = 1.0 / np.sqrt(panels)
    limits, studies = {}, {}
    for name in (*TABLES, "added_mass_inf"):
        values = np.array([getattr(c, name) for c in meshes])
        edge = name == "added_mass_inf"
        limit, remaining = _limit(sizes, values, edge=edge)
        limits[name] = limit
        if edge:
            values, limit, remaining = values[:, None], limit[None], remaining[None]
        else:
            values, limit, remaining = values[:, kept], limit[kept], remaining[kept]
        studies[name] = _convergence(sizes, values, limit, remaining)
    limit = replace(meshes[-1], **limits, harmonics=np.zeros((0, 0, 0), dtype=complex))
    return Refinement(
        tuple(panels), tuple(meshes), limit, float(meshes[0].omega[kept][-1]), **studies
    )


def _limit(sizes: np.ndarray, values: np.ndarray, *, edge: bool) -> tuple[np.ndarray, np.ndarray]:
    """The limit of `values` (meshes, …) for panels of no size, and its stated error, in SI.

    The error of those that the `edge` at the waterline rules may be of first order alone, if their
    differences do not shrink faster.
    """
    powers = np.array([[1.0, MIDDLE, 2.0]]).T
    ratio = (sizes[-2] / sizes[-1]) ** powers.reshape(3, *(1,) * (values.ndim - 1)) - 1.0
    first, middle, second = values[-1] + (values[-1] - values[-2]) / ratio
    if len(sizes) == 2:
        return middle, SAFETY * np.abs(first - second)
    vandermonde = np.vander(sizes, 3, increasing=True)
    limit = np.tensordot(np.linalg.inv(vandermonde)[0], values, axes=1)
    if edge:
        apart = np.maximum(np.abs(limit - middle), np.abs(limit - first))
        steep = _order(sizes, values[:, None], np.abs(limit)) >= MIDDLE
        return limit, np.where(steep, SAFETY * np.abs(limit - middle), SAFETY_OF_EDGE * apart)
    return limit, SAFETY * np.abs(limit - middle)


def _convergence(
    sizes: np.ndarray, values: np.ndarray, limit: np.ndarray, remaining: np.ndarray
) -> Convergence:
    """That of `values` (meshes, frequencies, …) with their `limit` (frequencies, …) in SI."""
    largest = np.abs(limit).max(axis=0)
    if largest.ndim == 2:
        diagonal = np.sqrt(largest.diagonal())
        largest = np.maximum(largest, np.outer(diagonal, diagonal))
    errors = (np.abs(values - limit) + remaining).max(axis=1)
    order = _order(sizes, values, largest)
    return Convergence(largest, errors, remaining.max(axis=0), order)


def _order(sizes: np.ndarray, values: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The order p (…) [1] with which x₀ + c h^p fits `values` (3, frequencies, …) best."""
    spread = np.abs(values - values[-1]).max(axis=(0, 1))
    if len(sizes) < 3:
        return np.full(scale.shape, math.nan)
    misfits = []
    for power in ORDERS:
        basis = np.stack([np.ones(3), sizes**power], axis=1)
        across = np.eye(3) - basis @ np.linalg.pinv(basis)
        misfits.append((np.abs(np.tensordot(across, values, axes=1)) ** 2).sum(axis=(0, 1)))
    best = ORDERS[np.argmin(misfits, axis=0)]
    return np.where(spread > NOISE * scale, best, math.nan)
