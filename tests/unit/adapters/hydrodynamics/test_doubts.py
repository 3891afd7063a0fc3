"""What a build tells before it computes, and of a current that acts on nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.hulls import configured, hulls

from m4e_adapters.hydrodynamics import build
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig
from m4e_adapters.hydrodynamics.memory.radiation import RadiationMemory
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem

BODY = "float: {shape: {box: {length: 8, width: 6, draft: 3}}, center_of_gravity: [0, -1]}"
STILL = "spectrum: still"


def config(waves: str, *, depth: str = "deep", bodies: str = BODY) -> HydrodynamicsConfig:
    return configured(f"water: {{depth: {depth}}}\nbodies:\n  {bodies}\nwaves: {{{waves}}}\n")


def systems(given: HydrodynamicsConfig) -> tuple[WaveSystem, ...]:
    return wave_systems(given.waves, depth=given.water.depth, gravity=given.water.gravity)


def test_a_build_tells_doubts_and_hydrostatics_before_it_computes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told: list[str] = []
    monkeypatch.setattr(build, "solve_hulls", lambda *_, **__: told.append("computed"))
    steep = config("spectrum: jonswap, significant_height: 7, peak_period: 8")
    build.coefficients_from_config(steep, folder=Path(), progress=told.append)
    assert told[0].startswith("warning: the sea is too steep")
    assert told[-1] == "computed"
    assert (
        "body 'float': displaces 144 m3, neutral mass 147600 kg; centre of buoyancy at x = 0, "
        "z = -1.5 m; waterplane 48 m2, GM 1.28 m; lowest point 3 m below the water" in told[-2]
    )


def test_a_current_that_acts_on_nothing_is_told() -> None:
    text = f"bodies: {{{BODY.replace('[0, -1]', '[0, -1], drag: {heave: 1}')}}}\n"
    told: list[str] = []
    given = configured(f"{text}current: {{speed: 1}}\n")
    still = build.coefficients_of(given, hulls(given), omega=np.array([1.0, 2.0]), solved=False)
    build.program_of(
        given, still, name="hydro", folder=Path(), memory=RadiationMemory((), still.added_mass_inf),
        progress=told.append,
    )  # fmt: skip
    assert any("acts on nothing" in line for line in told)
