"""Waves of a component."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Discriminator, Field

from m4e_adapters.hydrodynamics.config.numbers import Finite, NotNegative, Positive
from m4e_fmi.files.document import Section

PEAK_ENHANCEMENT = (1.0, 10.0)


class _Waves(Section):
    """Direction and ramp, which all waves have."""

    direction: Finite = 0.0
    ramp_time: NotNegative | None = None


class _Irregular(_Waves):
    significant_height: Positive
    peak_period: Positive
    seed: Annotated[int, Field(ge=0)] = 0
    components: Annotated[int, Field(ge=10, le=1000)] = 300


class Jonswap(_Irregular):
    """JONSWAP sea: `significant_height` [m], `peak_period` [s], `peak_enhancement` γ [1].

    `seed` chooses frequencies and phases, of which `components` there are so many. `direction`
    [deg] is 0 (waves travel towards +X) or 180, in space any angle from +X towards +Y. The sea
    grows smoothly from nothing within `ramp_time` [s], default two peak periods.
    """

    spectrum: Literal["jonswap"]
    peak_enhancement: Annotated[float, Field(ge=PEAK_ENHANCEMENT[0], le=PEAK_ENHANCEMENT[1])] = 3.3


class PiersonMoskowitz(_Irregular):
    """Pierson-Moskowitz (Bretschneider) sea: `significant_height` [m], `peak_period` [s].

    `seed`, `components`, `direction` [deg] and `ramp_time` [s] as of JONSWAP.
    """

    spectrum: Literal["pierson_moskowitz"]


class Regular(_Waves):
    """One wave: elevation at x = 0 is `height`/2·cos(2π t/`period` + `phase`), in m, s, rad.

    `direction` [deg] is 0 or 180, in space any; `ramp_time` [s] is two periods by default.
    """

    spectrum: Literal["regular"]
    height: Positive
    period: Positive
    phase: Finite = 0.0


class Still(Section):
    """No waves."""

    spectrum: Literal["still"]


Waves = Annotated[Jonswap | PiersonMoskowitz | Regular | Still, Discriminator("spectrum")]
