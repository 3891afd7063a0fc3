"""Capytaine as we use it: quiet, warnings kept, finite-depth kernel accurate and repeatable.

Everything of Capytaine is imported through here.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Generator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np

KERNEL_TOLERANCES = (1e-8, 1e-7, 1e-6, 1e-5)  # mean square
EXPECTED = ("Precomputing tabulation",)  # once per machine


def import_capytaine() -> ModuleType:
    """The package; threads as the environment says, else one for each processor we may use."""
    available = getattr(os, "sched_getaffinity", None)
    count = len(available(0)) if available else os.cpu_count() or 1
    os.environ.setdefault("OMP_NUM_THREADS", str(count))
    os.environ.setdefault("CAPYTAINE_PROGRESS_BAR", "False")
    root = logging.getLogger()
    guard = logging.NullHandler()  # Capytaine sets the root logger up if nobody else has
    root.addHandler(guard)
    try:
        import capytaine
    finally:
        root.removeHandler(guard)
    return capytaine


class _Keeper(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        text = " ".join(record.getMessage().split())
        if text not in self.messages and not text.startswith(EXPECTED):
            self.messages.append(text)


@contextmanager
def kept_warnings() -> Generator[list[str]]:
    """The warnings that Capytaine logs meanwhile, each once, instead of on the console."""
    logger = logging.getLogger("capytaine")
    keeper, propagate = _Keeper(), logger.propagate
    logger.addHandler(keeper)
    logger.propagate = False
    try:
        yield keeper.messages
    finally:
        logger.removeHandler(keeper)
        logger.propagate = propagate


@contextmanager
def accurate_finite_depth() -> Generator[None]:
    """Meanwhile, Capytaine's finite-depth Green function is accurate and the same in every run.

    Capytaine 3.0 approximates a part of it by exponentials on randomly placed points, to a mean
    square error of 1e-4: added masses come out wrong by up to 0.3 %, differently at neighbouring
    frequencies and in every run, which is fatal to A − A∞. Here the points are fixed and the
    tolerance is the tightest of `KERNEL_TOLERANCES` that is reached; the error then is below 1e-4.
    """
    import_capytaine()
    from capytaine.green_functions import delhommeau
    from capytaine.tools.prony_decomposition import PronyDecompositionFailure

    original = delhommeau.find_best_exponential_decomposition

    # at x = kh the approximated function is 0/0: a number of terms with such a point is left out
    @np.errstate(divide="ignore", invalid="ignore")
    def accurate(f: Any, x_min: float, x_max: float, n_exp_range: Any, **_: Any) -> Any:
        arguments = (f, x_min, x_max, n_exp_range)
        for tolerance in KERNEL_TOLERANCES:
            try:
                return original(*arguments, tol=tolerance, noise_on_domain_points_std=0.0)
            except PronyDecompositionFailure:
                continue
        return original(*arguments)

    delhommeau.find_best_exponential_decomposition = accurate
    try:
        yield
    finally:
        delhommeau.find_best_exponential_decomposition = original
