"""Several connected programs as one: start reading in `compose`.

`loops` solves algebraic loops that are linear, `moved_solution` keeps what is known of how the
rates of the parts were solved for, `local_law` is what parts come from that hold about one point.
"""

from m4e_fmi.program.composition.compose import AlgebraicLoopError, Connection, compose
from m4e_fmi.program.composition.local_law import LocalLaw
from m4e_fmi.program.composition.loops import LEAST_PIVOT, is_singular, singular_loop

__all__ = [
    "LEAST_PIVOT",
    "AlgebraicLoopError",
    "Connection",
    "LocalLaw",
    "compose",
    "is_singular",
    "singular_loop",
]
