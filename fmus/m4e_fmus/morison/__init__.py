"""FMU of slender members: `kind: morison`. Equations and variables: README.md here."""

from __future__ import annotations

from pathlib import Path

from m4e_adapters.hydrodynamics.stability_report import stability_text
from m4e_adapters.morison import MorisonConfig, members_in_waves, morison_program
from m4e_adapters.morison.shown import displaced_by, shown
from m4e_adapters.morison.stability import stability_of
from m4e_fmus.water import kind_in_water


def _stability(config: MorisonConfig, *, folder: Path) -> str:  # noqa: ARG001
    """Hydrostatics and righting arms of bodies on their members."""
    return (
        stability_text(stability_of(config), config.water)
        or "no body has buoyant members in the water"
    )


KIND = kind_in_water(
    MorisonConfig,
    build=morison_program,
    scene=shown,
    response=members_in_waves,
    displaced=lambda config, **_: displaced_by(config),
    stability=_stability,
)
