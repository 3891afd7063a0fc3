"""Largest stable steps of coupled oscillators: `python tests/benchmark/stability.py`.

Two masses on springs to the walls and with a spring and a damper between them, as force against
displacement (`fd`) and displacement against displacement (`dd`). A step is stable if no eigenvalue
of it is larger than 1; they are found from the course. docs/coupling.md has the table;
it takes two minutes. `tests/verification/test_cosim_stability.py` does the same for a few.
"""

from __future__ import annotations

import sys
import tempfile
from functools import cache
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
from support.c_fmus.build import build
from support.stability import ALGORITHMS, OBSERVED, PAIRS, largest_stable_step, pair


def main() -> None:
    """Print the table, in Markdown."""
    print(f"| pair | | {' | '.join(ALGORITHMS)} |\n|{'---|' * (len(ALGORITHMS) + 2)}")
    with tempfile.TemporaryDirectory() as folder:
        fmus = cache(lambda name: build(name, Path(folder)))
        for name, given in PAIRS.items():
            for how in ("fd", "dd"):
                limits = [
                    largest_stable_step(pair(fmus, given, how, *of), OBSERVED[how])
                    for of in ALGORITHMS.values()
                ]
                shown = " | ".join(f"{limit:.3g}" for limit in limits)
                print(f"| {name} | {how} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
