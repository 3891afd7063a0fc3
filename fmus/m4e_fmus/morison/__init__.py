"""FMU of slender members: `kind: morison`. Equations and variables: README.md here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from m4e_adapters.hydrodynamics.stability_report import stability_text
from m4e_adapters.morison import MorisonConfig, members_in_waves, morison_program
from m4e_adapters.morison.shown import displaced_by, shown
from m4e_adapters.morison.stability import stability_of
from m4e_adapters.morison.waves import MemberWaves
from m4e_fmi.program import Program
from m4e_fmi.report.animation.shown import Shown
from m4e_fmi.report.drawing.hulls import Hull

Config = MorisonConfig


def make(
    config: MorisonConfig,
    *,
    name: str,
    folder: Path,
    progress: Callable[[str], object] = print,
) -> Program:
    """The configured members as a Program; files of waves are looked for in `folder`."""
    return morison_program(config, name=name, folder=folder, progress=progress)


def make_in_waves(
    config: MorisonConfig,
    *,
    name: str,
    folder: Path,
    highest: float,  # noqa: ARG001  part of every kind's interface
    progress: Callable[[str], object] = print,
) -> tuple[Program, MemberWaves]:
    """The members with what waves do to them as inputs, and what that is."""
    return members_in_waves(config, name=name, folder=folder, progress=progress)


def scene(config: MorisonConfig, *, folder: Path, values: Mapping[str, float]) -> Shown:
    """Members as cylinders, and the water, with waves for `values` at the start."""
    return shown(config, folder=folder, values=values)


def displaced(config: MorisonConfig, *, folder: Path) -> dict[str, dict[str, Hull]]:  # noqa: ARG001
    """Surfaces of the members that have buoyancy, by body and name, in the axes of the bodies."""
    return displaced_by(config)


def stability(config: MorisonConfig, *, folder: Path) -> str:  # noqa: ARG001
    """Hydrostatics and righting arms of bodies on their members."""
    return (
        stability_text(stability_of(config), config.water)
        or "no body has buoyant members in the water"
    )
