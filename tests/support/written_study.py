"""Result files of studies with given numbers, without runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from m4e_fmi.study.dataset import Labels, dataset, write_dataset
from m4e_fmi.study.given.grid import Axis, Grid, Scalar, Shares, Varied
from m4e_fmi.study.given.study import Study, Wanted
from m4e_fmi.study.record import Record
from m4e_fmi.study.report.record import carried_record, inputs_of

EVIL = "<img src=x onerror=alert(1)>"
"""A text that must stay one."""
HEIGHTS, PERIODS, DAMPINGS, SEEDS = (1.0, 2.0, 3.0), (6.0, 8.0, 10.0, 12.0), (5.0, 7.0), 3
PROBABILITY = np.arange(1.0, 13.0).reshape(3, 4) / 78.0
FAILED_CELL = 2, 0
"""Height and period of a state whose runs all fail."""
WANTED = (
    Wanted("mean_power", "pto.power", "mean"),
    Wanted("most_tension", "line.tension", "maximum"),
)


def axis(name: str, values: Sequence[Scalar], *, repeats: bool = False) -> Axis:
    """A dimension of one quantity."""
    return Axis(name, (Varied(name, (name,)),), tuple((x,) for x in values), repeats=repeats)


def written(
    folder: Path,
    grid: Grid,
    records: Sequence[Record],
    wanted: Sequence[Wanted] = WANTED,
    *,
    series: Sequence[str] = (),
    units: Mapping[str, str] | None = None,
    wave_power: Sequence[float] = (),
) -> Path:
    """The result file of a study with these records."""
    source = folder / "x.model.yaml"
    source.write_text(f"name: x  # {EVIL}\n", "utf-8")
    study = Study(
        name=f"sea {EVIL}", source=source, is_model=True, grid=grid, wanted=tuple(wanted),
        series=tuple(series), text=f"name: x  # </script>{EVIL}\n",
    )  # fmt: skip
    kept = carried_record(
        study, records, inputs=inputs_of(study), kept=0, warnings={f"odd {EVIL}": 2},
        notes=["quick"],
    )  # fmt: skip
    units = units or {"pto.power": "W", "line.tension": "N", "buoy.z": "m"}
    labels = Labels(
        {"Hs": ("m", f"height {EVIL}"), "Tp": ("s", "period")},
        {name: (unit, EVIL) for name, unit in units.items()},
    )
    starts = [30.0] * grid.count
    found = dataset(
        study,
        records,
        labels,
        start_up=starts,
        attributes={"start_up": "30 s", **kept},
        wave_power=wave_power,
        water="50 m of water" if wave_power else "",
    )
    path = folder / "study.nc"
    write_dataset(found, path)
    return path


def power(height: float, period: float, damping: float, seed: int) -> float:
    """Power [W] of a run of `matrix`."""
    return 1e3 * height**2 * damping * math.exp(-((period - 8.0) ** 2) / 8.0) + 10.0 * seed


def matrix(folder: Path, *, failing: bool = True) -> Path:
    """A power matrix of 3 heights, 4 periods, 2 dampings and 3 seeds, with series of a motion.

    All runs of `FAILED_CELL` fail, and the first one of the next period.
    """
    axes = (
        axis("Hs", HEIGHTS),
        axis("Tp", PERIODS),
        axis("damping", DAMPINGS),
        axis("seed", range(1, SEEDS + 1), repeats=True),
    )
    grid = Grid(axes, (Shares(("Hs", "Tp"), PROBABILITY),))
    time = np.arange(0.0, 100.0, 0.1)
    records = []
    for run in range(grid.count):
        i, j, k, seed = grid.place(run)
        if failing and (
            (i, j) == FAILED_CELL or (i, j, seed) == (FAILED_CELL[0], FAILED_CELL[1] + 1, 0)
        ):
            records.append(Record(failure=f"buoy at t = 3 s: {EVIL}"))
            continue
        watts = power(HEIGHTS[i], PERIODS[j], DAMPINGS[k], seed)
        motion = HEIGHTS[i] / 2 * np.sin(2 * np.pi * time / PERIODS[j] + seed)
        records.append(
            Record(
                values={"mean_power": watts, "most_tension": 5e5 * HEIGHTS[i] + run},
                time=time, series={"buoy.z": motion}, coupling_error=1e-5 * (run + 1),
                coupling_at="buoy.force", wall_time=2.0,
            )
        )  # fmt: skip
    return written(folder, grid, records, series=("buoy.z",))


def samples(folder: Path, count: int) -> Path:
    """`count` samples of two quantities, every hundredth of which fails."""
    rng = np.random.default_rng(1)
    points = tuple(map(tuple, rng.random((count, 2)).tolist()))
    axes = (Axis("sample", (Varied("m", ("buoy.m",)), Varied("c", ("pto.c",))), points),)
    records = [
        Record(values={"mean_power": 1e3 * m, "most_tension": c}, wall_time=0.1)
        if run % 100
        else Record(failure="it broke")
        for run, (m, c) in enumerate(points)
    ]
    return written(folder, Grid(axes), records)
