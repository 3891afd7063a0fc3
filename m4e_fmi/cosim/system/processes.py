"""In which process a component's FMU runs, and the limits that it has there."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator

from m4e_fmi.cosim.system.simulation import Time
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Section, rejected
from m4e_fmi.fmu.importer.worker import Host

OWN, HERE = "own", "here"
_BYTES = {"kB": 10**3, "MB": 10**6, "GB": 10**9, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30}
_MEMORY = re.compile(rf"(\d{{1,6}}(?:\.\d{{1,6}})?) *({'|'.join(_BYTES)})")
_SIZES = "write a number and its unit, as '500 MB' or '2 GiB'"
LEAST_MEMORY = 10**8
"""Bytes that a worker needs before it has loaded an FMU."""


def _positive(given: float | None) -> float | None:
    if given is not None and not (math.isfinite(given) and given > 0):
        raise rejected(f"{given:g} s is no limit", "give a time above 0 s")
    return given


def _in_bytes(given: object) -> object:
    """A text with unit as a number of bytes."""
    if given is None:
        return None
    if isinstance(given, int):
        size = given
    else:
        found = _MEMORY.fullmatch(given) if isinstance(given, str) else None
        if found is None:
            raise rejected(f"{given!r} is not a size of memory", _SIZES)
        size = round(float(found[1]) * _BYTES[found[2]])
    if size < LEAST_MEMORY:
        raise rejected(f"{given!r} is too little for any FMU", f"give {LEAST_MEMORY // 10**6} MB")
    return size


Limit = Annotated[Time | None, AfterValidator(_positive)]


class Limits(Section):
    """Limits for FMUs in processes of their own; None leaves one as it is for all components.

    `call`: time that each call of the FMU may take [s], or with a unit, 600 s by default.
    `end`: the same for terminating and freeing it, 30 s by default. `memory`: address space of its
    process [bytes], or as "2 GB"; no limit by default.
    """

    call: Limit = None
    end: Limit = None
    memory: Annotated[int | None, BeforeValidator(_in_bytes)] = None

    def __bool__(self) -> bool:
        return self != Limits()


@dataclass(frozen=True)
class Processes:
    """Conditions for all FMUs in processes of their own: `limits`, and what they `keep`.

    `keep` are the names of variables of the environment that they get.
    """

    limits: Limits = field(default_factory=Limits)
    keep: tuple[str, ...] = ()

    def host(self, limits: Limits) -> Host:
        """The conditions for a component with `limits` of its own."""
        default, general = Host(), self.limits

        def first(*given: float | None) -> float:
            return next(value for value in given if value is not None)

        return Host(
            call=first(limits.call, general.call, default.call),
            end=first(limits.end, general.end, default.end),
            memory=general.memory if limits.memory is None else limits.memory,
            keep=self.keep,
        )


def check_process(component: str, process: str | None, limits: Limits) -> None:
    """InputError if a component's `process` is unknown, or cannot keep its limits."""
    if process not in (None, OWN, HERE):
        message = f"component {component!r}: process {process!r} is unknown"
        raise InputError.single(message, f"give {OWN!r} or {HERE!r}, or nothing")
    if process == HERE and limits:
        message = f"component {component!r}: there are no limits for an FMU in this process"
        raise InputError.single(message, "leave out `limits`, or `process: here`")
