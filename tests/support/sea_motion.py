"""Random mooring lines whose fairlead follows a sea, in internal steps around the longest ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from support.lines_in_waves import lines_of, mooring_of
from support.static_lines import Line, random_line

from m4e_adapters.moordyn import Mooring
from m4e_adapters.moordyn.moordyn_system import MooringError
from m4e_adapters.moordyn.mooring import FREE_STEP
from m4e_adapters.moordyn.stability import MARGIN

STEP = 0.05  # [s] of the coupling
WAVES = 8
SHORTEST = 2e-4  # [s] longest internal step of a line that is worth the time of a campaign
OFF = 0.01  # of the range, rms: a run that failed is so far from one in short steps


@dataclass(frozen=True)
class Moored:
    """A line, its mooring, and the components of a sea.

    `sea` has rows of amplitude [m] along x and z, frequency [rad/s] and two phases.
    """

    line: Line
    made: Mooring
    sea: np.ndarray


def random_mooring(rng: np.random.Generator) -> Moored:
    """A line of 5 to 60 segments, damped by 0.5 to 3 of critical, any drag; a sea of 2 to 6 m.

    Every third is of fibre: light and soft.
    """
    while True:
        line = replace(random_line(rng), segments=int(rng.integers(5, 61)))
        if rng.random() < 1 / 3:
            weight = 1025 * math.pi * line.diameter**2 / 4 * rng.uniform(1.02, 1.4)
            line = replace(line, mass=weight, stiffness=10 ** rng.uniform(5.5, 7.5))
        ratio, drag = 10 ** rng.uniform(-0.3, 0.5), rng.uniform(1.0, 2.5)
        axial = float(rng.choice([0.0, 0.4]))
        bed = 10 ** rng.uniform(5.0, 6.0)
        text = line.text.replace("damping_ratio: 1", f"damping_ratio: {ratio!r}")
        drags = f"drag_coefficient: {drag!r}, axial_drag_coefficient: {axial!r}"
        text = text.replace("drag_coefficient: 1.2", drags)
        text += f"solver: {{scheme: {rng.choice(['RK2', 'RK4'])}}}\nseabed: {{damping: {bed!r}}}\n"
        omega = 2 * math.pi / rng.uniform(6, 11) * rng.uniform(0.7, 1.8, WAVES)
        height = rng.uniform(2, 6) / 4 * math.sqrt(2 / WAVES)
        phases = rng.uniform(0, 2 * math.pi, (2, WAVES))
        sea = np.array([*[height * rng.uniform(0.5, 1.2, WAVES) for _ in range(2)], omega, *phases])
        made = mooring_of(text)
        if SHORTEST < made.time_step < MARGIN * FREE_STEP:
            return Moored(line, made, sea)


def holds(moored: Moored, *, share: float, short: np.ndarray) -> bool:
    """True if steps of `share` of the longest give about the tensions of `short` steps.

    By root mean square: a snap is over in some internal steps.
    """
    found = tensions(moored, share=share, duration=STEP * len(short))
    if len(found) < len(short):
        return False
    return float(np.sqrt(np.mean((found - short) ** 2))) <= OFF * float(np.ptp(short))


def tensions(moored: Moored, *, share: float, duration: float) -> np.ndarray:
    """Tensions [N] at the fairlead, with steps of `share` of the longest, until MoorDyn fails."""
    longest = share * moored.made.time_step / MARGIN
    system = lines_of(moored.made, share=share, time_step=longest)
    found = []
    try:
        system.start([_place(moored, 0.0)], [(0.0, 0.0)])
        for k in range(round(duration / STEP)):
            (x0, z0), (x1, z1) = _place(moored, k * STEP), _place(moored, (k + 1) * STEP)
            system.advance(k * STEP, STEP, [(x0, z0)], [((x1 - x0) / STEP, (z1 - z0) / STEP)])
            found.append(system.tensions()[0][0])
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
