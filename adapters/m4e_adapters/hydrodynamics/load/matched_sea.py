"""The waves of a configuration with the coefficients and drifts for each of their directions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from m4e_adapters.hydrodynamics.coefficients import Coefficients
from m4e_adapters.hydrodynamics.config import AnyWaves, Still
from m4e_adapters.hydrodynamics.drift.bodies import matched_drifts
from m4e_adapters.hydrodynamics.drift.matching import is_fixed
from m4e_adapters.hydrodynamics.drift.recording import Drifting
from m4e_adapters.hydrodynamics.drift.tables import BodyDrift
from m4e_adapters.hydrodynamics.heading import Heading
from m4e_adapters.hydrodynamics.seas.excitation import towards_each
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem


@dataclass(frozen=True)
class MatchedSea:
    """The `systems` of waves, with `directed` coefficients for each, and `drifts` by body name.

    The `heading` and the systems' directions are fixed where these are known for single directions
    only.
    """

    systems: tuple[WaveSystem, ...]
    directed: tuple[Coefficients, ...]
    drifts: Mapping[str, Drifting]
    heading: Heading


def matched_sea(
    coefficients: Coefficients,
    *,
    waves: AnyWaves | None,
    drift: Mapping[str, BodyDrift],
    heading: Heading,
    folder: Path,
    progress: Callable[[str], object],
) -> MatchedSea:
    """The sea of `waves` (None: still water) for hulls of `coefficients`; files are in `folder`.

    InputError for directions that the coefficients or drifts are not for.
    """
    systems = wave_systems(
        waves or Still(spectrum="still"),
        depth=coefficients.depth,
        gravity=coefficients.gravity,
        folder=folder,
        band=(float(coefficients.omega[0]), float(coefficients.omega[-1])),
    )
    drifts = matched_drifts(drift, coefficients, systems, heading, progress)
    directed = towards_each(
        coefficients, systems, heading=heading.angle, turns=heading.filter_time is not None
    )
    of_single = bool(systems) and coefficients.of_single_directions
    if of_single or any(map(is_fixed, drifts.values())):
        heading = replace(heading, fixed=True)
        systems = tuple(replace(system, fixed=True) for system in systems)
    return MatchedSea(tuple(systems), tuple(directed), drifts, heading)
