"""The equations of motion as text or LaTeX.

Common subexpressions get names of their own, which make long equations readable.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import TYPE_CHECKING

from m4e_fmi.program import AnyScalar
from m4e_fmi.space import AXES, TURN

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


MOST_COORDINATES, LONGEST = 12, 20_000
"""Of models whose equations pages and notebooks have: coordinates, and characters of LaTeX."""


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
) -> str:
    """All of `equations`: coordinates, B, Ḃ, mass matrix, forcing, energies; zeros left out.

    With `reactions` those of the joints as well, as functions of q, u and the accelerations. What
    occurs more than once is written on a line of its own if the page is long.
    """
    import sympy

    parts = _parts(equations, reactions=reactions)
    names = _latex_names(equations)
    values = [sympy.sympify(value, strict=True) for part in parts for value in part.values]
    shared, reduced = intermediates(values, equations.q.flat())
    if len(shared) > MOST_REPEATED or not equations.topology.is_planar:
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
) -> tuple[Shared, list[sympy.Expr]]:
    """Lines to compute first, in order, and the expressions in terms of them.

    Sine and cosine of coordinate k are `s<k>` and `c<k>`, all else that occurs more than once is
    `w1`, `w2`, …, unless it is a multiple of one symbol. Names of symbols in the expressions
    are left out. Nothing is expanded or simplified.
    """
    import sympy

    placeholders = sympy.numbered_symbols("shared", cls=sympy.Dummy)
    cse: AnyScalar = sympy.cse
    found, reduced = cse(expressions, symbols=placeholders, order="none", list=True)
    # of the lines: a walk over the expressions would meet what they share again and again
    lines = [*(line for _, line in found), *reduced]
    symbols = {s for line in lines for s in line.free_symbols if not isinstance(s, sympy.Dummy)}
    used = {s.name for s in symbols if isinstance(s, sympy.Symbol)}
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


def _of_angle(value: sympy.Expr, coordinates: Sequence[sympy.Symbol]) -> str | None:
    """The name of the sine or cosine of a coordinate, None for anything else."""
    import sympy

    if isinstance(value, sympy.sin | sympy.cos):
        angle = value.args[0]
        if isinstance(angle, sympy.Symbol) and angle in coordinates:
            letter = "s" if isinstance(value, sympy.sin) else "c"
            return letter + angle.name.rpartition("_")[2]
    return None
