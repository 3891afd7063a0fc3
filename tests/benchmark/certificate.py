"""True over stated coupling errors of many random systems: `python tests/benchmark/certificate.py`.

Arguments: algorithm, number of systems, and the range of their steps; 200 of 40 to 250 steps take a
minute or two. `tests/verification/test_cosim_certificate.py` does the same for a few.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from support.c_fmus.build import build
from support.random_systems import random_system


def main() -> None:
    """Print how often and how far the statement is off, in both directions."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("algorithm", nargs="?", default="corrector")
    parser.add_argument("count", nargs="?", type=int, default=200)
    parser.add_argument("steps", nargs="*", type=int, default=[40, 250])
    parser.add_argument("--rigid", choices=["none", "some", "all"], default="none")
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    least, most = options.steps
    with tempfile.TemporaryDirectory() as folder:
        fmus = cache(lambda name: build(name, Path(folder)))
        systems = (
            random_system(fmus, options.algorithm, rng, steps=(least, most), rigid=options.rigid)
            for _ in range(options.count)
        )
        true, stated = np.array([system.true_and_stated() for system in systems]).T
    ratio = true / stated
    print(
        f"true over stated: median {np.median(ratio):.2f}, {ratio.min():.2g} to {ratio.max():.3g}"
    )
    print(
        f"understated by more than 3: {(ratio > 3).mean():.1%}, than 10: {(ratio > 10).mean():.1%}"
    )


if __name__ == "__main__":
    main()
