"""Outputs of the load: wrenches and their parts, displacements, added mass."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from m4e_adapters.hydrodynamics.coefficients import NO_WATERPLANE, Coefficients
from m4e_adapters.hydrodynamics.geometry.motions import Motion, mass_unit
from m4e_adapters.hydrodynamics.heading import Axes
from m4e_adapters.hydrodynamics.load.parts import SMALL
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_fmi.program import Recorder, Scalar, Variable

HEAVE, TURN = 0.5, math.radians(15.0)  # limits: mean drafts, rad
OF_GAP = 0.25  # of the distance between bodies, whose waves feel it
OF_WAVE = 0.1  # of the wave length (at the peak): 36 deg of the phase


@dataclass(frozen=True)
class Range:
    """From `minimum` to `maximum` [m or rad]; `reason` tells both in words."""

    minimum: float = -math.inf
    maximum: float = math.inf
    reason: str = ""


def _drift(coefficients: Coefficients, k: int, waves: Sequence[WaveSystem]) -> Range:
    """The excitation is that at the reference place: a share of the shortest system's length.

    In still water a share of the distance to the nearest of several bodies; one body may go
    anywhere.
    """
    if waves:
        length = min(system.length for system in waves)
        limit = OF_WAVE * length
        reason = (
            f"the waves are those at the reference place, for motions within {OF_WAVE:g} of their "
            f"length of {length:.4g} m"
        )
        return Range(-limit, limit, reason)
    ways = np.delete(coefficients.places, k, axis=0) - coefficients.places[k]
    distances = [math.hypot(x, y) for x, y, _ in ways.tolist()]
    if not distances or min(distances) == 0.0:
        return Range()
    limit = OF_GAP * min(distances)
    reason = (
        f"bodies feel each other as in the reference pose, for motions within {OF_GAP:g} of their "
        f"distance of {min(distances):.4g} m"
    )
    return Range(-limit, limit, reason)


def _heave(coefficients: Coefficients, k: int) -> Range:
    """Up and down to half the mean draft (displaced volume over waterplane), or to the surface.

    A submerged body has no waterplane: it may rise, and sink, by the depth of its highest point.
    Nor may a body leave the water or reach the sea bed.
    """
    weight = coefficients.density * coefficients.gravity
    heave = k * coefficients.per_body + coefficients.heave
    waterplane = float(coefficients.hydrostatic_stiffness[heave, heave]) / weight
    volume = float(coefficients.buoyancy[heave]) / weight
    keel, top = coefficients.heights[k] if len(coefficients.heights) else (-math.inf, 0.0)
    if waterplane > NO_WATERPLANE * math.cbrt(volume) ** 2:
        limit = HEAVE * volume / waterplane
        reason = f"the water is linear, for motions within {HEAVE:g} of the mean draft"
    elif top < 0.0:
        limit = -top
        reason = f"the water is linear, its surface is {limit:.4g} m above the body"
    else:
        return Range()
    down = min(limit, coefficients.depth + keel) if math.isfinite(keel) else limit
    if down < limit:
        reason += f", and the sea bed {down:.4g} m below it"
    up = min(limit, -keel)
    if up < limit:
        reason += f", and the body leaves the water {up:.4g} m higher"
    return Range(-down, up, reason)


Vector = list[Scalar | float]


def record_displacement(
    recorder: Recorder,
    body: str,
    coefficients: Coefficients,
    displacement: Vector,
    k: int,
    waves: Sequence[WaveSystem],
) -> None:
    """Outputs surge, heave, pitch, … from the reference pose, with the limits of small motions."""
    reason = f"the water is linear, for motions within {math.degrees(TURN):g} deg"
    turn, drift = Range(-TURN, TURN, reason), _drift(coefficients, k, waves)
    limits = {"heave": _heave(coefficients, k), "surge": drift, "sway": drift}
    for motion, value in zip(coefficients.body_motions, displacement, strict=True):
        limit = limits.get(motion.name, turn)
        text = f"{motion.name} from the reference pose"
        if limit.reason:
            text += f"; {limit.reason}"
        variable = Variable(
            f"{body}.{motion.name}", motion.unit, text, minimum=limit.minimum, maximum=limit.maximum
        )
        recorder.output(variable, value)


PARTS = {
    "hydrostatic": "hydrostatics",
    "radiation": "radiation memory, without added_mass",
    "excitation": "wave excitation",
    "froude_krylov": "the undisturbed waves (Froude-Krylov), without diffraction",
    "diffraction": "wave diffraction, without Froude-Krylov's part",
    "drag": "quadratic drag",
    "drift": "second-order drift, differences of wave frequencies",
}


def record_outputs(
    recorder: Recorder,
    body: str,
    coefficients: Coefficients,
    parts: Mapping[str, Vector],
    axes: Axes | None,
    *,
    drifts: Sequence[Motion] = (),
) -> None:
    """The wrench on a body, the sum of its `parts` in their order, and these.

    Of the drift the parts in the motions `drifts`.
    """
    motions = coefficients.body_motions

    def in_world(vector: Vector) -> Vector:
        return axes.to_world(vector) if axes else vector

    wrench: Vector = [0.0] * len(motions)
    for part in parts.values():
        wrench = [total + value for total, value in zip(wrench, part, strict=True)]
    for motion, total in zip(motions, in_world(wrench), strict=True):
        symbol, unit = motion.force, motion.force_unit
        text = f"{symbol} of the water on {body} about its centre of gravity, world frame"
        recorder.output(Variable(f"{body}.{symbol}", unit, text), total)
    for kind, part in parts.items():
        for motion, value in zip(motions, in_world(part), strict=True):
            if kind == "drift" and motion not in drifts:
                continue
            symbol, unit = motion.force, motion.force_unit
            text = f"part of {body}.{symbol}: {PARTS[kind]}"
            recorder.output(Variable(f"{body}.{kind}_{symbol}", unit, text), value)


def publish_added_mass(
    recorder: Recorder,
    coefficients: Coefficients,
    matrix: np.ndarray,
    axes: Axes | None,
) -> None:
    """A∞, `matrix` (n, n) [kg, kg.m, kg.m2], in world axes.

    Connections read from the descriptions which bodies rows are for.
    """
    scale = np.sqrt(np.maximum(np.abs(matrix.diagonal()), 1e-300))
    kept = np.where(np.abs(matrix) > SMALL * np.outer(scale, scale), matrix, 0.0)
    in_world = axes.matrix_to_world(kept) if axes else kept.tolist()
    names, kinds = coefficients.motions, coefficients.body_motions * len(coefficients.bodies)
    for i, (row, values) in enumerate(zip(names, in_world, strict=True)):
        for j, (column, value) in enumerate(zip(names, values, strict=True)):
            variable = Variable(
                f"added_mass[{i + 1},{j + 1}]",
                mass_unit(kinds[i], kinds[j]),
                f"added mass at infinite frequency: {row} per acceleration in {column}",
            )
            recorder.calculate(variable, value)
