"""FMUs do not grow: in short what `benchmark.endurance` shows with the full counts."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

MEASURE = """\
import json
from benchmark.endurance import measured
found = measured(2000, 200)
print(json.dumps({kind: {g.what: g.each for g in rows} for kind, rows in found.items()}))
"""
PAGES = 64 * 4096  # B: what an allocator may take once, whatever is repeated


def test_memory_is_flat() -> None:
    """In a process of its own: nothing that other tests hold or free counts."""
    tests = Path(__file__).parents[1]
    done = subprocess.run(
        [sys.executable, "-c", MEASURE], capture_output=True, text=True, cwd=tests, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    python, bare = found["Python"], found["bare"]
    # an instance has some 10 kB, a state 200 B: one that is kept each time would be seen
    for native in (found["native"], found["native 3"]):
        assert native["instances"] * 2000 < PAGES
        assert native["steps"] * 20_000 < PAGES
        assert native["states"] * 2000 < PAGES
    assert python["instances"] < bare["instances"] + PAGES / 200
    assert python["steps"] * 2000 < PAGES
    assert python["states"] * 200 < PAGES
