"""FMU of the undisturbed sea: `kind: sea`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from m4e_adapters.hydrodynamics.seas.shown_water import shown_sea
from m4e_adapters.sea import SeaConfig, sea_in_waves, sea_program
from m4e_fmi.report.animation.shown import Shown
from m4e_fmus.water import kind_in_water


def _scene(config: SeaConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """The water, with waves for `values` of their parameters at the start."""
    return shown_sea(config.water, config.waves, folder=folder, values=values)


KIND = kind_in_water(SeaConfig, build=sea_program, scene=_scene, response=sea_in_waves)
