"""The equations of motion as text or LaTeX, and M and f as a function in Python or C.

Common subexpressions get names of their own, which make long equations readable; in code, what
occurs more than once is computed once. Its text stands alone: Python needs NumPy, C needs C99.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, count
from textwrap import fill
from typing import TYPE_CHECKING, Literal, get_args

from m4e_fmi.errors import InputError, suggestion
from m4e_fmi.model import Table
from m4e_fmi.model.elements import neutral_symbol, parameter_values
from m4e_fmi.program import AnyScalar
from m4e_fmi.space import AXES, TURN
from m4e_fmi.units import parse_unit

if TYPE_CHECKING:
    import sympy

    from m4e_fmi.multibody.symbolic.equations import Equations


Shared = list[tuple["sympy.Symbol", "sympy.Expr"]]
"""Names of intermediates, and what they stand for."""
LETTERS = {
    "Theta": (r"\theta", ""),
    "Phi": (r"\varphi", ""),
    "Psi": (r"\psi", ""),
    **{letter.upper(): (letter, "") for letter in "srxyz"},
    **{f"E{k}": ("e", f"{k},") for k in range(4)},
    **{f"Omega{axis.upper()}": (r"\omega", f"{axis},") for axis in AXES},
}
"""How a coordinate is written in LaTeX, and what comes before its number."""
MOST_REPEATED = 80
"""Intermediates up to which a page is written without them."""
MOST_TERMS = 1_000_000
"""Numbers and symbols up to which equations are written out in full."""


MOST_COORDINATES, LONGEST = 12, 20_000
"""Of models whose equations pages and notebooks have: coordinates, and characters of LaTeX."""
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


@dataclass
class _Part:
    """A titled group of lines: names as text and as LaTeX, and their values."""

    title: str
    names: list[tuple[str, str]] = field(default_factory=list)
    values: list[AnyScalar] = field(default_factory=list)

    def add(self, text: str, latex: str, value: AnyScalar) -> None:
        self.names.append((text, latex))
        self.values.append(value)


def notebook_latex(equations: Equations) -> str | None:
    """The lines of the page in LaTeX, for notebooks that become PDF; None if they are too long."""
    if len(equations.topology.coordinate_names) > MOST_COORDINATES:
        return None
    page = equations_text(equations, latex=True)
    made = "\n".join(line for line in page.splitlines() if line.startswith(r"\["))
    return made if len(made) <= LONGEST else None


def equations_text(
    equations: Equations,
    *,
    latex: bool = False,
    reactions: bool = False,
    explicit: bool | None = None,
) -> str:
    """All of `equations`: coordinates, B, Ḃ, mass matrix, forcing, energies; zeros left out.

    With `reactions` those of the joints as well, as functions of q, u and the accelerations. What
    occurs more than once is written on a line of its own if the page is long (`explicit` None), or
    never (True) or always (False). Raises InputError for more than MOST_TERMS terms without them.
    """
    import sympy

    parts = _parts(equations, reactions=reactions)
    names = _latex_names(equations)
    values = [sympy.sympify(value, strict=True) for part in parts for value in part.values]
    if explicit and (size := _terms(values)) > MOST_TERMS:
        name = equations.model.name
        raise InputError.single(
            f"written out in full, the equations of {name!r} have {size:.2g} terms",
            remedy="leave out --explicit (explicit=True): what repeats then gets a name",
        )
    if not explicit:
        shared, reduced = intermediates(values, equations.q.flat())
        if explicit is False or len(shared) > MOST_REPEATED or not equations.topology.is_planar:
            rest = iter(reduced)
            for part in parts:
                part.values = [next(rest) for _ in part.values]
            first = _Part("Intermediates, each used more than once below")
            for symbol, value in shared:
                names[symbol] = _subscripted(symbol.name)
                first.add(symbol.name, names[symbol], value)
            parts.insert(0, first)
    show = partial(sympy.latex, symbol_names=names) if latex else sympy.sstr
    lines = _heading(equations)
    for part in parts:
        lines += ["", part.title]
        for (text, tex), value in zip(part.names, part.values, strict=True):
            lines.append(rf"\[ {tex} = {show(value)} \]" if latex else f"  {text} = {show(value)}")
        if not part.values:
            lines.append("  (all zero)")
    if latex:
        lines = [line if line.startswith("\\[") else f"% {line}".rstrip() for line in lines]
    return "\n".join(lines)


def _heading(equations: Equations) -> list[str]:
    tree = equations.topology
    title = f"{equations.model.name}: {equations.model.description}"
    lines = [" ".join(title.split()), ""]
    for link in tree.links:
        held = ", ".join(tree.coordinate_names[k] for k in link.coordinates)
        holder = f"{link.joint.type} joint {link.joint_name!r} to {link.joint.parent}"
        lines.append(f"body {link.number}: {link.body:<16} {holder:<40} {held}")
    return [*lines, "", f"Equations of motion: M(q) du/dt = f(t, q, u),  {rates_text(equations)}"]


def rates_text(equations: Equations) -> str:
    """How the rates of the coordinates follow from the velocities, in words."""
    if len(equations.q) == len(equations.u):
        return "dq/dt = u"
    return "dq/dt = u but for quaternions e (E0 to E3): de/dt = 1/2 (0, Omega) e"


def _parts(equations: Equations, *, reactions: bool) -> list[_Part]:
    planar = equations.topology.is_planar
    rows = "(v_x, v_z, omega)" if planar else "(v_x, v_y, v_z, omega_x, omega_y, omega_z)"
    matrices = (
        (f"Velocity transformation B: v = B u, rows {rows} of each body",
         "B", "B", equations.B),
        ("Its time derivative: dv/dt = B du/dt + B_dot u",
         "B_dot", r"\dot{B}", equations.B_dot),
        ("Mass matrix M = B^T (M_bodies + A) B, symmetric", "M", "M", equations.mass_matrix),
        ("Forcing f = B^T (g + g_g) - B^T (M_bodies + A) B_dot u", "f", "f", equations.forcing),
    )  # fmt: skip
    result = [_entries(*matrix) for matrix in matrices]
    energies = _Part("Kinetic and potential energy")
    energies.add("T", "T", equations.kinetic_energy)
    energies.add("V", "V", equations.potential_energy)
    result.append(energies)
    if equations.load_powers:
        powers = _Part("Power of loads that changes T + V")
        for name, power in equations.load_powers.items():
            powers.add(f"P[{name}]", rf"P_{{\mathrm{{{_escaped(name)}}}}}", power)
        result.append(powers)
    if reactions:
        kinds = "(x, z) and moment (y)" if planar else "and moment (x, y, z)"
        turned = [n for n, j in equations.model.joints.items() if j.reaction_axes == "body"]
        axes = f"; of {', '.join(turned)} in the axes of the child" if turned else ""
        carried = _Part(f"Force {kinds} of each joint on its child, at the joint{axes}")
        for joint, wrench in equations.reactions.items():
            for c, entry in zip(equations.topology.components, wrench.flat(), strict=True):
                letter, axis = "R" if c < TURN else "M", AXES[c % TURN]
                tex = rf"{letter}_{{\mathrm{{{_escaped(joint)}}},{axis}}}"
                carried.add(f"{letter}[{joint}].{axis}", tex, entry)
        result.append(carried)
    return result


def _entries(title: str, letter: str, tex: str, matrix: AnyScalar) -> _Part:
    """The entries that are not zero; of a symmetric matrix those of the upper half."""
    part = _Part(title)
    for i in range(matrix.rows):
        for j in range(i if letter == "M" else 0, matrix.cols):
            if matrix[i, j] != 0:
                index = f"{i + 1}" if matrix.cols == 1 else f"{i + 1},{j + 1}"
                part.add(f"{letter}[{index}]", f"{tex}_{{{index}}}", matrix[i, j])
    return part


def _latex_names(equations: Equations) -> dict[AnyScalar, str]:
    """How coordinates and velocities are written: Theta_1 → \\theta_{1}, ThetaD_1 → \\dot{…}."""
    result = {}
    for symbol in (*equations.q.flat(), *equations.u.flat(), *equations.u_dot.flat()):
        name, number = symbol.name.split("_")
        letter = name.rstrip("D")
        dots = len(name) - len(letter)
        mark, index = LETTERS[letter]
        dotted = (mark, rf"\dot{{{mark}}}", rf"\ddot{{{mark}}}")[dots]
        result[symbol] = f"{dotted}_{{{index}{number}}}"
    return result


def _subscripted(name: str) -> str:
    """w12 → w_{12}; sines and cosines upright, for s_k is a slide."""
    name = re.sub(r"^([a-z])(\d+)$", r"\1_{\2}", name)
    return rf"\mathrm{{{name[0]}}}{name[1:]}" if name.startswith(("s", "c")) else name


def _escaped(name: str) -> str:
    return name.replace("_", r"\_")


def intermediates(
    expressions: Sequence[AnyScalar],
    coordinates: Sequence[sympy.Symbol],
    taken: Collection[str] = (),
) -> tuple[Shared, list[sympy.Expr]]:
    """Lines to compute first, in order, and the expressions in terms of them.

    Sine and cosine of coordinate k are `s<k>` and `c<k>`, all else that occurs more than once is
    `w1`, `w2`, …, unless it is a multiple of one symbol. Names in `taken`, or of symbols in the
    expressions, are left out. Nothing is expanded or simplified.
    """
    import sympy

    placeholders = sympy.numbered_symbols("shared", cls=sympy.Dummy)
    cse: AnyScalar = sympy.cse
    found, reduced = cse(expressions, symbols=placeholders, order="none", list=True)
    # of the lines: a walk over the expressions would meet what they share again and again
    lines = [*(line for _, line in found), *reduced]
    symbols = {s for line in lines for s in line.free_symbols if not isinstance(s, sympy.Dummy)}
    used = {*taken, *(s.name for s in symbols if isinstance(s, sympy.Symbol))}
    numbered = (name for k in count(1) if (name := f"w{k}") not in used)
    new: dict[sympy.Basic, sympy.Basic] = {}
    shared: Shared = []
    for placeholder, expression in found:
        value = expression.xreplace(new)
        _, rest = value.as_coeff_Mul()
        if rest.is_Symbol:
            new[placeholder] = value
            continue
        name = _of_angle(value, coordinates)
        symbol = sympy.Symbol(next(numbered) if name is None or name in used else name, real=True)
        used.add(symbol.name)
        new[placeholder] = symbol
        shared.append((symbol, value))
    return shared, [expression.xreplace(new) for expression in reduced]


def _terms(expressions: Sequence[AnyScalar]) -> int:
    """Numbers and symbols in all of `expressions` as they are written out in full.

    Exact at any size: each expression that others share is counted once and then multiplied.
    """
    import sympy

    counts: dict[sympy.Basic, int] = {}
    waiting = [sympy.sympify(expression, strict=True) for expression in expressions]
    wanted = list(waiting)
    while waiting:
        expression = waiting[-1]
        missing = [part for part in expression.args if part not in counts]
        if missing:
            waiting += missing
        else:
            counts[expression] = sum(counts[part] for part in expression.args) or 1
            waiting.pop()
    return sum(counts[expression] for expression in wanted)


def _of_angle(value: sympy.Expr, coordinates: Sequence[sympy.Symbol]) -> str | None:
    """The name of the sine or cosine of a coordinate, None for anything else."""
    import sympy

    if isinstance(value, sympy.sin | sympy.cos):
        angle = value.args[0]
        if isinstance(angle, sympy.Symbol) and angle in coordinates:
            letter = "s" if isinstance(value, sympy.sin) else "c"
            return letter + angle.name.rpartition("_")[2]
    return None


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
