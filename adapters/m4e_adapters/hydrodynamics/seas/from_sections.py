"""From the sections of a configuration, and their files, to systems of waves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TypedDict

import numpy as np

from m4e_adapters.hydrodynamics.config.waves import (
    AnyWaves,
    ComponentWaves,
    Jonswap,
    PiersonMoskowitz,
    Record,
    Regular,
    SpectrumTable,
    Still,
    WaveSection,
)
from m4e_adapters.hydrodynamics.seas.systems import (
    FEWEST,
    FixedSea,
    RegularWave,
    SpectralSea,
    WaveSystem,
)
from m4e_adapters.hydrodynamics.seas.wave_files import (
    read_components,
    read_density,
    read_record,
)
from m4e_adapters.hydrodynamics.seas.waves import (
    TAPERED,
    component_frequencies,
    component_phases,
    energy_below,
    part_edges,
    record_components,
    spread,
    table_edges,
)
from m4e_fmi.errors import InputError, Problem

RAMP_PERIODS = 2.0  # default length of the ramp in (peak) periods
REACH = 2.5  # peak frequencies up to which excitation is computed


class _Common(TypedDict):
    """Fields of every system."""

    name: str
    direction: float
    depth: float
    gravity: float


def wave_systems(
    waves: AnyWaves | Sequence[WaveSystem],
    *,
    depth: float,
    gravity: float,
    folder: Path = Path(),
) -> tuple[WaveSystem, ...]:
    """The systems of `waves` in water of `depth` [m], none if it is still; files are in `folder`.

    Systems that are made already stay. InputError with all problems of the sections and their
    files.
    """
    every = waves if isinstance(waves, Sequence) else (waves,)
    sections = [section for section in every if not isinstance(section, Still)]
    several = len(sections) > 1
    found: list[WaveSystem] = []
    problems: list[Problem] = []
    for k, section in enumerate(sections):
        common = _Common(
            name=f"wave[{k + 1}]" if several else "wave",
            direction=section.direction,
            depth=depth,
            gravity=gravity,
        )
        try:
            found.append(_system(section, common, folder))
        except InputError as error:
            problems += error.problems
    InputError.raise_for(problems)
    return tuple(found)


def _system(section: WaveSection | WaveSystem, common: _Common, folder: Path) -> WaveSystem:
    match section:
        case WaveSystem():
            return section
        case Jonswap() | PiersonMoskowitz():
            return _spectral(section, common)
        case Regular():
            return _regular(section, common)
        case SpectrumTable():
            return _table(section, common, folder)
        case ComponentWaves():
            return _components(section, common, folder)
        case Record():
            return _record(section, common, folder)


def _ramp(section: WaveSection, period: float) -> float:
    """The time [s] in which waves of a `period` [s] grow."""
    return RAMP_PERIODS * period if section.ramp_time is None else section.ramp_time


def _needed(omega: np.ndarray, amplitudes: np.ndarray) -> float:
    """Where 3 % of the energy is left [rad/s]."""
    order = np.argsort(omega)
    energy = np.cumsum(amplitudes[order] ** 2)
    return float(omega[order][np.searchsorted(energy, 0.97 * energy[-1])])


def _regular(section: Regular, common: _Common) -> RegularWave:
    omega = np.array([2 * math.pi / section.period])
    period = 2 * math.pi / float(omega[0])
    return RegularWave(
        **common,
        omega=omega,
        phases=np.array([section.phase]),
        offsets=np.zeros(1),
        period=period,
        ramp_time=_ramp(section, period),
        needed=float(omega[0]),
        regular=True,
        height=section.height,
        shortest=min(section.period, FEWEST),
    )


def _spectral(section: Jonswap | PiersonMoskowitz, common: _Common) -> SpectralSea:
    enhancement = section.peak_enhancement if isinstance(section, Jonswap) else None
    edges = part_edges(
        2 * math.pi / section.peak_period,
        section.components,
        enhancement=1.0 if enhancement is None else enhancement,
    )
    rng = np.random.Generator(np.random.PCG64(section.seed))
    omega = component_frequencies(edges, rng)
    return SpectralSea(
        **common,
        omega=omega,
        phases=component_phases(section.components, rng),
        offsets=_offsets(section, rng),
        luck=_luck(section, rng),
        widths=np.diff(edges),
        period=section.peak_period,
        ramp_time=_ramp(section, section.peak_period),
        needed=REACH * 2 * math.pi / section.peak_period,
        reach=f"{REACH:g} peak frequencies",
        significant_height=section.significant_height,
        enhancement=enhancement,
    )


def _offsets(
    section: Jonswap | PiersonMoskowitz | SpectrumTable, rng: np.random.Generator
) -> np.ndarray:
    if section.spreading is None:
        return np.zeros(section.components)
    return spread(section.components, section.spreading.exponent, rng)


def _luck(
    section: Jonswap | PiersonMoskowitz | SpectrumTable, rng: np.random.Generator
) -> np.ndarray:
    """Amplitudes over those that are expected (components,): Rayleigh's, their squares' mean 1."""
    if section.amplitudes == "fixed":
        return np.ones(section.components)
    return np.sqrt(rng.exponential(size=section.components))


def _table(section: SpectrumTable, common: _Common, folder: Path) -> FixedSea:
    density = read_density(section, folder)
    rng = np.random.Generator(np.random.PCG64(section.seed))
    edges = table_edges(density, section.components)
    omega = component_frequencies(edges, rng)
    amplitudes = np.sqrt(2.0 * np.diff(energy_below(density, edges)))
    if section.significant_height is not None:
        energy = section.significant_height**2 / 16.0
        amplitudes *= math.sqrt(2.0 * energy / np.sum(amplitudes**2))
    peak = 2 * math.pi / float(density.omega[density.density.argmax()] or edges[1])
    phases, offsets = component_phases(section.components, rng), _offsets(section, rng)
    drawn = amplitudes * _luck(section, rng)
    return FixedSea(
        **common,
        omega=omega,
        phases=phases,
        offsets=offsets,
        amplitudes=drawn,
        significant_height=4.0 * math.sqrt(0.5 * float(np.sum(amplitudes**2))),
        period=peak,
        ramp_time=_ramp(section, peak),
        needed=_needed(omega, drawn),
        scaled=True,
    )


def _components(section: ComponentWaves, common: _Common, folder: Path) -> FixedSea:
    given = read_components(section, folder)
    rng = np.random.Generator(np.random.PCG64(section.seed))
    drawn = component_phases(len(given), rng).tolist()
    omega = np.array([one.omega or 2 * math.pi / (one.period or math.nan) for one in given])
    amplitudes = np.array([one.amplitude for one in given])
    mean = section.direction
    turns = [0.0 if one.direction is None else one.direction - mean for one in given]
    phases = [
        random if one.phase is None else one.phase for one, random in zip(given, drawn, strict=True)
    ]
    period = 2 * math.pi / float(omega[amplitudes.argmax()])
    return FixedSea(
        **common,
        omega=omega,
        phases=np.array(phases),
        offsets=np.radians(turns),
        amplitudes=amplitudes,
        significant_height=4.0 * math.sqrt(0.5 * float(np.sum(amplitudes**2))),
        period=period,
        ramp_time=_ramp(section, period),
        needed=_needed(omega, amplitudes),
        apart=True,
    )


def _record(section: Record, common: _Common, folder: Path) -> FixedSea:
    record = read_record(section, folder)
    omega, amplitudes, phases = record_components(record)
    energy = np.cumsum(amplitudes**2)
    middle = float(omega[np.searchsorted(energy, 0.5 * energy[-1])])
    deviation, mean = float(record.elevation.std()), float(record.elevation.mean())
    kept = 0.5 * float(energy[-1]) / deviation**2
    length, start = len(record.elevation) * record.interval, record.start
    tapered = TAPERED * length
    note = (
        f"{section.file} is {length:g} s long from t = {start:g} s on, repeats itself, is taken "
        f"without its mean of {mean:.3g} m, and is tapered to 0 for {tapered:g} s at each end: "
        f"that takes {100 * (1.0 - kept):.2g} % of its energy: for statistics of the measured sea, "
        f"take t = {start + tapered:g} to {start + length - tapered:g} s"
    )
    return FixedSea(
        **common,
        omega=omega,
        phases=phases,
        offsets=np.zeros(len(omega)),
        amplitudes=amplitudes,
        significant_height=4.0 * deviation,
        period=2 * math.pi / middle,
        ramp_time=section.ramp_time or 0.0,
        needed=_needed(omega, amplitudes),
        tunable_phases=False,
        in_statistics=1.0 / math.sqrt(kept),
        place=(section.place[0], section.place[1] if len(section.place) > 1 else 0.0),
        notes=(note,),
    )
