"""Options of an FMU that is built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real

from m4e_fmi.errors import InputError, Problem, suggestion
from m4e_fmi.runtime.declarations import METHODS

FMI_VERSIONS = ("2", "3")
ICON = {"2": "model.png", "3": "terminalsAndIcons/icon.png"}
"""Where the picture of an FMU is: FMI 2.0.4, section 2.3; FMI 3.0.2, section 2.5.1."""


@dataclass(frozen=True)
class Options:
    """The arguments of `build_fmu`, where they are explained; InputError with all that is wrong."""

    native: bool = False
    fmi: str = "2"
    method: str = "dop853"
    tolerance: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    outputs: tuple[str, ...] | None = None
    rename: Mapping[str, str] = field(default_factory=dict)
    documentation: Mapping[str, bytes] = field(default_factory=dict)
    sources: bool = False

    def __post_init__(self) -> None:
        problems = []
        for what, value, known in (
            ("FMI version", self.fmi, FMI_VERSIONS),
            ("method", self.method, METHODS),
        ):
            if value not in known:
                remedy = suggestion(str(value), known)
                problems.append(Problem(f"there is no {what} {value!r}", remedy))
        for what, value in (
            ("tolerance", self.tolerance),
            ("stop time", self.stop_time),
            ("step size", self.step_size),
        ):
            if value is not None and not _is_positive(value):
                remedy = f"give a number{'' if what == 'tolerance' else ' of seconds'} above 0"
                problems.append(Problem(f"the {what} must be positive, got {value!r}", remedy))
        if self.fmi == "3" and not self.native:
            problems.append(Problem("FMI 3.0 is for native FMUs", "add native, or take FMI 2"))
        if self.sources and not self.native:
            problems.append(Problem("C sources are for native FMUs", "leave them out"))
        icon = ICON.get(self.fmi, "")
        problems += [
            Problem(f"{name!r} is not a place for documentation", f"documentation/… or {icon}")
            for name in self.documentation
            if not name.startswith("documentation/") and name != icon
        ]
        if problems:
            raise InputError(problems)


def _is_positive(value: object) -> bool:
    """True for a number above 0 that is finite."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return 0 < float(value) < math.inf
