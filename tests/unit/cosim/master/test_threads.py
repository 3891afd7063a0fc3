"""Runs and files of results in threads of one process."""

import json
import subprocess
import sys
from pathlib import Path

from support.small_study import written_study

SCRIPT = """
import json
from concurrent.futures import ThreadPoolExecutor
from m4e_fmi.cosim import load, load_system, prepare, run

system = load_system("system.yaml").changed(stop_time=0.5)
prepared = prepare(system)

def last(k):
    outcome = run(prepared, results=f"{k}.nc")
    return [float(outcome.results()["cart.body.cart.x"].values[-1]) for _ in range(3)]

with ThreadPoolExecutor(4) as pool:
    print(json.dumps(list(pool.map(last, range(12)))))
"""


def test_runs_with_results_may_be_asked_for_by_threads(tmp_path: Path) -> None:
    """netCDF's library ends the process if two threads call it at once."""
    written_study(tmp_path, "")
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found == [found[0]] * 12
    assert found[0] == [found[0][0]] * 3
