"""The examples of wave-energy converters: coupled runs of them beside responses in small waves."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from m4e_fmi import load
from m4e_fmi.analysis import equilibrium, linearize
from m4e_fmi.analysis.response import wave_response
from m4e_fmi.cosim import load_system, run, system_in_waves

EXAMPLES = Path(__file__).parents[2] / "examples"
HEIGHT, RAMP = 0.02, 40.0  # m, s
SETTLED, WINDOW = (
    260.0,
    100.0,
)  # s, after which a motion is steady; at least so long it is looked at
STEP = 0.05  # s, the longest
SLOW = 0.05  # 1/s, of decays that are not over then


def copied(path: Path, folder: Path) -> Path:
    """The system file at `path`, in a copy of its folder."""
    shutil.copytree(path.parent, folder, dirs_exist_ok=True)
    return folder / path.name


def apart(path: Path, period: float, names: Sequence[str], folder: Path) -> list[float]:
    """Differences of first harmonics from their RAOs, by these: of a coupled run in small waves.

    The waves of the system file at `path` become regular ones of this `period` [s].
    """
    waves = system_in_waves(load_system(path), highest=2.0 * np.pi / 4.0)
    point = equilibrium(waves.program)
    response = wave_response(waves, point, periods=[period], outputs=list(names))
    poles = np.linalg.eigvals(linearize(waves.program, at=point).A)
    slow = poles[(np.abs(poles.real) < SLOW) & (poles.imag > SLOW)]
    windows = math.ceil(WINDOW / period)
    step = period / math.ceil(period / STEP)
    text = re.sub(
        r"waves: .*",
        f"waves: {{spectrum: regular, height: {HEIGHT}, period: 8, ramp_time: {RAMP}}}\n"
        f"    start: {{wave.period: {period!r}}}",
        path.read_text("utf-8"),
    )
    periods = math.ceil(SETTLED / period) + windows
    text = re.sub(
        "simulation: .*",
        f"simulation: {{stop_time: {periods * period!r}, step_size: {step!r}}}",
        text,
    )
    regular = path.with_name("regular.yaml")
    regular.write_text(text, "utf-8")
    results = folder / "regular.nc"
    run(regular, results=results, build_directory=folder / "build", certify=False)
    found = load(results)
    kept = found.time > (periods - windows) * period + 0.5 * step
    first = {
        name: _harmonic(found.time[kept], np.asarray(found[name].values)[kept], period, slow)
        for name in (*names, "hydro.wave.elevation")
    }
    elevation = first["hydro.wave.elevation"]
    assert abs(elevation) > 0.49 * HEIGHT
    rao = {name: complex(response.of(name).ravel()[0]) for name in names}
    return [abs(first[name] / elevation - rao[name]) / abs(rao[name]) for name in names]


def _harmonic(time: np.ndarray, values: np.ndarray, period: float, slow: np.ndarray) -> complex:
    """c of c e^{−iωt} in `values` (n,) at `time` (n,) [s], by least squares.

    Beside it are a mean, a drift, a second harmonic, and free motions of the poles `slow` (k,)
    [1/s], which are still there at the end.
    """
    phase = 2.0 * np.pi * time / period
    columns = [f(k * phase) for k in (1, 2) for f in (np.cos, np.sin)]
    columns += [np.ones_like(time), time - time.mean()]
    free = [np.exp(pole * (time - time[0])) for pole in slow]
    columns += [part for motion in free for part in (motion.real, motion.imag)]
    (real, imaginary, *_), *_ = np.linalg.lstsq(np.stack(columns, axis=1), values, rcond=None)
    return complex(real, imaginary)


def energy_lost(path: Path, folder: Path) -> float:
    """Largest energy that a connection of a coupled run makes or loses, of that exchanged [1]."""
    outcome = run(path, build_directory=folder / "build", certify=False)
    assert outcome.energy
    return max(abs(bond.relative) for bond in outcome.energy)
