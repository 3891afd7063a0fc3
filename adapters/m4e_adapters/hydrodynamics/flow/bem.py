"""Potential flow: coefficients of hulls over a table of frequencies, each cached by content.

Each frequency is computed and kept by itself: an interrupted computation goes on where it was, and
frequencies that two tables have in common are computed once.

Froude-Krylov's part of the excitation: that of the undisturbed waves.

It is the part that Capytaine adds to the diffraction, summed over the same panels in the same way:
what is left of the excitation without it is the diffraction as it was solved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from importlib.metadata import version

import numpy as np
from numpy.typing import ArrayLike

from m4e_adapters.hydrodynamics.coefficients import MEMORY_REACH, Coefficients, memory_size
from m4e_adapters.hydrodynamics.config import Water
from m4e_adapters.hydrodynamics.flow import cache
from m4e_adapters.hydrodynamics.flow.capytaine_setup import import_capytaine
from m4e_adapters.hydrodynamics.flow.flow_solver import METHOD, FlowSolver, capytaine_body
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.motions import MOTIONS, SURGE, SWAY, YAW, point_in_space
from m4e_adapters.hydrodynamics.seas.water.kinematics import angular_frequency, wavenumber
from m4e_fmi.code_hash import package_hash

CODE = (
    "flow.cache",
    "flow.capytaine_setup",
    "flow.flow_solver",
    "geometry.motions",
    "geometry.panels",
)
"""Modules that the solution is of."""
LIBRARIES = ("capytaine", "numpy", "scipy")  # whose versions count
PANELS_PER_WAVELENGTH = 8  # panel radius below wavelength / 8: Capytaine's own rule
FELT = math.pi  # wavenumber times depth beyond which a panel feels less than 5 % of a wave
MOST_PANELS = 20_000  # of a built-in shape; more are not advised

Progress = Callable[[str], object]
Arrays = dict[str, np.ndarray]


def solve_hulls(
    hulls: Sequence[Hull],
    *,
    water: Water,
    omega: np.ndarray,
    wave_direction: float = 0.0,
    needed: float = math.inf,
    progress: Progress = print,
) -> Coefficients:
    """Coefficients of all hulls that move together, interactions with the fixed ones included.

    In space the excitation is computed for as many directions as its `harmonics` need.

    Parameters
    ----------
    omega : (nω,) angular frequencies [rad/s], increasing; ω = ∞ is always added.
    wave_direction : [deg], of `Coefficients.excitation`; 0 or 180 in the plane.
    needed : angular frequency [rad/s] up to which there are waves; panels too coarse for waves that
        neither come nor are radiated by their body are not warned of.
    progress : is told how far the solution is, and its warnings.
    """
    warn_of_coarse_panels(
        hulls, water=water, highest=float(omega[-1]), needed=needed, progress=progress
    )
    content = _content(hulls, water)
    frequencies = [*omega.tolist(), math.inf]
    directions = [wave_directions(hulls, water, w, wave_direction) for w in frequencies]
    questions = list(zip(frequencies, directions, strict=True))
    keys = [cache.content_key({**content, "omega": w, "directions": d}) for w, d in questions]
    found = [cache.found(key, progress) for key in keys]
    missing = [k for k, arrays in enumerate(found) if arrays is None]
    if count := len(keys) - len(missing):
        part = "" if not missing else f" of {count} of {len(keys)} frequencies"
        progress(f"potential flow: coefficients{part} taken from the cache")
    if missing:
        solver = FlowSolver(hulls, water)
        for number, k in enumerate(missing, start=1):
            progress(f"potential flow: frequency {number} of {len(missing)}")
            found[k] = arrays = solver.at(*questions[k])
            cache.keep(keys[k], arrays, progress)
    solutions = [arrays for arrays in found if arrays is not None]
    for text in dict.fromkeys(str(t) for arrays in solutions for t in arrays["warnings"]):
        progress(f"warning: capytaine: {text}")
    moving = moving_hulls(hulls)
    names, felt = ("added_mass", "radiation_damping"), felt_motions(moving)
    table = {
        name: felt.T @ np.array([arrays[name] for arrays in solutions]) @ felt for name in names
    }
    rings = [arrays["excitation"] @ felt for arrays in solutions[:-1]]
    return assembled(moving, water, omega, wave_direction, table, rings)


def without_flow(
    hulls: Sequence[Hull],
    *,
    water: Water,
    omega: np.ndarray,
    wave_direction: float = 0.0,
    rings: Sequence[np.ndarray] | None = None,
) -> Coefficients:
    """Coefficients with the hydrostatics alone, computed at once; those of the flow are 0.

    `omega` (nω,) [rad/s]; arguments as of `solve_hulls`. The excitation is that of `rings`
    (nβ, n) [N/m, N.m/m] at each frequency, as of `assembled`, if they are given.
    """
    moving = moving_hulls(hulls)
    n = sum(len(MOTIONS[len(hull.center)]) for hull in moving)
    nothing = np.zeros((len(omega) + 1, n, n))
    table = {"added_mass": nothing, "radiation_damping": nothing.copy()}
    rings = rings or [np.zeros((1, n), dtype=complex)] * len(omega)
    return assembled(moving, water, omega, wave_direction, table, rings)


def moving_hulls(hulls: Sequence[Hull]) -> list[Hull]:
    """Those that are not fixed."""
    return [hull for hull in hulls if not hull.fixed]


def wave_directions(
    hulls: Sequence[Hull], water: Water, omega: float, wave_direction: float
) -> list[float]:
    """Directions [deg] for which the excitation at `omega` [rad/s] is computed.

    In space as many, all around, as a function of the direction needs that is made of waves e^{ikr}
    from centres to places within r: its harmonics above k r + 5 (k r)^(1/3) are below 1e-6.
    """
    if math.isinf(omega):
        return []
    moving = moving_hulls(hulls)
    if len(moving[0].center) == 2:
        return [wave_direction]
    centers = [point_in_space(hull.center)[:2] for hull in moving]
    reach = max(
        float(np.linalg.norm(hull.panels.vertices[:, :2] - center, axis=1).max())
        for hull in hulls
        for center in centers
    )
    argument = reach * float(wavenumber(np.array(omega), depth=water.depth, gravity=water.gravity))
    order = math.ceil(argument + 5.0 * math.cbrt(argument) + 2.0)
    return np.linspace(0.0, 360.0, 2 * order + 1, endpoint=False).tolist()


def felt_motions(hulls: Sequence[Hull]) -> np.ndarray:
    """Motions (n,) that the water feels, by motions (n,): (n, n) [1, m].

    A body of revolution that turns about its axis does not move the water, though its panels would:
    its yaw is the motion of its axis about the centre of gravity.
    """
    motions = [(k, motion) for k, hull in enumerate(hulls) for motion in MOTIONS[len(hull.center)]]
    result = np.eye(len(motions))
    for k, hull in enumerate(hulls):
        if hull.axis is None or (k, YAW) not in motions:
            continue
        surge, sway, yaw = (motions.index((k, motion)) for motion in (SURGE, SWAY, YAW))
        x, y = np.subtract(hull.axis, hull.center[:2])
        result[[surge, sway, yaw], yaw] = -y, x, 0.0
    return result


def _content(hulls: Sequence[Hull], water: Water) -> dict[str, ArrayLike]:
    """All that the solution at a frequency depends on, but for frequency and directions."""
    content: dict[str, ArrayLike] = {
        "code": [package_hash(f"m4e_adapters.hydrodynamics.{name}") for name in CODE],
        "libraries": [f"{name} {version(name)}" for name in LIBRARIES],
        "method": METHOD,
        "water": [water.density, water.depth, water.gravity],
    }
    for k, hull in enumerate(hulls):
        content[f"center{k}"] = hull.center
        for part, panels in (("hull", hull.panels), ("lid", hull.lid)):
            if panels is not None:
                content[f"{part}{k}"] = panels.corners
    return content


def resolved_frequency(hull: Hull, water: Water) -> float:
    """Angular frequency [rad/s] of the shortest waves that all panels resolve which feel them."""
    panels = hull.panels
    shortest = 2 * math.pi / (PANELS_PER_WAVELENGTH * panels.radii)
    feels = shortest * -panels.corners[:, :, 2].max(axis=1) < FELT
    k = float(shortest[feels].min(initial=math.inf))
    return float(angular_frequency(k, depth=water.depth, gravity=water.gravity))


def warn_of_coarse_panels(
    hulls: Sequence[Hull], *, water: Water, highest: float, needed: float, progress: Progress
) -> None:
    """Warn of panels too coarse for waves that matter to their body.

    Those are waves up to `highest` [rad/s], but above what the body radiates (its memory limit)
    only those of the sea, up to `needed` [rad/s].
    """
    for hull in hulls:
        limit = resolved_frequency(hull, water)
        size = memory_size(hull.hydrostatics.volume, hull.hydrostatics.waterplane[0])
        radiates = math.sqrt(MEMORY_REACH * water.gravity / size)  # up to there
        matters = min(highest, max(radiates, needed))
        if matters <= limit:
            continue
        k, longest = (
            float(wavenumber(np.array(w), depth=water.depth, gravity=water.gravity))
            for w in (matters, limit)
        )
        radius = 2 * math.pi / (PANELS_PER_WAVELENGTH * longest)  # of those that feel such waves
        count = len(hull.panels.faces) * (k / longest) ** 2
        about = f" (about {float(f'{count:.2g}'):.0f})" if count <= MOST_PANELS else ""
        progress(
            f"warning: the panels of body {hull.name!r} (radius up to {radius:.3g}"
            f" m) are coarse for waves above {limit:.3g} rad/s, the highest that matter to it are "
            f"of {matters:.3g}: use more panels{about} or a lower frequencies.maximum"
        )


def assembled(
    hulls: Sequence[Hull],
    water: Water,
    omega: np.ndarray,
    wave_direction: float,
    arrays: dict[str, np.ndarray],
    rings: Sequence[np.ndarray],
) -> Coefficients:
    """Coefficients as computed, not made symmetric, with hydrostatics.

    Of `arrays`, `added_mass` and `radiation_damping` (nω + 1, n, n) are used, SI, the last at
    ω = ∞; `omega` (nω,) [rad/s]. `rings` are the excitation (nβ, n) [N/m, N.m/m] at each frequency,
    for nβ directions all around; one is that for `wave_direction`.
    """
    size = len(MOTIONS[len(hulls[0].center)])
    n = size * len(hulls)
    stiffness, buoyancy = np.zeros((n, n)), np.zeros(n)
    for k, hull in enumerate(hulls):
        own = slice(size * k, size * k + size)
        arguments = (hull.center, water.density, water.gravity)
        stiffness[own, own] = hull.hydrostatics.stiffness(*arguments)
        buoyancy[own] = hull.hydrostatics.buoyancy(*arguments)
    levels = [hull.panels.vertices[:, 2] for hull in hulls]
    result = Coefficients(
        bodies=tuple(hull.name for hull in hulls),
        centers=np.array([hull.center for hull in hulls]),
        omega=np.asarray(omega),
        added_mass=arrays["added_mass"][:-1],
        radiation_damping=arrays["radiation_damping"][:-1],
        added_mass_inf=arrays["added_mass"][-1],
        excitation=np.array([ring[0] for ring in rings]).reshape(-1, n),
        hydrostatic_stiffness=stiffness,
        buoyancy=buoyancy,
        wave_direction=wave_direction,
        density=water.density,
        depth=water.depth,
        gravity=water.gravity,
        resolved=tuple(resolved_frequency(hull, water) for hull in hulls),
        heights=tuple((float(z.min()), float(z.max())) for z in levels),
    )
    return result if result.dimensions == 2 else _with_harmonics(result, rings)


def _with_harmonics(coefficients: Coefficients, rings: Sequence[np.ndarray]) -> Coefficients:
    """The coefficients with the harmonics of `rings`, and the excitation that these make."""
    omega, most = coefficients.omega, max((len(ring) // 2 for ring in rings), default=0)
    harmonics = np.zeros((len(omega), 2 * most + 1, coefficients.added_mass_inf.shape[0]), complex)
    for k, ring in enumerate(rings):
        count = len(ring)
        ways = [coefficients.way(omega[k : k + 1], 360.0 * j / count)[0] for j in range(count)]
        orders = np.rint(np.fft.fftfreq(count, 1.0 / count)).astype(int)
        harmonics[k, most + orders] = np.fft.fft(ring * np.conj(ways), axis=0) / count
    beta = coefficients.wave_direction
    turns = np.exp(1j * np.radians(beta) * np.arange(-most, most + 1))
    excitation = np.einsum("khn,h->kn", harmonics, turns) * coefficients.way(omega, beta)
    return replace(coefficients, harmonics=harmonics, excitation=excitation)


WHOLE = ("froude_krylov", "diffraction")


def excited_by(
    coefficients: Coefficients, hulls: Sequence[Hull], parts: tuple[str, ...]
) -> Coefficients:
    """`coefficients`, solved for `hulls`, with those `parts` of the excitation alone."""
    if parts == WHOLE:
        return coefficients
    if not parts:
        return coefficients.without_excitation()
    c = coefficients
    water = Water(density=c.density, depth=c.depth, gravity=c.gravity)
    undisturbed = without_flow(
        hulls,
        water=water,
        omega=c.omega,
        wave_direction=c.wave_direction,
        rings=[*_rings(c, hulls, water)],
    )
    excitation, harmonics = undisturbed.excitation, undisturbed.harmonics
    if parts == ("diffraction",):
        excitation = coefficients.excitation - excitation
        harmonics = coefficients.harmonics - harmonics
    return replace(coefficients, excitation=excitation, harmonics=harmonics, excited_by=parts)


def _rings(c: Coefficients, hulls: Sequence[Hull], water: Water) -> Iterator[np.ndarray]:
    """The force (nβ, n) [N/m, N.m/m] at each frequency, in the directions of its solution."""
    body, felt = capytaine_body(import_capytaine(), hulls), felt_motions(hulls)
    x, y, z = np.asarray(body.mesh.faces_centers).T
    for omega in c.omega.tolist():
        k = float(wavenumber(np.array(omega), depth=c.depth, gravity=c.gravity))
        head = np.exp(k * z)
        if np.isfinite(c.depth):
            head = (head + np.exp(-k * (z + 2 * c.depth))) / (1 + np.exp(-2 * k * c.depth))
        ring = []
        for direction in np.radians(wave_directions(hulls, water, omega, c.wave_direction)):
            way = k * (x * np.cos(direction) + y * np.sin(direction))
            pressure = c.density * c.gravity * head * np.exp(1j * way)
            forces = body.integrate_pressure(pressure)
            ring.append([forces[name] for name in body.dofs])
        yield np.array(ring) @ felt
