"""Random mooring lines whose fairlead follows a sea, at given internal steps of MoorDyn."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from support.lines_in_waves import lines_of
from support.static_lines import Line, random_line

from m4e_adapters.moordyn import Mooring, MooringConfig, mooring
from m4e_adapters.moordyn.moordyn_system import MooringError
from m4e_adapters.moordyn.mooring import FREE_STEP
from m4e_adapters.moordyn.stability import MARGIN
from m4e_fmi.files.document import Document

STEP = 0.05  # [s] of the coupling
WAVES = 8
SHORTEST = 4e-4  # [s] longest stable step of a line that is worth the time of a campaign
OFF = 0.05  # of the range: how far a run that failed is off from one in short steps


@dataclass(frozen=True)
class Moored:
    """A line, its mooring, the longest stable internal step [s], and the sea's components.

    `sea` has rows of amplitude [m] along x and z, frequency [rad/s] and two phases.
    """

    line: Line
    made: Mooring
    longest: float
    sea: np.ndarray


def random_mooring(rng: np.random.Generator) -> Moored:
    """A line damped by 0.5 to 3 of critical, any drag; a sea of 2 to 6 m significant height."""
    while True:
        line, text = random_line(rng), ""
        ratio, drag = 10 ** rng.uniform(-0.3, 0.5), rng.uniform(1.0, 2.5)
        scheme = rng.choice(["RK2", "RK4"])
        bed = 10 ** rng.uniform(5.0, 6.0)
        text = line.text.replace("damping_ratio: 1", f"damping_ratio: {ratio!r}")
        text = text.replace("drag_coefficient: 1.2", f"drag_coefficient: {drag!r}")
        text += f"solver: {{scheme: {scheme}}}\nseabed: {{damping: {bed!r}}}\n"
        made = mooring(Document.parse(text).validate(MooringConfig))
        omega = 2 * math.pi / rng.uniform(6, 11) * rng.uniform(0.7, 1.8, WAVES)
        height = rng.uniform(2, 6) / 4 * math.sqrt(2 / WAVES)
        phases = rng.uniform(0, 2 * math.pi, (2, WAVES))
        sea = np.array([*[height * rng.uniform(0.5, 1.2, WAVES) for _ in range(2)], omega, *phases])
        if made.time_step / MARGIN > SHORTEST and made.time_step < FREE_STEP:
            return Moored(line, made, made.time_step / MARGIN, sea)


def holds(moored: Moored, *, share: float, short: np.ndarray) -> bool:
    """True if steps of `share` of the longest give about the tensions of `short` steps."""
    found = tensions(moored, share=share, duration=STEP * len(short))
    return len(found) == len(short) and np.abs(found - short).max() <= OFF * np.ptp(short)


def tensions(moored: Moored, *, share: float, duration: float) -> np.ndarray:
    """Tensions [N] at the fairlead, with steps of `share` of the longest, until MoorDyn fails."""
    made, step = moored.made, share * moored.longest
    system = lines_of(replace(made, time_step=step))
    found = []
    try:
        system.start([_place(moored, 0.0)], [(0.0, 0.0)])
        for k in range(round(duration / STEP)):
            (x0, z0), (x1, z1) = _place(moored, k * STEP), _place(moored, (k + 1) * STEP)
            system.advance(k * STEP, STEP, [(x0, z0)], [((x1 - x0) / STEP, (z1 - z0) / STEP)])
            found.append(system.fairlead_tension[0])
    except MooringError:
        pass  # what was found until then is told
    finally:
        system.close()
    return np.array(found)


def _place(moored: Moored, t: float) -> tuple[float, float]:
    """Where the fairlead is; led into the sea within 5 s, and down by 2 m into the water."""
    surge, heave, omega, first, second = moored.sea
    led = min(t / 5, 1.0) ** 2 * (3 - 2 * min(t / 5, 1.0))
    x = moored.line.span + led * float(surge @ np.sin(omega * t + first))
    return x, moored.line.high - 2 * led + led * float(heave @ np.sin(omega * t + second))
