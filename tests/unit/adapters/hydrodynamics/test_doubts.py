"""Seas that break, and hulls of an absurd size, are told with both numbers."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics import build
from m4e_adapters.hydrodynamics.config import HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.doubts import size_doubts, stability_doubts
from m4e_adapters.hydrodynamics.geometry.mesh import make_hulls
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.steepness import breaking_heights
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_fmi.files.document import Document

BODY = "float: {shape: {box: {length: 8, width: 6, draft: 3}}, center_of_gravity: [0, -1]}"


def config(waves: str, *, depth: str = "deep", bodies: str = BODY) -> HydrodynamicsConfig:
    text = f"water: {{depth: {depth}}}\nbodies:\n  {bodies}\nwaves: {{{waves}}}\n"
    return Document.parse(text).validate(HydrodynamicsConfig)


def systems(given: HydrodynamicsConfig) -> tuple[WaveSystem, ...]:
    water = given.water
    return wave_systems(given.waves, depth=water.depth, gravity=water.gravity)


def sea(waves: str, depth: str = "deep") -> list[str]:
    found = systems(config(waves, depth=depth))
    return [text for system in found for text in system.doubts({})]


def breaking_height(period: float, water: Water) -> float:
    omega = np.array([2 * math.pi / period])
    return float(breaking_heights(omega, depth=water.depth, gravity=water.gravity)[0])


def sizes(waves: str, bodies: str) -> list[str]:
    given = config(waves, bodies=bodies)
    hulls = make_hulls(given, Path(), progress=lambda _: None)
    return list(size_doubts(hulls, given, systems(given)))


def test_breaking_heights_at_the_limits() -> None:
    """Deep: a seventh of the length g T²/2π. Shallow: 0.78 of the depth."""
    deep = 0.142 * 9.81 * 8.0**2 / (2 * math.pi)
    assert breaking_height(8.0, Water()) == pytest.approx(deep, rel=1e-12)
    assert breaking_height(8.0, Water(depth=2000.0)) == pytest.approx(deep, rel=1e-9)
    assert breaking_height(20.0, Water(depth=3.0)) == pytest.approx(2.34, rel=1e-12)


@pytest.mark.parametrize(
    ("spectrum", "depth", "words"),
    [
        ("jonswap, significant_height: 6, peak_period: 12", "7", ["6 m is above 5.46 m", "7 m of"]),
        ("jonswap, significant_height: 15, peak_period: 8", "deep", ["15 m is above 14.2 m"]),
        ("jonswap, significant_height: 7, peak_period: 8", "deep", ["0.0701", "0.0667", "DNV"]),
        ("pierson_moskowitz, significant_height: 15, peak_period: 15", "deep", ["0.0427", "0.04 "]),
        ("regular, height: 15, period: 8", "deep", ["the wave height of 15 m", "14.2 m"]),
        ("regular, height: 2.5, period: 20", "3", ["2.5 m is above 2.34 m", "3 m of water"]),
    ],
)
def test_a_sea_that_breaks_is_told(spectrum: str, depth: str, words: list[str]) -> None:
    (told,) = sea(f"spectrum: {spectrum}", depth)
    for word in words:
        assert word in told


@pytest.mark.parametrize(
    ("spectrum", "depth"),
    [
        ("still", "1"),
        ("jonswap, significant_height: 6.6, peak_period: 8", "deep"),
        ("jonswap, significant_height: 14, peak_period: 15", "deep"),
        ("jonswap, significant_height: 5.4, peak_period: 12", "7"),
        ("regular, height: 14, period: 8", "deep"),
    ],
)
def test_a_sea_that_there_is_is_not(spectrum: str, depth: str) -> None:
    assert sea(f"spectrum: {spectrum}", depth) == []


def test_hulls_of_absurd_size_are_told() -> None:
    def box(length: float) -> str:
        return BODY.replace("length: 8", f"length: {length}")

    still = "spectrum: still"
    assert sizes(still, BODY) == []
    assert sizes("spectrum: regular, height: 0.1, period: 2", box(500)) == []
    (told,) = sizes(still, box(5000))
    assert told == (
        "the hull of body 'float' measures 5000 m, hulls have 0.01 to 1000 m: lengths are in m"
    )
    (told,) = sizes("spectrum: regular, height: 0.01, period: 1", box(200))
    assert "measures 200 m, the waves are 1.561 m long" in told
    tiny = "tiny: {shape: {sphere: {radius: 0.05, center_x: 200}}, center_of_gravity: [200, 0]}"
    (told,) = sizes(still, f"{box(150)}\n  {tiny}")
    assert "'float' measures 150 m, that of 'tiny' 0.1001 m" in told


def test_a_mesh_in_millimetres_is_told(tmp_path: Path) -> None:
    """A box of 8 m as GDF, Z up, drawn in mm."""
    given = config("spectrum: still")
    (hull,) = make_hulls(given, tmp_path, progress=lambda _: None)
    corners = 1000.0 * hull.panels.corners.reshape(-1, 3)
    rows = "\n".join(" ".join(f"{x:.9g}" for x in corner) for corner in corners)
    count = len(hull.panels.faces)
    (tmp_path / "hull.gdf").write_text(f"box\n1 9.81\n0 0\n{count}\n{rows}\n")
    mesh = config(
        "spectrum: still",
        bodies=BODY.replace("{box: {length: 8, width: 6, draft: 3}}", "{mesh: hull.gdf}"),
    )
    hulls = make_hulls(mesh, tmp_path, progress=lambda _: None)
    (told,) = size_doubts(hulls, mesh, ())
    assert "measures 8000 m, hulls have 0.01 to 1000 m" in told
    assert "drawn in mm must be scaled by 0.001" in told
    assert np.isfinite(hulls[0].hydrostatics.volume)


def test_a_build_tells_them_before_it_computes(monkeypatch: pytest.MonkeyPatch) -> None:
    """And how many panels there are, of which the error of the coefficients is."""
    told: list[str] = []
    monkeypatch.setattr(build, "solve_hulls", lambda *_, **__: told.append("computed"))
    steep = config(
        "spectrum: jonswap, significant_height: 7, peak_period: 8",
        bodies=BODY.replace("length: 8", "length: 2000"),
    )
    build.coefficients_from_config(steep, folder=Path(), progress=told.append)
    sea_line, size_line, _, panels_line, last = told
    assert sea_line.startswith("warning: the sea is too steep")
    assert size_line.startswith("warning: the hull of body 'float' measures 2000 m")
    assert re.fullmatch(
        r"body 'float': displaces \S+ m3, lowest point \S+ m below the water, \d+ panels; to "
        r"estimate their error, compute with about \d+ panels too: it is 0.6 of the difference in "
        r"added mass, and 1.2 of that in added mass at infinite frequency",
        panels_line,
    )
    assert last == "computed"


def test_a_hull_that_capsizes_is_told() -> None:
    """GM of a box: l²/(12 d) - d/2 - z_G = 16/9 - 3/2 - z_G, about the waterplane's middle."""
    for place in (0.0, 50.0):
        for z in (0.2, 0.4):
            given = config(
                "spectrum: still",
                bodies="float: {shape: {box: {length: 8, width: 6, draft: 3, "
                f"center_x: {place}}}}}, center_of_gravity: [{place}, {z}]}}",
            )
            (hull,) = make_hulls(given, Path(), progress=lambda _: None)
            height = 16 / 9 - 1.5 - z
            assert hull.hydrostatics.metacentric_height(hull.center) == pytest.approx(height)
            told = list(stability_doubts([hull], given.water))
            assert len(told) == (height < 0)
            for text in told:
                assert f"(GM = {height:.3g} m)" in text
                assert f"{1025 * 9.81 * 144 * height:.4g} N.m/rad" in text


def test_a_build_tells_the_hydrostatics(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "solve_hulls", lambda *_, **__: None)
    lines: list[str] = []
    build.coefficients_from_config(config("spectrum: still"), folder=Path(), progress=lines.append)
    assert (
        "body 'float': displaces 144 m3, neutral mass 147600 kg; centre of buoyancy at x = 0, "
        "z = -1.5 m; waterplane 48 m2, GM 1.28 m" in lines
    )
