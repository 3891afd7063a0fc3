"""Programs: ordinary differential equations as exact straight-line code.

A `Program` is what travels through the product: named inputs, parameters, states and outputs, each
with a unit and a description, and one tape of arithmetic that computes derivatives and outputs.
A `Recorder` makes one by running an ordinary algorithm on recording scalars.

This package is the bottom layer: of m4e_fmi it imports `errors` and `files`. Start reading in
`tape`, then `program`; `derivatives` and `composition` make programs of programs; `python_form` and
`binary_form` are the forms a program is written out in.
"""

from m4e_fmi.program.composition import AlgebraicLoopError, Connection, compose, with_feedback
from m4e_fmi.program.derivatives import Jacobian, jacobian, rate_entries, tangent
from m4e_fmi.program.functions import (
    AnyScalar,
    ScalarLike,
    acos,
    asin,
    atan,
    atan2,
    cos,
    exp,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
)
from m4e_fmi.program.kinks import kinks
from m4e_fmi.program.loops import LEAST_PIVOT, is_singular, singular_loop
from m4e_fmi.program.program import (
    TIME,
    LocalLaw,
    Loop,
    Part,
    Program,
    Recorder,
    Solution,
    Variable,
)
from m4e_fmi.program.tape import Scalar, Tape, evaluated

__all__ = [
    "LEAST_PIVOT",
    "TIME",
    "AlgebraicLoopError",
    "AnyScalar",
    "Connection",
    "Jacobian",
    "LocalLaw",
    "Loop",
    "Part",
    "Program",
    "Recorder",
    "Scalar",
    "ScalarLike",
    "Solution",
    "Tape",
    "Variable",
    "acos",
    "asin",
    "atan",
    "atan2",
    "compose",
    "cos",
    "evaluated",
    "exp",
    "is_singular",
    "jacobian",
    "kinks",
    "log",
    "maximum",
    "minimum",
    "rate_entries",
    "sign",
    "sin",
    "singular_loop",
    "sqrt",
    "tan",
    "tangent",
    "tanh",
    "with_feedback",
]
