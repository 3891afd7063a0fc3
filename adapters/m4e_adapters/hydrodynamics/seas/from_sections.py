"""From the sections of a configuration, and their files, to systems of waves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
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
    Tma,
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
    Samples,
    read_components,
    read_density,
    read_record,
)
from m4e_adapters.hydrodynamics.seas.waves import (
    TAPERED,
    component_frequencies,
    component_phases,
    depth_factor,
    energy_below,
    part_edges,
    record_components,
    spread,
    table_edges,
)
from m4e_fmi.errors import InputError, Problem

LARGEST_MEAN = 0.05
"""Mean over standard deviation that is no doubt."""
NEAR, LARGEST_SHARE = 0.8, 1e-3
"""Part of the highest frequency of a record; share of the energy above it that is no doubt."""
SPIKE = 6.0
"""Standard deviations from the mean beyond which a row is doubted: a crest of 1.5 Hs."""


def record_doubts(name: str, record: Samples) -> Iterator[str]:
    """Lines on what may be wrong with the record in the file `name`."""
    values = record.elevation
    mean, deviation = float(values.mean()), float(values.std())
    if abs(mean) > LARGEST_MEAN * deviation:
        yield (
            f"the mean of {name}, {mean:.3g} m, is left out (its standard deviation is "
            f"{deviation:.3g} m): z = 0 is the still-water level"
        )
    yield from _of_rows(name, record)
    omega, amplitudes, _ = record_components(record)
    energy = 0.5 * float(amplitudes @ amplitudes)
    yield from _of_origin(name, record)
    near = omega > NEAR * math.pi / record.interval
    share = 0.5 * float(amplitudes[near] @ amplitudes[near]) / energy
    if share > LARGEST_SHARE:
        yield (
            f"{name} has {100 * share:.2g} % of its energy in waves of less than 2.5 rows: away "
            f"from its place about {100 * math.sqrt(share):.2g} % of the elevation is wrong: give "
            "shorter steps, or filter it"
        )


def _of_rows(name: str, record: Samples) -> Iterator[str]:
    """Lines on spikes, and on values that do not change for longer than a wave."""
    values = record.elevation - record.elevation.mean()
    deviations = np.abs(values) / values.std()
    far = int(np.sum(deviations > SPIKE))
    if far:
        row = int(deviations.argmax())
        rows = "a row" if far == 1 else f"{far} rows"
        yield (
            f"{name} has {rows} beyond {SPIKE:g} standard deviations, the farthest "
            f"{record.elevation[row]:.4g} m at t = {_time(record, row):g} s: correct spikes, and "
            "marks of missing values"
        )
    waves = int(np.sum((values[:-1] < 0.0) & (values[1:] >= 0.0)))
    ends = np.flatnonzero(np.diff(values)) + 1  # first rows of other values
    if waves and len(ends) > 1:
        longest = int(np.diff(ends).argmax())
        first, last = int(ends[longest]), int(ends[longest + 1]) - 1
        if (last - first) * waves > len(values):
            yield (
                f"the elevation of {name} is {record.elevation[first]:.4g} m from t = "
                f"{_time(record, first):g} to {_time(record, last):g} s, longer than a wave: if "
                "values are missing there, give the part before or after them"
            )


def _of_origin(name: str, record: Samples) -> Iterator[str]:
    """A line on the record's origin of time."""
    start, length = record.start, len(record.elevation) * record.interval
    if abs(start) > 0.5 * record.interval:
        yield (
            f"{name} begins at t = {start:g} s and repeats itself: at t = 0 s the sea is that of "
            f"{-start % length:g} s after its first row: for runs from 0 s on, subtract {start:g} "
            "from its times"
        )


def record_ends(name: str, record: Samples, *, lost: float) -> str:
    """A line on the ends of the record, which take the share `lost` [1] of its energy."""
    length = len(record.elevation) * record.interval
    start, tapered = record.start, TAPERED * length
    return (
        f"{name} is {length:g} s long, repeats itself, and is tapered to 0 for {tapered:g} s at "
        f"each end: that takes {100 * lost:.2g} % of its energy: for statistics of the measured "
        f"sea, take t = {start + tapered:g} to {start + length - tapered:g} s"
    )


def _time(record: Samples, row: int) -> float:
    return record.start + row * record.interval


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
    depth, gravity = common["depth"], common["gravity"]
    factor: Callable[[np.ndarray], np.ndarray] | None = None
    if isinstance(section, Tma):
        if math.isinf(depth):
            remedy = "give water.depth, or write spectrum: jonswap, which it is in deep water"
            raise InputError.single("a TMA sea needs a depth", remedy, keys=("waves",))
        factor = partial(depth_factor, depth=depth, gravity=gravity)
    enhancement = section.peak_enhancement if isinstance(section, Jonswap) else None
    edges = part_edges(
        2 * math.pi / section.peak_period,
        section.components,
        enhancement=1.0 if enhancement is None else enhancement,
        factor=factor,
    )
    rng = np.random.Generator(np.random.PCG64(section.seed))
    omega = component_frequencies(edges, rng)
    widths = np.diff(edges)
    return SpectralSea(
        **common,
        omega=omega,
        phases=component_phases(section.components, rng),
        offsets=_offsets(section, rng),
        luck=_luck(section, rng),
        widths=widths if factor is None else widths * factor(omega),
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
    deviation = float(record.elevation.std())
    kept = 0.5 * float(energy[-1]) / deviation**2
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
        remarks=tuple(record_doubts(section.file, record)),
        notes=(record_ends(section.file, record, lost=1.0 - kept),),
    )
