"""Potential flow killed at random moments: nothing that was done is computed again, nor changes."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

FREQUENCIES = 12
SCRIPT = """
import sys
import numpy as np
from m4e_adapters.hydrodynamics.config import Box, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels

panels = box_panels(Box(length=12.0, width=8.0, draft=2.0), 300)
hull = Hull("float", panels, None, (0.0, 0.0, -1.0), hydrostatics_of(panels))
found = solve_hulls(
    [hull], water=Water(), omega=np.linspace(0.4, 2.0, int(sys.argv[2])),
    progress=lambda text: print(text, flush=True),
)
np.savez(sys.argv[1], **vars(found))
"""


def started(cache: Path, result: Path) -> subprocess.Popen[str]:
    """The computation, in a process of its own."""
    environment = {**os.environ, "M4E_FMI_CACHE": str(cache), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", SCRIPT, str(result), str(FREQUENCIES)]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)


def frequencies_told(process: subprocess.Popen[str]) -> list[tuple[int, int]]:
    """Which frequency of how many was begun, as the process says to its end."""
    output = process.communicate(timeout=500)[0]
    return [(int(a), int(b)) for a, b in re.findall(r"frequency (\d+) of (\d+)", output)]


def test_killed_and_resumed(tmp_path: Path) -> None:
    undisturbed = started(tmp_path / "whole", tmp_path / "whole.npz")
    assert len(frequencies_told(undisturbed)) == FREQUENCIES + 1  # and infinity
    rng, left = random.Random(5), FREQUENCIES + 1
    for _ in range(3):
        process = started(tmp_path / "killed", tmp_path / "resumed.npz")
        assert process.stdout is not None
        begun = 0
        for line in process.stdout:
            if match := re.search(r"frequency (\d+) of (\d+)", line):
                assert int(match[2]) <= left, "what was done is computed again"
                left, begun = int(match[2]), int(match[1])
            if begun == 3:  # two are done
                break
        try:
            process.wait(timeout=0.05 * rng.random())
        except subprocess.TimeoutExpired:
            process.kill()
        process.communicate()
        kept = list((tmp_path / "killed" / "hydrodynamics").glob("*.coefficients"))
        assert len(kept) >= FREQUENCIES + 1 - left + 2
        left = FREQUENCIES + 1 - len(kept)
    told = frequencies_told(started(tmp_path / "killed", tmp_path / "resumed.npz"))
    assert [b for _, b in told] == [left] * left
    with np.load(tmp_path / "whole.npz") as one, np.load(tmp_path / "resumed.npz") as other:
        assert set(one.files) == set(other.files)
        for name in one.files:
            np.testing.assert_array_equal(one[name], other[name], err_msg=name)
