"""Systems of waves: spectra, tables, components and records of one's own, spreading, several."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from m4e_adapters.hydrodynamics.config import Jonswap, PiersonMoskowitz
from m4e_adapters.hydrodynamics.config.waves import AnyWaves
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.systems import WaveSystem
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components
from m4e_adapters.sea import SeaConfig
from m4e_fmi.files.document import Document

WIND = {"significant_height": 2.5, "peak_period": 8.0, "seed": 5}


def systems(
    waves: AnyWaves, *, depth: float = math.inf, folder: Path = Path()
) -> tuple[WaveSystem, ...]:
    return wave_systems(waves, depth=depth, gravity=9.81, folder=folder)


def components(waves: AnyWaves, *, depth: float = math.inf, folder: Path = Path()) -> Components:
    return components_of(systems(waves, depth=depth, folder=folder), {})


def from_text(text: str, folder: Path) -> Components:
    config = Document.parse(f"dimensions: 3\nwaves: {text}\n").validate(SeaConfig)
    return components(config.waves, folder=folder)


def height(waves: Components) -> float:
    return 4.0 * math.sqrt(0.5 * float(waves.amplitude @ waves.amplitude))


def test_the_form_of_two_parameters_has_two_names() -> None:
    peaked, same = (
        components(PiersonMoskowitz(spectrum=name, **WIND)).amplitude
        for name in ("pierson_moskowitz", "bretschneider")
    )
    np.testing.assert_array_equal(peaked, same)


def test_a_spectrum_in_a_file_has_its_energy_over_either_frequency(tmp_path: Path) -> None:
    """Of two peaks, none between them."""
    rows = np.array([[0, 0], [0.4, 0], [0.5, 2], [0.6, 0], [1, 0], [1.2, 1], [1.4, 0], [2, 0]])
    turn, found = 2 * math.pi, []
    for name, scale in (("omega", [1, 1]), ("frequency", [1 / turn, turn])):
        text = "".join(f"{w!r},{s!r}\n" for w, s in (rows * scale).tolist())
        (tmp_path / "s.csv").write_text(f"{name},density\n{text}")
        waves = from_text("{spectrum: table, file: s.csv, seed: 4}", tmp_path)
        assert height(waves) == pytest.approx(4 * math.sqrt(0.2 + 0.2), rel=1e-12)
        low = waves.omega < 0.8
        assert 0.5 * np.sum(waves.amplitude[low] ** 2) == pytest.approx(0.2, rel=1e-9)
        found.append(waves.amplitude)
    np.testing.assert_allclose(*found, rtol=1e-6)
    text = "{spectrum: table, file: s.csv, significant_height: 4}"
    assert height(from_text(text, tmp_path)) == pytest.approx(4.0, rel=1e-12)


def test_components_of_ones_own_by_list_and_by_file(tmp_path: Path) -> None:
    listed = from_text(
        "{spectrum: components, direction: 10, seed: 2, components: [{amplitude: 1, period: 9, "
        "phase: 0.5}, {amplitude: 0.4, omega: 1.5, direction: 40}]}",
        tmp_path,
    )
    np.testing.assert_allclose(listed.omega, [2 * math.pi / 9, 1.5])
    np.testing.assert_allclose(listed.amplitude, [1.0, 0.4])
    np.testing.assert_allclose(np.degrees(listed.direction), [10.0, 40.0])
    assert listed.phase[0] == 0.5
    drawn = np.random.Generator(np.random.PCG64(2)).uniform(0.0, 2 * math.pi, 2).tolist()
    assert listed.phase[1] == drawn[1]
    (tmp_path / "c.csv").write_text(
        f"omega,amplitude,direction,phase\n{2 * math.pi / 9!r},1,10,0.5\n1.5,0.4,40,{drawn[1]!r}\n"
    )
    read = from_text("{spectrum: components, direction: 10, file: c.csv}", tmp_path)
    for name in ("omega", "amplitude", "direction", "phase"):
        np.testing.assert_allclose(getattr(read, name), getattr(listed, name), rtol=1e-15)


@pytest.mark.parametrize("exponent", [2.0, 10.0, 75.0])
def test_spreading_is_recovered(exponent: float) -> None:
    """Mean direction within 2°, spreading √(2/(1 + s)) within 5 %, for ten seeds, and of the
    parts around the peak alone within twice that."""
    for seed in range(10):
        section = Jonswap.model_validate(
            {"spectrum": "jonswap", **WIND, "seed": seed, "direction": 30.0,
             "spreading": {"exponent": exponent}}
        )  # fmt: skip
        waves = components(section)
        for part, times in ((slice(None), 1), (slice(60, 120), 2)):
            energy = waves.amplitude[part] ** 2
            first = np.sum(energy * np.exp(1j * waves.direction[part])) / energy.sum()
            spread = math.sqrt(2 * (1 - abs(first)))
            assert np.degrees(np.angle(first)) == pytest.approx(30.0, abs=2.0 * times)
            assert spread == pytest.approx(math.sqrt(2 / (1 + exponent)), rel=0.05 * times)
