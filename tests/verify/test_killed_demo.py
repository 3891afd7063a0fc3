"""The demo killed at ten random moments, and going on each time: the file of an undisturbed run."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

from support.command_line import EXAMPLES
from support.interrupted import differences

from m4e_fmi.cosim.run.checkpoint import checkpoint_of

BUOY = EXAMPLES / "moored_buoy" / "system.yaml"
KILLS = 10
SEED = 1


def command(folder: Path, results: Path, *more: str) -> list[str]:
    options = ["--output-file", str(results), "--build-folder", str(folder / "build"), *more]
    script = "import m4e_fmi.cli as c; raise SystemExit(c.main())"
    return [sys.executable, "-c", script, "run", str(BUOY), *options]


def test_the_demo_killed_ten_times(tmp_path: Path) -> None:
    plain, file = tmp_path / "plain.nc", tmp_path / "results.nc"
    subprocess.run(command(tmp_path, plain), check=True)
    moments, more = random.Random(SEED), ["--checkpoint-wall-interval", "0.5"]
    for _ in range(KILLS):
        with subprocess.Popen(command(tmp_path, file, *more)) as run:
            try:
                assert run.wait(timeout=moments.uniform(3.0, 10.0)) == 0
                break
            except subprocess.TimeoutExpired:
                run.kill()
        if checkpoint_of(file).exists() and "--resume" not in more:
            more.append("--resume")
    subprocess.run(command(tmp_path, file, *more), check=True)
    assert differences(plain, file) == []
