"""FMU of linear hydrodynamics: `kind: hydrodynamics`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.hydrodynamics.build import (
    check_config,
    program_from_config,
    program_in_waves,
)
from m4e_adapters.hydrodynamics.coefficient_files.report import config_of_file, hydrodynamic_data
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.refinement import refinement, refinement_json
from m4e_adapters.hydrodynamics.seas.wave_forces import HullWaves
from m4e_adapters.hydrodynamics.shown import shown
from m4e_adapters.hydrodynamics.stability_report import (
    stability_of,
    stability_text,
)
from m4e_fmi.program import Program
from m4e_fmi.report.animation.shown import Shown
from m4e_fmi.report.drawing.space.hulls import Hull

__all__ = [
    "TAKES_LONG",
    "Config",
    "check",
    "config_of_file",
    "hydrodynamic_data",
    "make",
    "make_in_waves",
]

Config = HydrodynamicsConfig
TAKES_LONG = True


def check(config: HydrodynamicsConfig, *, folder: Path) -> Program:
    """The variables of the FMU, in a program without potential flow, within a second.

    InputError with all that is wrong with the configuration and its mesh files.
    """
    return check_config(config, folder=folder)


def make(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured load on all bodies as a Program; mesh files are looked for in `folder`."""
    return program_from_config(config, name=name, folder=folder, progress=progress)


def make_in_waves(
    config: HydrodynamicsConfig,
    *,
    name: str,
    folder: Path,
    highest: float,
    progress: Callable[[str], object] = print,
) -> tuple[Program, HullWaves]:
    """The load with the forces of waves as inputs, and what they are up to `highest` [rad/s]."""
    return program_in_waves(config, name=name, folder=folder, highest=highest, progress=progress)


def stability(config: HydrodynamicsConfig, *, folder: Path) -> str:
    """Hydrostatics and righting arms of all bodies as text."""
    return stability_text(stability_of(config, folder), config.water)


def scene(config: HydrodynamicsConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """The hulls and the water, with waves for `values` of their parameters at the start."""
    return shown(config, folder=folder, values=values)


def displaced(config: HydrodynamicsConfig, *, folder: Path) -> dict[str, dict[str, Hull]]:
    """Surfaces of the hulls that have buoyancy, by body and name, in the axes of the bodies."""
    if config.loads.hydrostatics != "linear":
        return {}
    hulls = drawn_hulls(config.bodies, folder)
    return {hull.name: {hull.name: hull.surface} for hull in hulls if not hull.fixed}


def refine(
    config: HydrodynamicsConfig, *, folder: Path, progress: Callable[[str], object] = print
) -> tuple[str, dict[str, object]]:
    """A convergence study of the coefficients, as text and as JSON.

    InputError for coefficients of a file.
    """
    study = refinement(config, folder=folder, progress=progress)
    return str(study), refinement_json(study)
