"""FMU of linear hydrodynamics: `kind: hydrodynamics`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_adapters.hydrodynamics.build import check_config, program_from_config, program_in_waves
from m4e_adapters.hydrodynamics.coefficient_files.report import config_of_file, hydrodynamic_data
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.geometry.drawn_hulls import drawn_hulls
from m4e_adapters.hydrodynamics.refinement import refinement
from m4e_adapters.hydrodynamics.refinement_report import refinement_json
from m4e_adapters.hydrodynamics.shown import shown
from m4e_adapters.hydrodynamics.stability_report import stability_of, stability_text
from m4e_fmi.fmu import FmuKind
from m4e_fmi.report.drawing.hulls import Hull
from m4e_fmus.water import CHECKS


def _displaced(config: HydrodynamicsConfig, *, folder: Path) -> dict[str, dict[str, Hull]]:
    """Surfaces of the hulls that have buoyancy, by body and name, in the axes of the bodies."""
    if config.loads.hydrostatics != "linear":
        return {}
    hulls = drawn_hulls(config.bodies, folder)
    return {hull.name: {hull.name: hull.surface} for hull in hulls if not hull.fixed}


def _stability(config: HydrodynamicsConfig, *, folder: Path) -> str:
    """Hydrostatics and righting arms of all bodies as text."""
    return stability_text(stability_of(config, folder), config.water)


def _refinement(
    config: HydrodynamicsConfig, *, folder: Path, progress: Callable[[str], object] = print
) -> tuple[str, dict[str, object]]:
    """A convergence study of the coefficients, as text and as JSON.

    InputError for coefficients of a file.
    """
    study = refinement(config, folder=folder, progress=progress)
    return str(study), refinement_json(study)


KIND = FmuKind(
    HydrodynamicsConfig,
    build=program_from_config,
    takes_long=True,
    outline=check_config,
    scene=shown,
    response=program_in_waves,
    displaced=_displaced,
    stability=_stability,
    coefficients=hydrodynamic_data,
    config_of_file=config_of_file,
    refinement=_refinement,
    **CHECKS,
)
