"""FMU of the undisturbed sea: `kind: sea`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.hydrodynamics.seas.shown_water import floor_of, shown_water
from m4e_adapters.sea import SeaConfig, sea_program
from m4e_adapters.sea.waves_at_points import PointWaves, sea_in_waves
from m4e_fmi.program import Program
from m4e_fmi.report.animation.shown import Shown

Config = SeaConfig


def make(
    config: SeaConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured sea as a Program; files of waves are looked for in `folder`."""
    return sea_program(config, name=name, folder=folder, progress=progress)


def make_in_waves(
    config: SeaConfig,
    *,
    name: str,
    folder: Path,
    highest: float,  # noqa: ARG001  part of every kind's interface
    progress: Callable[[str], object] = print,
) -> tuple[Program, PointWaves]:
    """The sea with what waves do at its points as inputs, and what that is."""
    return sea_in_waves(config, name=name, folder=folder, progress=progress)


def scene(config: SeaConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """The water, with waves for `values` of their parameters at the start."""
    water = shown_water(config.water, config.waves, folder=folder, values=values)
    return Shown(water=water, floor=floor_of(config.water))
