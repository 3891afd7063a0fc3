"""FMU of slender members: `kind: morison`. Equations and variables: README.md here."""

from __future__ import annotations

from m4e_adapters.morison import MorisonConfig, members_in_waves, morison_program
from m4e_adapters.morison.shown import shown
from m4e_fmus.water import kind_in_water

KIND = kind_in_water(
    MorisonConfig,
    build=morison_program,
    scene=shown,
    response=members_in_waves,
)
