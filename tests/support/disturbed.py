"""Runs of a small system that are disturbed, and the results that they must leave.

As a program, ``python disturbed.py SYSTEM RESULTS PLAN``, it runs a system and kills itself inside
a write. The plan is JSON: rows reach the disk every `flush` seconds; at write number `write` (the
first is that of the header), a `part` of the bytes is written before the kill. With `block` the
kill comes while the file is turned into its final form, at that block of rows.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.cosim import load_system
from m4e_fmi.results.results_file import Results, load_results

FAST = 200.0, 0.002
"""Stop time and step [s] of a run that takes half a second: 100,001 rows."""
NOT_ENDED = "not yet: the run goes on, or its process was killed"


def write_system(
    c_fmu: Callable[[str], Path],
    folder: Path,
    *harms: Mapping[str, float],
    times: tuple[float, float] = FAST,
) -> Path:
    """The file of a system: a mass on a spring, and FMUs that do `harms` (vandal.c)."""
    vandals = {f"vandal{k}": harm for k, harm in enumerate(harms or ({},))}
    fmus = {"body": "mass+state", "spring": "spring+state"} | dict.fromkeys(vandals, "vandal+state")
    starts = {"body": {"body.m.x": 1.0}, **vandals}
    content = {
        "name": "disturbed",
        "components": {
            name: {"fmu": str(c_fmu(model)), "start": starts.get(name, {})}
            for name, model in fmus.items()
        },
        "connections": ["body.m <-> spring.end"],
        "simulation": {"stop_time": times[0], "step_size": times[1], "algorithm": "jacobi"},
    }
    path = folder / "system.yaml"
    path.write_text(json.dumps(content))
    return path


def check_rows(found: Results, whole: Results, *, least: int = 0) -> None:
    """All rows there are equal those of the undisturbed run, bit for bit."""
    count = len(found.time)
    assert least <= count <= len(whole.time)
    assert found.time.tobytes() == whole.time[:count].tobytes()
    assert list(found.series) == list(whole.series)
    for name, series in found.series.items():
        assert series.values.tobytes() == whole[name].values[:count].tobytes(), name


def commanded(system: Path, results: str, *options: str) -> list[str]:
    """The command that runs a system in the folder of its file."""
    code = "import sys; from m4e_fmi.cli import main; sys.exit(main())"
    return [sys.executable, "-c", code, "run", str(system), "--output-file", results, *options]


@contextlib.contextmanager
def running(system: Path, results: str, *options: str) -> Iterator[subprocess.Popen[str]]:
    """A process that runs a system, once its first rows are in the file; killed at the end."""
    place = system.parent / results
    command = commanded(system, results, *options)
    with subprocess.Popen(command, cwd=system.parent, stderr=subprocess.PIPE, text=True) as process:
        try:
            until(lambda: bool(place.with_suffix(".nc").exists() or process.poll() is not None))
            yield process
        finally:
            process.kill()


def until(condition: Callable[[], bool], limit: float = 60.0) -> None:
    """Wait for something to become true."""
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def killed(system: Path, results: Path, plan: Mapping[str, Any]) -> None:
    """Run a system in a process that kills itself by plan, or `after` so many seconds with rows."""
    command = [sys.executable, __file__, str(system), str(results), json.dumps(plan)]
    before = results.stat().st_mtime_ns
    with subprocess.Popen(command) as process:
        if "after" in plan:
            until(lambda: process.poll() is not None or results.stat().st_mtime_ns != before)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(plan["after"])
            process.kill()
    assert process.returncode in (0, -signal.SIGKILL)


def check_left(path: Path, whole: Results, old: bytes, *, least: int = 0) -> int:
    """Content that a killed run has left at `path`: the old bytes, or rows; the number of rows."""
    if path.read_bytes() == old:
        assert least == 0
        return 0
    found = load_results(path)
    check_rows(found, whole, least=max(2, least))
    if len(found.time) < len(whole.time):
        assert found.attributes["ended"] == NOT_ENDED
    return len(found.time)


def _main(system: str, results: str, text: str) -> None:
    from m4e_fmi.cosim import run
    from m4e_fmi.cosim.results import writer as writing
    from m4e_fmi.results import row_file

    plan = json.loads(text)
    writing.FLUSH = plan["flush"]
    usual, blocks = row_file.RowFile._put, row_file.RowFile.blocks
    count = 0

    def put(file: row_file.RowFile, place: int, data: Any) -> None:
        nonlocal count
        data = memoryview(data).cast("B")
        if count == plan.get("write"):
            usual(file, place, data[: int(plan["part"] * len(data))])
            os.kill(os.getpid(), signal.SIGKILL)
        count += 1
        usual(file, place, data)

    def some(file: row_file.RowFile) -> Iterator[list[np.ndarray]]:
        for number, block in enumerate(blocks(file)):
            if number == plan.get("block"):
                os.kill(os.getpid(), signal.SIGKILL)
            yield block

    row_file.READ = 2**20
    setattr(row_file.RowFile, "_put", put)  # noqa: B010
    setattr(row_file.RowFile, "blocks", some)  # noqa: B010
    run(load_system(system), results=results)


if __name__ == "__main__":
    _main(*sys.argv[1:])
