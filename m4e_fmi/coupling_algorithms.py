"""Names and descriptors of the coupling algorithms: the modules in `m4e_fmi/cosim/algorithms/`.

Each of these modules ends with its descriptor, `ALGORITHM`, from which the registry, the check of
system files, the command line, `info`, the advice in messages and the docs are made. Names are
those of the files, so that listing them imports nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

FOLDERS = [str(Path(__file__).parent / "cosim" / "algorithms")]
PACKAGE = "m4e_fmi.cosim.algorithms"
DEFAULT_ALGORITHM = "corrector"


class LinkDelay(Enum):
    """How connected inputs follow their sources during a step."""

    ONE_STEP = "held at the start of the step"
    EXECUTION_ORDER = "known, predicted or extrapolated, in the execution order"
    CORRECTED = "corrected by a second pass"
    SOLVED = "solved together with their sources"


@dataclass(frozen=True)
class AlgorithmDescriptor:
    """An algorithm as the rest of the program knows it.

    `order` is the power of the step with which the coupling error falls where FMUs can do all that
    the algorithm makes use of. `stability` ranks algorithms by their longest stable step: messages
    on growth without bound advise those of higher rank. `make` returns the `Algorithm` for a
    `Network` at its start time; `cosim` has both.
    """

    name: str
    summary: str
    order: int
    link_delay: LinkDelay
    needs_rollback: bool
    stability: int
    make: Callable[[Any], Any]


def algorithm_names() -> list[str]:
    """Names of all algorithms, in alphabetical order."""
    return sorted(module.name for module in iter_modules(FOLDERS))


def algorithm_descriptor(name: str) -> AlgorithmDescriptor:
    """Descriptor of the algorithm `name`, one of `algorithm_names`."""
    return import_module(f"{PACKAGE}.{name}").ALGORITHM


def listed(names: list[str]) -> str:
    """Names as alternatives in a sentence: ``a, b or c``."""
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
