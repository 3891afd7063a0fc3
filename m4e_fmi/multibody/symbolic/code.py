"""M and f of the equations of motion as a function in Python or C, to take away and use elsewhere.

What occurs more than once is computed once. The text stands alone: Python needs NumPy, C needs C99.
"""

from __future__ import annotations

import keyword
import math
from collections.abc import Collection
from functools import partial
from itertools import chain
from textwrap import fill
from typing import TYPE_CHECKING, Literal, get_args

from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.model import Table
from m4e_fmi.model.elements import neutral_symbol, parameter_values
from m4e_fmi.multibody.symbolic.printing import intermediates, rates_text
from m4e_fmi.program import AnyScalar
from m4e_fmi.units import parse_unit

if TYPE_CHECKING:
    from m4e_fmi.multibody.symbolic.equations import Equations

Language = Literal["python", "c"]

PYTHON = '''\
"""{about}
"""

from math import acos, asin, atan, atan2, cos, exp, log, pi, sin, sqrt, tan, tanh

import numpy as np

PARAMETERS = {values}
{tables}

def equations(t, q, u, p=PARAMETERS):
{body}
    return M, f
'''
PYTHON_TABLE = """

def {name}(t):
    return np.interp(t, {times}, {values})
"""
C = """\
/* {about} */
#include <math.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif
{tables}
void equations(double t, const double *q, const double *u, const double *p, double *M, double *f)
{{
{body}
}}
"""
C_TABLE = """
static double {name}(double t)
{{
    static const double times[] = {{{times}}}, values[] = {{{values}}};
    const int last = sizeof times / sizeof *times - 1;
    int k = 0;
    if (t <= times[0]) return values[0];
    if (t >= times[last]) return values[last];
    while (times[k + 1] < t) ++k;
    return values[k] + (values[k + 1] - values[k]) * ((t - times[k]) / (times[k + 1] - times[k]));
}}
"""
C_WORDS = (
    "auto", "case", "char", "const", "default", "do", "double", "enum", "extern", "float", "goto",
    "inline", "int", "long", "register", "restrict", "short", "signed", "sizeof", "static",
    "struct", "switch", "typedef", "union", "unsigned", "void", "volatile",
    "M_PI", "cbrt", "exp2", "fabs", "fmax", "fmin", "pow",
)  # fmt: skip
TAKEN = {
    *("t", "q", "u", "p", "M", "f", "np", "PARAMETERS", "equations"),
    *C_WORDS,
    *keyword.kwlist,
}
"""Names that mean something in what is written."""


def equations_code(equations: Equations, language: Language) -> str:
    """Source of a function of t, q, u and p that gives M and f.

    In Python it returns them as arrays, n×n and n; in C it fills them, M row by row. p has the
    model's parameters, its neutral masses (not a number unless they are given) and its added mass.
    Everything is in SI units. InputError for an unknown language.
    """
    if language not in get_args(Language):
        remedy = suggestion(language, get_args(Language), "languages")
        raise InputError.single(f"there is no code in {language!r}", remedy)
    scalars = equations.assembly.scalars
    p = [*scalars.parameters.values(), *chain(*scalars.added_mass)]
    vectors = [*scalars.q], [*scalars.u], p
    names = _names({*(s.name for group in vectors for s in group), *equations.model.tables})
    about = "\n".join(_about(equations, p))
    lines = _body(equations, vectors, names, python=language == "python")
    body = "\n".join(f"    {line}" for line in lines)
    tables = "".join(
        _table(names[name], table, language)
        for name, table in equations.model.tables.items()
        if f"{names[name]}(" in body
    )
    if language == "c":
        return C.format(about=about.replace("*/", "* /"), tables=tables, body=body)
    known = parameter_values(equations.model.parameters)
    known |= dict.fromkeys(map(neutral_symbol, equations.neutral_bodies), math.nan)
    values = [known.get(symbol.name, 0.0) for symbol in p]
    about = about.replace("\\", "/").replace('"', "'")
    return PYTHON.format(about=about, tables=tables, values=_tuple(values), body=body)


def _about(equations: Equations, p: list[AnyScalar]) -> list[str]:
    n = len(equations.topology.velocity_names)
    name = " ".join(equations.model.name.split())

    def listed(letter: str, names: list[str]) -> str:
        return fill(f"{letter}  {', '.join(names) or 'nothing'}", 95, subsequent_indent="   ")

    return [
        f"{name}: M(q) du/dt = f(t, q, u), {rates_text(equations)}.",
        "",
        "t  time [s]",
        listed("q", list(equations.topology.coordinate_names)),
        listed("u", list(equations.topology.velocity_names)),
        listed("p", [symbol.name for symbol in p]),
        f"M  mass matrix, {n} by {n}, row by row",
        f"f  forcing, {n}",
        "",
        "SI units, angles in radians. Written by m4e_fmi.",
    ]


def _body(
    equations: Equations,
    vectors: tuple[list[AnyScalar], ...],
    names: dict[str, str],
    *,
    python: bool,
) -> list[str]:
    """The lines that compute M and f from `vectors` q, u and p."""
    import sympy

    M, n = equations.mass_matrix, len(vectors[1])
    places = [(i, j) for i in range(n) for j in range(i, n) if M[i, j] != 0]
    entries: list[AnyScalar] = [*(M[at] for at in places), *equations.forcing]
    values: list[AnyScalar] = [sympy.sympify(value, strict=True) for value in entries]
    shared, values = intermediates(values, vectors[0], {*TAKEN, *names.values()})
    needed = set().union(*(v.free_symbols for v in (*values, *(value for _, value in shared))))
    show = partial(_printed, names=names, python=python)
    declare, end = ("", "") if python else ("const double ", ";")
    lines = [
        f"{declare}{names[symbol.name]} = {letter}[{k}]{end}"
        for letter, group in zip("qup", vectors, strict=True)
        for k, symbol in enumerate(group)
        if symbol in needed
    ]
    lines += [f"{declare}{symbol} = {show(value)}{end}" for symbol, value in shared]
    lines += [f"M = np.zeros(({n}, {n}))", f"f = np.zeros({n})"] if python else []
    full = {places[k]: show(value) for k, value in enumerate(values[: len(places)])}
    for i, j in places if python else [(i, j) for i in range(n) for j in range(n)]:
        value = full.get((min(i, j), max(i, j)), "0.0")
        both = f"M[{i}, {j}] = M[{j}, {i}]" if i != j else f"M[{i}, {i}]"
        entry = both if python else f"M[{n * i + j}]"
        lines.append(f"{entry} = {value if python or i <= j else f'M[{n * j + i}]'}{end}")
    forces = values[len(places) :]
    return [*lines, *(f"f[{i}] = {show(value)}{end}" for i, value in enumerate(forces))]


def _names(names: Collection[str]) -> dict[str, str]:
    """Names of symbols and tables in code: with _ behind a name that has a meaning already."""
    result = {}
    for name in names:
        new = name
        while new in TAKEN or (new != name and new in names):
            new += "_"
        result[name] = new
    return result


def _printed(value: AnyScalar, *, names: dict[str, str], python: bool) -> str:
    import sympy

    symbols = {s: sympy.Symbol(names.get(s.name, s.name), real=True) for s in value.free_symbols}
    value = value.xreplace(symbols)
    if not python:
        return str(sympy.ccode(value, standard="C99", user_functions=names))
    value = value.replace(sympy.sign, sympy.Function("sign_of"))
    known = {**names, "sign_of": "np.sign"}
    return str(sympy.pycode(value, fully_qualified_modules=False, user_functions=known))


def _table(name: str, table: Table, language: Language) -> str:
    factor = parse_unit(table.unit).factor
    times, values = _tuple(table.times), _tuple([factor * value for value in table.values])
    if language == "python":
        return PYTHON_TABLE.format(name=name, times=times, values=values)
    return C_TABLE.format(name=name, times=times[1:-1], values=values[1:-1])


def _tuple(values: AnyScalar) -> str:
    """A tuple of numbers, on lines of its own if there are many."""
    text = str(tuple(float(value) for value in values)).replace("nan", 'float("nan")')
    return fill(text, 80, subsequent_indent="    ", break_on_hyphens=False, break_long_words=False)
