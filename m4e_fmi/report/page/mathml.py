"""The equations of motion in MathML, which browsers show without a script or a network."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from html import escape
from typing import TYPE_CHECKING, Any

from m4e_fmi.multibody import Equations
from m4e_fmi.multibody.declaration import state_names
from m4e_fmi.multibody.symbolic.printing import intermediates

if TYPE_CHECKING:
    from xml.dom.minidom import Element

    import sympy
    from sympy.printing.mathml import MathMLPresentationPrinter

LETTERS = {
    "Theta": "θ",
    "Phi": "φ",
    "Psi": "ψ",
    "A": "A",
    **{letter.upper(): letter for letter in "srxyz"},
    **{f"E{k}": f"e{k}" for k in range(4)},
    **{f"Omega{axis}": f"ω{axis.lower()}" for axis in "XYZ"},
}
DOTTED = '<mover>{}<mo lspace="0" rspace="0">.</mo></mover>'
"""A full stop above, which every font has: an accent would need a font for mathematics."""


def equations_markup(equations: Equations) -> Iterator[tuple[str, list[str]]]:
    """Titles and lines of the equations M u̇ = f: what is shared first, then M, then f.

    Each line is HTML with a `math` element. What is zero is left out.
    """
    import sympy

    M, f, n = equations.mass_matrix, equations.forcing, len(equations.topology.velocity_names)
    places = [(i, j) for i in range(n) for j in range(i, n) if M[i, j] != 0]
    values = [sympy.sympify(M[at], strict=True) for at in places]
    forces = [(i, sympy.sympify(f[i, 0], strict=True)) for i in range(n) if f[i, 0] != 0]
    shared, reduced = intermediates([*values, *(v for _, v in forces)], equations.q.flat())
    printer = _printer()
    yield "Coordinates q, velocities u, and the states that they are", _vectors(equations)
    if shared:
        lines = [_line(_name(symbol.name), printer.doprint(value)) for symbol, value in shared]
        yield "Used more than once below", lines
    lines = [
        _line(_indexed("M", i + 1, j + 1), printer.doprint(value))
        for (i, j), value in zip(places, reduced, strict=False)
    ]
    yield "Mass matrix (symmetric: upper half, zeros left out)", lines
    lines = [
        _line(_indexed("f", i + 1), printer.doprint(value))
        for (i, _), value in zip(forces, reduced[len(places) :], strict=True)
    ]
    yield "Forcing, without inputs", lines


def _vectors(equations: Equations) -> list[str]:
    tree, lines = equations.topology, []
    for link in tree.links:
        positions, velocities = state_names(link)
        rows = [
            (k, letter, symbols[k], state)
            for letter, symbols, indices, states in (
                ("q", tree.coordinate_names, link.coordinates, positions),
                ("u", tree.velocity_names, link.speeds, velocities),
            )
            for k, state in zip(indices, states, strict=True)
        ]
        for k, letter, symbol, state in sorted(rows, key=operator.itemgetter(0)):
            math = _line(_indexed(letter, k + 1), _name(symbol))
            lines.append(f"{math}<code>{escape(state)}</code>")
    return lines


def _line(left: str, right: str) -> str:
    right = right.replace("<mo>-</mo>", "<mo>−</mo>")
    return f'<math display="block"><mrow>{left}<mo>=</mo>{right}</mrow></math>'


def _indexed(letter: str, *index: int) -> str:
    numbers = "<mo>,</mo>".join(f"<mn>{k}</mn>" for k in index)
    return f"<msub><mi>{letter}</mi><mrow>{numbers}</mrow></msub>"


def _name(name: str) -> str:
    """ThetaD_1 → θ̇₁; w12 → w₁₂; s1, a sine, upright; others as they are."""
    base, _, index = name.partition("_")
    stem = base.removesuffix("D")
    if index and stem in LETTERS:
        letter = f"<mi>{LETTERS[stem]}</mi>"
        letter = letter if base == stem else DOTTED.format(letter)
        numbers = "<mo>,</mo>".join(f"<mn>{k}</mn>" for k in index.split("_"))
        return f"<msub>{letter}<mrow>{numbers}</mrow></msub>"
    if name[0] in "wsc" and name[1:].isdigit():
        upright = ' mathvariant="normal"' if name[0] in "sc" else ""
        return f"<msub><mi{upright}>{name[0]}</mi><mn>{name[1:]}</mn></msub>"
    words = "".join(f"<mi>{word}</mi>" for word in index.split("_") if word)
    return f"<msub><mi>{base}</mi><mrow>{words}</mrow></msub>" if words else f"<mi>{name}</mi>"


def _printer() -> MathMLPresentationPrinter:
    from sympy.printing.mathml import MathMLPresentationPrinter

    class Printer(MathMLPresentationPrinter):
        """Symbols as `_name` writes them, powers over their indices, 9.81 instead of 981/100."""

        def _print_Symbol(self, sym: sympy.Symbol, style: str = "plain") -> Any:  # noqa: ARG002
            from xml.dom.minidom import parseString

            return parseString(_name(sym.name)).documentElement

        def _print_Pow(self, e: sympy.Pow) -> Element:
            node: Any = super()._print_Pow(e)
            base, power = node.firstChild, node.lastChild
            if node.nodeName != "msup" or base.nodeName != "msub":
                return node
            both = self.dom.createElement("msubsup")
            for part in (*base.childNodes, power):
                both.appendChild(part)
            return both

        def _print_Rational(self, e: sympy.Rational) -> str | Element:
            rest = e.q
            for prime in (2, 5):
                while rest % prime == 0:
                    rest //= prime
            if rest == 1 and e.q > 4:  # a decimal number; halves and quarters stay fractions
                node = self.dom.createElement("mn")
                node.appendChild(self.dom.createTextNode(f"{float(e):.15g}"))
                return node
            return super()._print_Rational(e)

    return Printer()
