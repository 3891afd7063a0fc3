"""The equations of motion as text or LaTeX.

Matrices are written as such where they fit. Common subexpressions get names of their own where this
makes the page much shorter.
"""

from __future__ import annotations

import textwrap
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count, product
from typing import TYPE_CHECKING

import sympy

from m4e_fmi.multibody.symbolic.printers import LOWERED, Writer, Written, coordinate, upright
from m4e_fmi.program import AnyScalar
from m4e_fmi.shown import WIDTH
from m4e_fmi.space import AXES, TURN

if TYPE_CHECKING:
    from m4e_fmi.multibody.symbolic.equations import Equations
    from m4e_fmi.multibody.symbolic.printers import Writer, Written


Shared = list[tuple["sympy.Symbol", "sympy.Expr"]]
"""Names of intermediates, and what they stand for."""
TIMES_SHORTER = 3
"""A page has intermediates where it has so many times fewer symbols and operations with them."""
LEAST_SAVED = 8
"""Symbols and operations that an intermediate saves at least."""


@dataclass
class _Part:
    """A titled group of lines: names as text and as LaTeX, and their values.

    Of a matrix `cells` has the index of the value of each entry, None of those that are zero, and
    `name` is how it is written.
    """

    title: str
    names: list[Written] = field(default_factory=list)
    values: list[AnyScalar] = field(default_factory=list)
    cells: list[list[int | None]] = field(default_factory=list)
    name: Written = ("", "")

    def add(self, text: str, latex: str, value: AnyScalar) -> None:
        self.names.append((text, latex))
        self.values.append(value)

    def rows(self, texts: Sequence[str]) -> list[list[str]]:
        """The entries of the matrix, whose values have these `texts`; none if all are zero."""
        rows = self.cells if texts else []
        return [["0" if k is None else texts[k] for k in row] for row in rows]


def equations_text(
    equations: Equations,
    *,
    latex: bool = False,
    reactions: bool = False,
) -> str:
    """All of `equations`: coordinates, B, Ḃ, mass matrix, forcing, energies; zeros left out.

    With `reactions` those of the joints as well, as functions of q, u and the accelerations. A
    matrix whose rows are longer than a line is given by its entries. What occurs more than once is
    written on a line of its own if that makes the page much shorter.
    """
    parts = _parts(equations, reactions=reactions)
    values = [sympy.sympify(value, strict=True) for part in parts for value in part.values]
    shared, reduced = intermediates(values, equations.q.flat())
    sizes: dict[sympy.Basic, int] = {}
    full, least = (
        sum(tree_size(v, sizes) for v in these)
        for these in (values, (*reduced, *(value for _, value in shared)))
    )
    if full <= TIMES_SHORTER * least:
        shared, reduced = [], values
    rest = iter(reduced)
    for part in parts:
        part.values = [next(rest) for _ in part.values]
    moving = (*equations.q.flat(), *equations.u.flat(), *equations.u_dot.flat())
    known = {symbol: coordinate(symbol.name) for symbol in moving}
    for symbol, value in shared:
        if isinstance(value, sympy.sin | sympy.cos) and value.args[0] in known:
            (text, tex), letter = known[value.args[0]], symbol.name[0]
            known[symbol] = letter + text, rf"\mathrm{{{letter}}}_{{{tex}}}"
    symbols = {s for v in (*reduced, *(v for _, v in shared)) for s in v.free_symbols}
    writer = Writer(sorted(symbols, key=str), known)
    if shared:
        names, lines = [writer.written[s] for s, _ in shared], [value for _, value in shared]
        parts.insert(0, _Part("Intermediates, each used more than once below", names, lines))
    lines = _heading(equations)
    for part in parts:
        lines += ["", part.title, *(_latex(part, writer) if latex else _text(part, writer))]
        if not part.values:
            lines.append("  (all zero)")
    if latex:
        lines = [line if line.startswith("\\[") else f"% {line}".rstrip() for line in lines]
    return "\n".join(lines)


def tree_size(value: sympy.Basic, known: dict[sympy.Basic, int]) -> int:
    """Symbols and operations of an expression, counted as often as they are written."""
    if value not in known:
        known[value] = 1 + sum(tree_size(part, known) for part in value.args)
    return known[value]


def _text(part: _Part, writer: Writer) -> list[str]:
    """The lines of a part as text: a matrix if it fits, else each value."""
    texts = [writer.text(value) for value in part.values]
    if lines := _matrix(f"  {part.name[0]} = ", part.rows(texts)):
        return [line.replace("\u00a0", " ") for line in lines]
    found = list[str]()
    for (name, _), text in zip(part.names, texts, strict=True):
        found += textwrap.wrap(
            f"  {name}\u00a0=\u00a0{text}",
            WIDTH,
            subsequent_indent=" " * (len(name) + 5),
            break_long_words=False,
            break_on_hyphens=False,
        )
    return [line.replace("\u00a0", " ") for line in found]


def _matrix(head: str, rows: list[list[str]]) -> list[str]:
    """Lines of a matrix after `head`; none if they are too long, or it has one entry or none."""
    if sum(map(len, rows)) < 2:
        return []
    widths = [max(map(_width, column)) for column in zip(*rows, strict=True)]
    if len(head) + sum(widths) + 2 * len(widths) + 2 > WIDTH:
        return []
    last, middle = len(rows) - 1, (len(rows) - 1) // 2
    lines = []
    for k, row in enumerate(rows):
        left, right = "[]" if last == 0 else "⎡⎤" if k == 0 else "⎣⎦" if k == last else "⎢⎥"
        cells = "  ".join(c + " " * (w - _width(c)) for c, w in zip(row, widths, strict=True))
        lines.append(f"{head if k == middle else ' ' * len(head)}{left} {cells} {right}")
    return lines


def _width(text: str) -> int:
    """Places that `text` takes in a line: dots stand above letters."""
    return sum(not unicodedata.combining(c) for c in text)


def _latex(part: _Part, writer: Writer) -> list[str]:
    """The lines of a part in LaTeX: a matrix where that of `_text` fits, else each value."""
    made = [writer.latex(value) for value in part.values]
    if _matrix("", part.rows([writer.text(value) for value in part.values])):
        rows = r" \\ ".join(" & ".join(row) for row in part.rows(made))
        return [rf"\[ {part.name[1]} = \begin{{bmatrix}} {rows} \end{{bmatrix}} \]"]
    pairs = zip(part.names, made, strict=True)
    return [rf"\[ {name} = {tex} \]" for (_, name), tex in pairs]


def _heading(equations: Equations) -> list[str]:
    tree = equations.topology
    title = f"{equations.model.name}: {equations.model.description}"
    lines = [" ".join(title.split()), ""]
    for link in tree.links:
        held = ", ".join(coordinate(tree.coordinate_names[k])[0] for k in link.coordinates)
        holder = f"{link.joint.type} joint {link.joint_name!r} to {link.joint.parent}"
        lines.append(f"body {link.number}: {link.body:<16} {holder:<40} {held}".rstrip())
    turned = len(equations.q) > len(equations.u)
    rates = " but for quaternions e (e₀ to e₃): ė = 1/2 (0, ω) e" if turned else ""
    return [*lines, "", f"Equations of motion: M(q) u̇ = f(t, q, u),  q̇ = u{rates}"]


def _parts(equations: Equations, *, reactions: bool) -> list[_Part]:
    planar = equations.topology.is_planar
    rows = "(v_x, v_z, ω)" if planar else "(v_x, v_y, v_z, ω_x, ω_y, ω_z)"
    matrices = (
        (f"Velocity transformation B: v = B u, rows {rows} of each body",
         "B", "B", equations.B),
        ("Its time derivative: v̇ = B u̇ + Ḃ u", "Ḃ", r"\dot{B}", equations.B_dot),
        ("Mass matrix M = Bᵀ (M_bodies + A) B, symmetric", "M", "M", equations.mass_matrix),
        ("Forcing f = Bᵀ (g + g_g) - Bᵀ (M_bodies + A) Ḃ u", "f", "f", equations.forcing),
    )  # fmt: skip
    result = [_entries(*matrix) for matrix in matrices]
    energies = _Part("Kinetic and potential energy")
    energies.add("T", "T", equations.kinetic_energy)
    energies.add("V", "V", equations.potential_energy)
    result.append(energies)
    if equations.load_powers:
        powers = _Part("Power of loads that changes T + V")
        for name, power in equations.load_powers.items():
            powers.add(f"P[{name}]", f"P_{{{upright(name)}}}", power)
        result.append(powers)
    if reactions:
        kinds = "(x, z) and moment (y)" if planar else "and moment (x, y, z)"
        turned = [n for n, j in equations.model.joints.items() if j.reaction_axes == "body"]
        axes = f"; of {', '.join(turned)} in the axes of the child" if turned else ""
        carried = _Part(f"Force {kinds} of each joint on its child, at the joint{axes}")
        for joint, wrench in equations.reactions.items():
            for c, entry in zip(equations.topology.components, wrench.flat(), strict=True):
                letter, axis = "R" if c < TURN else "M", AXES[c % TURN]
                tex = f"{letter}_{{{upright(joint)},{axis}}}"
                carried.add(f"{letter}[{joint}].{axis}", tex, entry)
        result.append(carried)
    return result


def _entries(title: str, letter: str, tex: str, matrix: AnyScalar) -> _Part:
    """The entries that are not zero; of a symmetric matrix those of the upper half."""
    part = _Part(title, name=(letter, tex))
    part.cells = [[None] * matrix.cols for _ in range(matrix.rows)]
    for i, j in product(range(matrix.rows), range(matrix.cols)):
        if letter == "M" and j < i:
            part.cells[i][j] = part.cells[j][i]
        elif matrix[i, j] != 0:
            part.cells[i][j] = len(part.values)
            index = f"{i + 1}" if matrix.cols == 1 else f"{i + 1},{j + 1}"
            name = letter + index.translate(LOWERED), f"{tex}_{{{index}}}"
            part.add(*(name if len(matrix) > 1 else part.name), matrix[i, j])
    return part


def intermediates(
    expressions: Sequence[AnyScalar],
    coordinates: Sequence[sympy.Symbol],
) -> tuple[Shared, list[sympy.Expr]]:
    """Lines to compute first, in order, and the expressions in terms of them.

    Sine and cosine of a coordinate are symbols of their text, all else that occurs more than once
    is `w1`, `w2`, …, if that shortens the lines. Names of symbols in the expressions are left out.
    Nothing is expanded or simplified.
    """
    placeholders = sympy.numbered_symbols("shared", cls=sympy.Dummy)
    cse: AnyScalar = sympy.cse
    found, reduced = cse(expressions, symbols=placeholders, order="none", list=True)
    # of the lines: a walk over the expressions would meet what they share again and again
    lines = [*(line for _, line in found), *reduced]
    uses = Counter(s for line in lines for s in sympy.preorder_traversal(line) if s.is_Symbol)
    used = {s.name for s in uses}
    numbered = (name for k in count(1) if (name := f"w{k}") not in used)
    new: dict[sympy.Basic, sympy.Basic] = {}
    shared: Shared = []
    sizes: dict[sympy.Basic, int] = {}
    for placeholder, expression in found:
        value = expression.xreplace(new)
        if (uses[placeholder] - 1) * (tree_size(value, sizes) - 1) < LEAST_SAVED:
            new[placeholder] = value
            continue
        of_angle = isinstance(value, sympy.sin | sympy.cos) and value.args[0] in coordinates
        symbol = sympy.Symbol(str(value) if of_angle else next(numbered), real=True)
        new[placeholder] = symbol
        shared.append((symbol, value))
    return shared, [expression.xreplace(new) for expression in reduced]
