"""Runs that are interrupted, and comparison of the results files of two runs."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from netCDF4 import Dataset

from m4e_fmi.cosim import System, run
from m4e_fmi.cosim.run import run as run_module
from m4e_fmi.cosim.run.checkpoint import checkpoint_of
from m4e_fmi.cosim.time_loop import time_loop

OF_THE_RUN = {"created"}
"""Attributes that tell when a run was made."""


def content(path: Path) -> dict[str, object]:
    """Everything in a results file but the time of its making: values by their bytes."""
    found: dict[str, object] = {}
    with Dataset(path) as file:
        file.set_auto_mask(False)
        for group in (file, *file.groups.values()):
            name = group.path
            names = [a for a in group.ncattrs() if a not in OF_THE_RUN]
            found |= {f"{name}@{a}": str(group.getncattr(a)) for a in names}
            for variable in group.variables.values():
                values = np.asarray(variable[:])
                plain = values.tolist() if values.dtype == object else values.tobytes()
                told = {a: str(variable.getncattr(a)) for a in variable.ncattrs()}
                found[f"{name}/{variable.name}"] = (str(values.dtype), len(values), plain, told)
    return found


def differences(one: Path, other: Path) -> list[str]:
    """Names of what differs between two results files."""
    a, b = content(one), content(other)
    return sorted(name for name in {**a, **b} if a.get(name) != b.get(name))


def tell_every_step(patch: pytest.MonkeyPatch) -> None:
    """Let the `progress` of runs be called after every step."""
    patch.setattr(run_module, "PROGRESS_INTERVAL", 0.0)
    patch.setattr(time_loop, "LONGEST", 0.0)


def copied_at(results: Path, times: list[float], into: Path) -> Callable[[float], None]:
    """A call of the time that copies the results and their checkpoint at each of some times [s].

    So they are on the disk when the process is killed there: ``into/0/results.nc`` and so on. It is
    for the `progress` of a run that tells it after every step.
    """
    left = list(enumerate(times))

    def copy(time: float) -> None:
        while left and time >= left[0][1]:
            folder = into / str(left.pop(0)[0])
            folder.mkdir(parents=True)
            for file in (results, checkpoint_of(results)):
                shutil.copy(file, folder / file.name)

    return copy


def check_resumed(whole: System, folder: Path, interval: float, times: list[float]) -> list[str]:
    """The run, one with checkpoints, and those that go on from copies of it, give one file.

    The copies are taken at `times` [s]. The first lines that each of these runs tells.
    """
    plain, file, told = folder / "plain.nc", folder / "results.nc", list[str]()
    run(whole, results=plain)
    saving = whole.changed(checkpoint_interval=interval)
    with pytest.MonkeyPatch.context() as patch:
        tell_every_step(patch)
        run(saving, results=file, progress=copied_at(file, times, folder))
    assert differences(plain, file) == []
    for place in range(len(times)):
        lines: list[str] = []
        again = folder / str(place) / file.name
        run(saving, results=again, resume=True, tell=lines.append)
        assert differences(plain, again) == []
        told.append(lines[0])
    return told
