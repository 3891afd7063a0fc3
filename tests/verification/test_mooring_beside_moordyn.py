"""Forces of moved lines beside MoorDyn by itself, in steps of 0.5 ms.

Both start as the input says, without an equilibrium: lines drop first. MoorDyn's forces at the end
of a step are those of the mean velocity, which the axial dampers of a short segment feel.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import moordyn
import numpy as np
import pytest
from support.lines_in_waves import lines_of, mooring_of

from m4e_adapters.moordyn import Mooring, ready_mooring
from m4e_adapters.moordyn.moordyn_system import console_kept

DATA = Path(__file__).parents[1] / "data" / "moordyn"
CHAIN = """\
water: {density: 1025, depth: 60}
static_equilibrium: false
line_types:
  chain: {diameter: 0.1, mass_per_length: 60, axial_stiffness: 1.0e+8, axial_damping_ratio: 1,
          drag_coefficient: 1.2, added_mass_coefficient: 1}
"""
CATENARY = CHAIN + (
    "anchors: {a: [-150, -60]}\nfairleads: {f: [0, -3]}\n"
    "lines: {l: {type: chain, from: a, to: f, unstretched_length: LENGTH, segments: 12}}\n"
)
BETWEEN = CHAIN + (
    "fairleads: {f: [-20, -10], g: [20, -12]}\n"
    "lines: {l: {type: chain, from: f, to: g, unstretched_length: 55, segments: 12}}\n"
)
HEAD = """\
lines
----- LINE TYPES -----
name d m EA BA EI Cd Ca CdAx CaAx
- - - - - - - - - -
rope 0.1 20 2e7 -0.8 0 1.2 1 0.1 0
----- POINTS -----
id type x y z m v cda ca
- - - - - - - - -
1 Fixed -120 0 -60 0 0 0 0
2 Free -40 0 -40 CLUMP
3 Coupled 0 0 -10 0 0 0 0
----- LINES -----
id type a b length n out
- - - - - - -
1 rope 1 2 85 8 -
2 rope 2 3 52 6 -
----- OPTIONS -----
60 WtrDpth
0 TmaxIC
-----
"""
PERIOD = 7.5
DROPPED = 1.0  # [s] in which lines drop: of one case only they are compared


def circle(t: float, radius: float) -> tuple[float, float]:
    """(x, z) [m] of a circle into which a fairlead is led within 3 s."""
    s = min(t / 3, 1.0)
    radius *= s**3 * (10 - 15 * s + 6 * s * s)
    phase = 2 * math.pi * t / PERIOD
    return radius * math.sin(phase), radius * (math.cos(phase) - 1)


def path(made: Mooring, radius: float, k: int, t: float) -> tuple[float, ...]:
    """Where fairlead k is; the second moves against the first."""
    x, z = circle(t, radius if k == 0 else -radius)
    x0, *y0, z0 = made.fairleads[k].place
    return (x0 + x, *y0, z0 + z)


def velocity(at: Callable, k: int, t: float, h: float = 1e-5) -> tuple[float, ...]:
    """Of fairlead k [m/s], by central differences."""
    return tuple((b - a) / (2 * h) for a, b in zip(at(k, t - h), at(k, t + h), strict=True))


def ours(made: Mooring, at: Callable, h: float, stop: float) -> np.ndarray:
    """Forces (n, fairleads, 2) [N] at the ends of steps of h [s]."""
    lines, found, many = lines_of(made), [], range(len(made.fairleads))
    lines.start([at(k, 0.0) for k in many], [(0.0,) * len(at(0, 0.0))] * len(many))
    for i in range(round(stop / h)):
        here, then = ([at(k, (i + j) * h) for k in many] for j in (0, 1))
        speed = [
            tuple((q - p) / h for p, q in zip(*pair, strict=True))
            for pair in zip(here, then, strict=True)
        ]
        lines.advance(i * h, h, here, speed)
        lines.settle([velocity(at, k, (i + 1) * h) for k in many])
        found.append([(force[0], force[-1]) for force in lines.force])
    lines.close()
    return np.array(found)


def by_itself(made: Mooring, at: Callable, folder: Path, h: float, stop: float) -> np.ndarray:
    """The same by MoorDyn's `Step` alone, every `h`; forces are 0.25 ms late."""
    text = re.sub(r"^\S+ dtM$", "5e-4 dtM", made.text, flags=re.MULTILINE)
    (folder / "lines.txt").write_text(text)
    fine, found, many = 5e-4, [], range(len(made.fairleads))

    def vector(t: float) -> np.ndarray:
        places = (at(k, t) for k in many)
        return np.array([(p[0], made.fairleads[k].y, p[-1]) for k, p in enumerate(places)]).ravel()

    with console_kept():
        system = moordyn.Create(str(folder / "lines.txt"))
        moordyn.Init(system, vector(0.0), 0 * vector(0.0))
        for i in range(round(stop / fine)):
            a, b = vector(i * fine), vector((i + 1) * fine)
            force = moordyn.Step(system, a, (b - a) / fine, i * fine, fine)
            found.append(np.array(force).reshape(-1, 3)[:, ::2])
        moordyn.Close(system)
    each = round(h / fine)
    return np.array(found)[each - 1 :: each]


CASES = {
    "circle": (CATENARY.replace("LENGTH", "170"), 1.0),
    "snap": (CATENARY.replace("LENGTH", "163"), 3.0),
    "drop of a line": (CATENARY.replace("LENGTH", "170"), 0.0),
    "clump": (HEAD.replace("CLUMP", "800 0.1 0 0"), 1.5),
    "buoy": (HEAD.replace("CLUMP", "100 0.9 0.5 0.5"), 1.5),
    "line of two bodies": (BETWEEN, 2.0),
    "drifting body": (
        (DATA / "free_body_with_rod.txt").read_text("utf-8").replace("DT\n", "DT\n0 TmaxIC\n"),
        1.0,
    ),
}


@pytest.mark.verifies(
    "forces of lines on a circle, in a snap, dropped, with a clump, a buoy, a drifting body, and "
    "between two bodies",
    independent="MoorDyn's own steps of 0.5 ms",
    tolerance="1 % of range",
)
@pytest.mark.parametrize("case", CASES)
def test_lines_as_moordyn_moves_them(case: str, tmp_path: Path) -> None:
    text, radius = CASES[case]
    if "-----" in text:
        (tmp_path / "ready.txt").write_text(text)
        made = ready_mooring(tmp_path / "ready.txt", fairleads={})
    else:
        made = mooring_of(text)
    h, stop = 0.025, 12.0

    def at(k: int, t: float) -> tuple[float, ...]:
        return path(made, radius, k, t)

    dropped = 0 if case.startswith("drop") else round(DROPPED / h)
    found, expected = (
        run[dropped:] for run in (ours(made, at, h, stop), by_itself(made, at, tmp_path, h, stop))
    )
    error = np.abs(found - expected).max(axis=0) / np.ptp(expected, axis=0)
    assert (error < 0.01).all()
