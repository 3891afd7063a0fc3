"""FMUs alone and together: `python -m support.together FOLDER SEED...`, over all FMUs in FOLDER.

Each FMU is loaded, stepped and freed alone in a process of its own; then, for each seed, all of
them in one process, their loading, steps and freeing mixed at random. Prints JSON: how many values
were compared, and where they differ.
"""

from __future__ import annotations

import json
import math
import os
import pickle
import random
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from support.fmu_instances import Instance

STEPS, H = 8, 0.05
Values = dict[str, list[float]]


@cache
def description(fmu: Path) -> Any:
    return fmpy.read_model_description(str(fmu), validate=False)


def life(fmu: Path, folder: Path) -> Iterator[list[float]]:
    """Load, step and free an FMU, one of these at each `next`; yields all Reals after each step."""
    with Instance(fmu, folder / fmu.stem, description=description(fmu)) as instance:
        yield []
        inputs, names = instance.reals("input")[:2], instance.reals()
        instance.initialise()
        for k in range(STEPS):
            instance.set({name: math.sin(k + j) for j, name in enumerate(inputs)})
            instance.step(k * H, H)
            yield instance.get(names)


def mixed(fmus: list[Path], seed: int) -> Values:
    """Outputs of the FMUs, together in this process, by name; each step's values in a row."""
    chance = random.Random(seed)
    found: Values = {fmu.name: [] for fmu in fmus}
    with tempfile.TemporaryDirectory() as folder:
        lives = {fmu.name: life(fmu, Path(folder)) for fmu in fmus}
        while lives:
            name = chance.choice(sorted(lives))
            values = next(lives[name], None)
            if values is None:
                del lives[name]
            else:
                found[name] += values
    return found


def without_library(fmu: Path) -> Path:
    """The Python FMU `fmu`, from now on without the C runtime: it integrates in Python."""
    with zipfile.ZipFile(fmu) as old:
        names = old.namelist()
        kept = {n: old.read(n) for n in names if "/runtime." not in n}
    assert len(kept) < len(names)
    with zipfile.ZipFile(fmu, "w") as new:
        for name, content in kept.items():
            new.writestr(name, content)
    return fmu


def elsewhere(action: Callable[[], Values]) -> Values:
    """Result of `action` in a fork of this process; empty if that crashes."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        with os.fdopen(writing, "wb") as pipe:
            pickle.dump(action(), pipe)
            pipe.flush()
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        content = pipe.read()
    status = os.waitpid(child, 0)[1]
    return {} if status else pickle.loads(content)


def main(folder: str, *seeds: str) -> None:
    fmus = sorted(Path(folder).glob("*.fmu"))
    for fmu in fmus:
        description(fmu)  # before the forks, which then need not
    alone: Values = {}
    for fmu in fmus:
        alone |= elsewhere(lambda fmu=fmu: mixed([fmu], 0))
    differences = [fmu.name for fmu in fmus if fmu.name not in alone]
    for seed in seeds:
        together = elsewhere(lambda seed=seed: mixed(fmus, int(seed)))
        differences += [f"{n}, seed {seed}" for n, v in alone.items() if together.get(n) != v]
    count = sum(map(len, alone.values()))
    print(json.dumps({"fmus": len(fmus), "values": count, "differences": differences}))


if __name__ == "__main__":
    main(*sys.argv[1:])
