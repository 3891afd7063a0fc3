"""Checks of systems with components in water, which their kinds share.

`doubles` finds loads that two components have on one body, `surroundings` waters, seas and
gravities that differ; `flotation` looks at the start of a run, by the bodies in `hulls` and the
forces that `start_balance` finds on them.
"""

from __future__ import annotations

from functools import partial

from m4e_fmi.fmu import FmuKind
from m4e_fmus.water.doubles import double_load_problems
from m4e_fmus.water.flotation import flotation
from m4e_fmus.water.surroundings import differing

__all__ = ["kind_in_water"]


kind_in_water = partial(
    FmuKind, problems=double_load_problems, doubts=differing, doubts_at_start=flotation
)
"""An `FmuKind` with these checks."""
