"""Records of many seeds of one sea, their local maxima, and Rice's distribution of these."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtr

from m4e_adapters.hydrodynamics.config import SpectrumTable
from m4e_adapters.hydrodynamics.config.waves import WaveSection
from m4e_adapters.hydrodynamics.seas.from_sections import wave_systems
from m4e_adapters.hydrodynamics.seas.system_seas import components_of
from m4e_adapters.hydrodynamics.seas.water.kinematics import Components
from m4e_adapters.hydrodynamics.seas.waves import relative_spectrum

STEP, COARSE, PIECES = 0.25, 15.0, 40  # s, s, pieces of a record of ten minutes
DURATION = COARSE * PIECES
PEAK = 2 * math.pi / 7.5
LEVELS = (-1.0, 0.0, 1.0, 2.0, 3.0)  # standard deviations


@dataclass(frozen=True)
class Spectrum:
    """JONSWAP of Hs = 1 m and Tp = 7.5 s up to 2.5 peak frequencies, so that m4 exists."""

    omega: np.ndarray
    density: np.ndarray

    @classmethod
    def narrow(cls) -> Spectrum:
        ratio = np.concatenate([np.linspace(0.5, 2.5, 250), [2.5001]])
        form = np.array([relative_spectrum(r, 3.3) for r in ratio.tolist()])
        form[-1] = 0.0
        return cls(ratio * PEAK, form / np.trapezoid(form, ratio * PEAK) / 16.0)

    def moment(self, k: int) -> float:
        return float(np.trapezoid(self.omega**k * self.density, self.omega))

    def section(self, folder: Path, **keys: Any) -> SpectrumTable:
        """The section of its file, which is written to `folder`."""
        pairs = zip(self.omega.tolist(), self.density.tolist(), strict=True)
        rows = "\n".join(f"{w!r},{s!r}" for w, s in pairs)
        (folder / "narrow.csv").write_text(f"omega,density\n{rows}\n")
        return SpectrumTable.model_validate({"spectrum": "table", "file": "narrow.csv", **keys})


def of_seed(section: WaveSection, seed: int, folder: Path = Path()) -> Components:
    changed = section.model_copy(update={"seed": seed})
    return components_of(wave_systems(changed, depth=math.inf, gravity=9.81, folder=folder), {})


def record(waves: Components, *, step: float = STEP) -> np.ndarray:
    """Ten minutes of elevation [m] at the origin: Re Σ (a e^{i(ω t_i + φ)}) e^{iω t_j}."""
    coarse = np.exp(1j * (np.outer(COARSE * np.arange(PIECES), waves.omega) + waves.phase))
    fine = np.exp(1j * np.outer(waves.omega, step * np.arange(round(COARSE / step))))
    return np.real((waves.amplitude * coarse) @ fine).ravel()


def gaussian_records(spectrum: Spectrum, count: int, *, step: float = STEP) -> Iterator[np.ndarray]:
    """Records of a Gaussian process of that spectrum: ten minutes of a period of 84 minutes, by
    the Fourier transform of complex normal numbers. Our components have no part in it."""
    rng = np.random.default_rng(2024)
    samples = round(5040.0 / step)
    omega = 2 * math.pi / (samples * step) * np.arange(samples // 2 + 1)
    density = np.interp(omega, spectrum.omega, spectrum.density, left=0.0, right=0.0)
    scale = 0.5 * samples * np.sqrt(density * (omega[1] - omega[0]))
    for _ in range(count):
        normal = rng.standard_normal((2, len(omega)))
        series = np.fft.irfft(scale * (normal[0] + 1j * normal[1]), samples)
        yield series[: round(DURATION / step)]


def maxima(elevation: np.ndarray) -> np.ndarray:
    """Local maxima [m] of a record, at the tops of parabolas through three samples.

    Of a maximum and a minimum closer than a step both are missed: of 112 in ten minutes 0.6
    with steps of 0.25 s, and a sixth of that with steps of 0.1 s.
    """
    before, here, after = elevation[:-2], elevation[1:-1], elevation[2:]
    top = (here >= before) & (here > after)
    a, b, c = before[top], here[top], after[top]
    return b + 0.125 * (a - c) ** 2 / (2 * b - a - c)


def rice_above(level: float, m0: float, m2: float, m4: float) -> float:
    """Share of the local maxima above `level` standard deviations (S. O. Rice, "Mathematical
    analysis of random noise", Bell System Technical Journal 24, 1945; Cartwright and Longuet-
    Higgins, 1956), ε² = 1 − m2²/(m0 m4)."""
    narrow = m2 / math.sqrt(m0 * m4)
    width = math.sqrt(1 - narrow**2)
    return float(
        ndtr(-level / width) + narrow * math.exp(-0.5 * level**2) * ndtr(level * narrow / width)
    )


def beyond(value: np.ndarray, expected: float) -> float:
    """How many standard errors the mean of independent values (n,) is off."""
    return float((value.mean() - expected) / (value.std(ddof=1) / math.sqrt(len(value))))
