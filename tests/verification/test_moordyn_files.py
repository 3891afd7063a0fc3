"""Twelve MoorDyn files that have every keyword between them, each beside MoorDyn by itself.

The same file, internal step and motion: what is coupled moves along (1 - cos) of AMPLITUDE within
PERIOD. MoorDyn alone is called every DT with the mean velocity until then. The adapter takes steps
of 0.05 s, in which its parabola is (π 0.05/PERIOD)²/6 = 2e-4 of the motion off. Forces of the
masses of coupled rods follow the mean acceleration of a step, half a step late: with ω = 2 π/PERIOD
ω h/2 = 0.6 % of them for h = 0.01 s, which those cases take. MoorDyn adds the inertia of half a
segment to the force on a coupled body, and not to that on a coupled point. The rest of 1 % of the
range is left to ropes and vortices that remember their past, and to nodes that land.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import moordyn
import numpy as np
import pytest
from support.lines_in_waves import lines_of

from m4e_adapters.moordyn import Mooring, ready_mooring
from m4e_adapters.moordyn.line_system import LineSystem

DT, UNTIL = 0.001, 5.0  # [s]
AMPLITUDE, PERIOD = np.array([0.4, 0.2, -0.3]), 5.0  # [m], [s]
TOLERANCE = 0.01  # of the range
QUICK = ["0 TmaxIC", "0 writeLog", "1 disableOutput", "1 disableOutTime"]
ROPE = "rope 0.05 12 2e6 -0.8 0 1.2 1 0.1 0"
CAN = "can 0.6 150 0.6 1 1.2 1"
HEADS = "a row of names\na row of units"

Curve = str
CURVE: Curve = "a rope\nstrain tension\n- N\n0 0\n0.01 1.5e4\n0.05 1e5\n0.3 7e5"


@dataclass(frozen=True)
class Case:
    """A file by its tables; `poses` are MoorDyn's coupled objects at the start: 3 or 6 numbers."""

    tables: dict[str, list[str]]
    poses: list[list[float]] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)
    step: float = 0.05

    def write(self, folder: Path) -> Path:
        text = ["a MoorDyn v2 input file"]
        for title, rows in self.tables.items():
            heads = [] if title == "OPTIONS" else [HEADS]
            text += [f"--- {title} ---", *heads, *rows]
        text += ["--- OUTPUTS ---", "FairTen1", "--- need this line ---", ""]
        for name, content in self.files.items():
            (folder / name).write_text(content)
        (folder / "case.txt").write_text("\n".join(text))
        return folder / "case.txt"


def moved(t: float) -> np.ndarray:
    """How far what is coupled has moved [m] at t [s]."""
    return AMPLITUDE * (1 - math.cos(2 * math.pi * t / PERIOD)) / 2


def by_itself(path: Path, case: Case, lines: int, step: float) -> np.ndarray:
    """Forces on coupled objects, and the middles of lines, after each step; MoorDyn alone."""
    path = path.with_name("alone.txt")
    tables = dict(case.tables)
    tables["OPTIONS"] = [row for row in tables["OPTIONS"] if not row.endswith(("dtM", "CFL"))]
    tables["OPTIONS"] += [*QUICK, f"{step!r} dtM"]
    Case(tables, files=case.files).write(path.parent).rename(path)
    found, at = [], [c for pose in case.poses for c in pose]
    with contextlib.chdir(path.parent):
        system = moordyn.Create(str(path))
        # MoorDyn counts six numbers of a pinned body, and takes three
        spare = [0.0] * (moordyn.NCoupledDOF(system) - len(at))
        moordyn.Init(system, [*at, *spare], [0.0] * (len(at) + len(spare)))
        middles = [moordyn.GetLine(system, k + 1) for k in range(lines)]
        for k in range(round(UNTIL / DT)):
            begin, end = moved(k * DT), moved((k + 1) * DT)
            places, speeds = [], []
            for pose in case.poses:
                rest = [0.0] * (len(pose) - 3)
                places += [*(pose[:3] + begin), *pose[3:]]
                speeds += [*((end - begin) / DT), *rest]
            force = moordyn.Step(system, [*places, *spare], [*speeds, *spare], k * DT, DT)
            if (k + 1) % round(case.step / DT) == 0:
                nodes = [moordyn.GetLineNodePos(x, moordyn.GetLineN(x) // 2) for x in middles]
                found.append([*force[: len(at)], *(c for node in nodes for c in node)])
        moordyn.Close(system)
    return np.array(found)


def by_adapter(made: Mooring, case: Case) -> np.ndarray:
    """The same of the adapter, forces and moments of fairleads summed for each object."""
    lines = lines_of(made)
    start = np.array([f.place for f in made.fairleads]).reshape(-1, 3)
    lines.start([tuple(p) for p in start], [(0.0, 0.0, 0.0)] * len(start))
    found, h = [], case.step
    count = round(UNTIL / h)
    again, saved = count - 10, {}
    for k in [*range(count), *range(again, count)]:
        if k == again:
            if len(found) == count:
                lines.restore(saved)
            saved = lines.save()
        begin, end = moved(k * h), moved((k + 1) * h)
        places = [tuple(p) for p in start + begin]
        lines.advance(k * h, h, places, [tuple((end - begin) / h)] * len(start))
        found.append([*summed(lines, case, start + end, end), *middles_of(lines, made)])
    lines.close()
    assert found[count:] == found[again:count] or made.no_way_back
    return np.array(found[:count])


def summed(lines: LineSystem, case: Case, at: np.ndarray, away: np.ndarray) -> Iterable[float]:
    """Forces, and of poses moments, by the fairleads that are nearest in their order."""
    forces, k = np.array(lines.force).reshape(-1, 3), 0
    for pose, count in zip(case.poses, counts(case, len(forces)), strict=True):
        of_pose = slice(k, k + count)
        yield from forces[of_pose].sum(axis=0)
        if len(pose) > 3:
            arms = at[of_pose] - (pose[:3] + away)
            yield from np.cross(arms, forces[of_pose]).sum(axis=0)
        k += count


def counts(case: Case, fairleads: int) -> list[int]:
    """The number of fairleads of each pose: all that are left belong to the first of six."""
    six = [len(pose) > 3 for pose in case.poses]
    left = fairleads - six.count(False)
    return [left // max(six.count(True), 1) if is_six else 1 for is_six in six]


def middles_of(lines: LineSystem, made: Mooring) -> list[float]:
    segments = [int(row.split()[5]) for row in rows_of(made, "LINES")]
    nodes = [lines.node_position(k, count // 2) for k, count in enumerate(segments)]
    return [c for node in nodes for c in node]


def rows_of(made: Mooring, title: str) -> list[str]:
    section = made.text.split(f" {title} ---")[1] if f" {title} ---" in made.text else "\n\n\n---"
    return section.split("---------------------- ")[0].splitlines()[3:]


WAVES = "\n".join(
    ["0 0 0", *(f"{0.1 * k:.1f} {0.3 if k == 9 else 0.0} 0" for k in range(1, 30)), ""]
)
ELEVATION = "".join(f"{0.2 * k:.1f} {0.3 * math.sin(0.9 * 0.2 * k)}\n" for k in range(100))
GRID = "a grid\nof the\nwater\n2\n-60 60 13\n2\n-10 10 3\n2\n-40 0 9\n"
STEADY = "currents\nz ux uy uz\n-\n-40 0.1 0 0\n-20 0.3 0 0\n0 0.6 0.1 0\n"
FLOOR = "3 2\n-60 0 60\n-20 20\n" + "".join(
    f"{x} {y} {-40 + 0.1 * x}\n" for x in (-60, 0, 60) for y in (-20, 20)
)
ANCHORED = ["1 Fixed -50 0 -40 0 0 0 0", "2 Vessel 0 0 -2 0 0 0 0"]
LINE = ["1 rope 1 2 66 12 -"]

CASES = {
    "aliases": Case(
        {
            "LINE DICTIONARY": [ROPE],
            "CONNECTION PROPERTIES": [
                "1 Anchor -50 0 -40 0 0 0 0",
                "2 Fairlead 0 0 -2 0 0 0 0",
                "3 Connect 20 0 -20 900 0.5 0.2 1 # a clump",
                "4 CPLD 40 5 -3 0 0 0 0",
                "5 Con 20 -9 -21 100 0.01 0 0 -5 0 90 0 0",
            ],
            "LINE PROPERTIES": [*LINE, "2 rope 2 P3 29 5 -", "3 rope con3 4 28 5 -",
                                "4 rope 3 5 9 2 -"],
            "OPTIONS": ["40 WtrDpth", "1025 WtrDnsty", "9.81 gravity", "2e6 kb", "1e4 cb",
                        "0.2 MU_KT", "0.2 MU_KA", "100 CV", "1.2 MC", "0 outSwitch", "0 inertialF",
                        "0.5 dtIC", "5 ICDfac", "1e-3 ICthresh", "0 ICgenDynamic", "0.1 dtOut",
                        "0 WriteUnits", "0.15 CFL", "rk2 tScheme"],
        },
        [[0, 0, -2], [40, 5, -3]],
    ),
    "a coupled body with a rod": Case(
        {
            "LINE TYPES": [ROPE],
            "ROD TYPES": [CAN],
            "BODIES": ["1 Coupled 0 0 -4 0 0 0 0 0 0 0 0 0"],
            "RODS": ["1 can Body1 -1 0 0 1 0 -3 4 -"],
            "POINTS": ["1 Fixed -50 0 -40 0 0 0 0", "2 Body1 2 0 1 0 0 0 0",
                       "3 Fixed 50 9 -40 0 0 0 0"],
            "LINES": ["1 rope 1 R1A 66 12 -", "2 rope 3 2 66 60 -"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[0, 0, -4, 0, 0, 0]],
        step=0.01,
    ),
    "a coupled body that is pinned": Case(
        {
            "LINE TYPES": [ROPE],
            "ROD TYPES": [CAN],
            "BODIES": ["1 CoupledPinned 0 0 -4 0 0 0 500 0 800 0.1 0.2 0.5"],
            "RODS": ["1 can Body1 0 0 0 0 1 -5 4 -"],
            "POINTS": ["1 Fixed -30 0 -40 0 0 0 0"],
            "LINES": ["1 rope 1 R1B 46 9 -"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[0, 0, -4]],
        step=0.01,
    ),
    "coupled rods": Case(
        {
            "LINE TYPES": [ROPE],
            "ROD TYPES": [CAN],
            "RODS": ["1 can Coupled 0 0 -3 0 2 -6 4 -", "2 can VesPin 8 0 -3 8 1 -7 4 -"],
            "POINTS": ["1 Fixed -30 0 -40 0 0 0 0", "2 Fixed 40 0 -40 0 0 0 0"],
            "LINES": ["1 rope 1 R1B 46 9 -", "2 rope Rod2B 2 49 9 -"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM", "RK4 tScheme"],
        },
        [[0, 0, -3, 0, 0, 0], [8, 0, -3]],
        step=0.01,
    ),
    "a free body with rods": Case(
        {
            "LINE TYPES": [ROPE],
            "ROD TYPES": [CAN],
            "BODIES": ["1 Free 0 0 -6 5 10 0 2e3 0|0|-0.2 9e2|9e2|8e2 2.5 0.5|0.2 0.5",
                       "2 Fixed 30 0 -30 0 0 10 0 0 0 0 0 0"],
            "RODS": ["1 can Body1 0 0 1 0 0 -2 3 -", "2 can Body1Pinned 0 1 0 0 2 -3 3 -",
                     "3 can Free -25 0 -25 -25 0 -22 3 -", "4 can Body2 0 0 0 0 0 3 2 -",
                     "5 can Pinned -60 0 -35 -59 0 -33 2 -", "6 can Fixed 9 9 -40 9 9 -39 2 -"],
            "POINTS": ["1 Fixed -60 3 -40 0 0 0 0", "2 Body2 1 0 1 0 0 0 0",
                       "3 Body1 1 0 0 0 0 0 0", "4 Coupled 40 0 -2 0 0 0 0"],
            "LINES": ["1 rope R5B R3A 40 6 -", "2 rope R3B R1B 31 6 -", "3 rope 2 3 40 6 -",
                      "4 rope R4B 4 30 6 -", "5 rope R6B R2B 38 6 -"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[40, 0, -2]],
    ),
    "nothing coupled": Case(
        {
            "LINE TYPES": ["beam 0.1 20 2e6 -1 5e4 1 1 0.1 0"],
            "ROD TYPES": [CAN],
            "RODS": ["1 can Fixed -3 0 -9 0 0 -9 1 -"],
            "POINTS": ["1 Free 8 0 -9.1 30 0 0 0"],
            "LINES": ["1 beam R1B 1 8 6 -"],
            "OPTIONS": ["40 WtrDpth", "2e-4 dtM"],
        },
    ),
    "curves": Case(
        {
            "LINE TYPES": ["rope 0.05 12 ea.txt 2e4 ei.txt 1.2 1 0.1 0"],
            "POINTS": ANCHORED,
            "LINES": LINE,
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[0, 0, -2]],
        {
            "ea.txt": CURVE,
            "ei.txt": "bending\nk M\n1/m Nm\n0 0\n0.1 50\n1 200",
        },
    ),
    "viscoelastic": Case(
        {
            "LINE TYPES": ["rope 0.05 12 1e6|2e6 2e6|2e4 0 1.2 1 0.1 0",
                           "other 0.05 12 1e6|2e6|2 2e6|2e4 0 1.2 1 0.1 0"],
            "POINTS": [*ANCHORED, "3 Fixed 50 0 -40 0 0 0 0"],
            "LINES": [*LINE, "2 other 3 2 64 12 -"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[0, 0, -2]],
    ),
    "Syrope": Case(
        {
            "LINE TYPES": ["rope 0.05 12 SYROPE:settings.txt|2e6|5 2e7|2e4 0 1.2 1 0.1 0"],
            "POINTS": ["1 Fixed -50 0 -40 0 0 0 0", "2 Coupled 0 0 -2 0 0 0 0"],
            "LINES": ["1 rope 1 2 62 6 -"],
            "SYROPE IC": ["1 6e4 3e4"],
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM"],
        },
        [[0, 0, -2]],
        {"settings.txt": "ea.txt OWC\nQUADRATIC WCType\n0.2 k1\n0.5 k2\n", "ea.txt": CURVE},
    ),
    "vortices in a current": Case(
        {
            "LINE TYPES": ["rope 0.05 12 2e6 -0.8 0 1.2 1 0.1 0 0.3"],
            "POINTS": ANCHORED,
            "LINES": LINE,
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM", "1 Currents"],
        },
        [[0, 0, -2]],
        {"current_profile.txt": STEADY},
    ),
    "waves and a sloped bed": Case(
        {
            "LINE TYPES": [ROPE],
            "POINTS": ANCHORED,
            "LINES": LINE,
            "OPTIONS": ["50 WtrDpth", "1e-3 dtM", "3 WaveKin", "0.2 dtWave", "1 Currents",
                        "0 UnifyCurrentGrid", "floor.txt SeafloorFile"],
        },
        [[0, 0, -2]],
        {"wave_elevation.txt": ELEVATION, "water_grid.txt": GRID, "current_profile.txt": STEADY,
         "floor.txt": FLOOR},
    ),
    "summed waves": Case(
        {
            "LINE TYPES": [ROPE],
            "POINTS": ANCHORED,
            "LINES": LINE,
            "OPTIONS": ["40 WtrDpth", "1e-3 dtM", "7 WaveKin"],
        },
        [[0, 0, -2]],
        {"wave_frequencies.txt": WAVES},
    ),
}  # fmt: skip


@pytest.mark.verifies(
    "twelve MoorDyn files with every keyword between them",
    independent="MoorDyn by itself",
    tolerance="1e-2",
)
@pytest.mark.parametrize("name", CASES)
def test_a_file_runs_as_moordyn_has_it(name: str, tmp_path: Path, capfd) -> None:
    case = CASES[name]
    tables = {**case.tables, "OPTIONS": case.tables["OPTIONS"] + QUICK}
    path = Case(tables, files=case.files).write(tmp_path)
    made = ready_mooring(path, fairleads={}, in_space=True)
    alone = by_itself(path, case, len(made.lines), made.time_step)
    ours = by_adapter(made, case)
    capfd.readouterr()
    vectors = alone.reshape(len(alone), -1, 3), ours.reshape(len(ours), -1, 3)
    ranges = np.ptp(vectors[0], axis=0).max(axis=1)  # of a vector: of its largest component
    errors = np.abs(vectors[0] - vectors[1]).max(axis=(0, 2))
    still = ranges < 1e-6  # [m] of nodes at rest
    shares = errors[~still] / ranges[~still]
    print(name, made.time_step, np.array2string(shares, precision=2))
    assert shares.max() < TOLERANCE
    assert (errors[still] < TOLERANCE).all()
