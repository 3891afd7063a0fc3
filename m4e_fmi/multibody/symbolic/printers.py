"""SymPy's printers for equations of motion, and how their symbols are written.

Text has blanks between factors, subscripts, superscripts and Greek letters, all on one line.
Numbers that came as decimals are decimals again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import sympy
from sympy.printing.latex import LatexPrinter, translate
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pretty.pretty_symbology import greek_unicode
from sympy.printing.str import StrPrinter

from m4e_fmi.program import AnyScalar
from m4e_fmi.space import AXES

Written = tuple[str, str]
"""A symbol as text and as LaTeX."""
LETTERS = {
    "Theta": ("θ", r"\theta", ""),
    "Phi": ("φ", r"\varphi", ""),
    "Psi": ("ψ", r"\psi", ""),
    **{letter.upper(): (letter, letter, "") for letter in "srxyz"},
    **{f"E{k}": ("e", "e", f"{k},") for k in range(4)},
    **{f"Omega{axis.upper()}": ("ω", r"\omega", f"{axis},") for axis in AXES},
}
"""How a coordinate is written, and what comes before its number."""
DOTS = (("", ""), ("\u0307", r"\dot"), ("\u0308", r"\ddot"))
PARAMETER = re.compile(r"([A-Za-z]+?)(?:_?(\d+(?:_\d+)*)|_(\w+))?")
"""A parameter's name: what stands on the line, and numbers or a word as its subscript."""
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
PI = sympy.Symbol("π", real=True)
DIGITS = 15
"""Of a decimal number; longer ones remain fractions."""


def coordinate(name: str) -> Written:
    """A coordinate or its rate: ThetaD_1 → θ̇₁."""
    name, number = name.split("_")
    letter = name.rstrip("D")
    (dot, command), (text, tex, index) = DOTS[len(name) - len(letter)], LETTERS[letter]
    tex = f"{command}{{{tex}}}" if command else tex
    index += number
    return f"{text}{dot}{index.translate(LOWERED)}", f"{tex}_{{{index}}}"


def parameter(name: str) -> Written:
    """Any other symbol: L1 → L₁, rho → ρ; several letters are upright in LaTeX."""
    if not (match := PARAMETER.fullmatch(name)):
        return name, upright(name)
    base, numbers, word = match.groups()
    text = greek_unicode.get(base, base)
    tex = base if len(base) == 1 else translate(base) if text != base else upright(base)
    if numbers:
        numbers = numbers.replace("_", ",")
        return text + numbers.translate(LOWERED), f"{tex}_{{{numbers}}}"
    return (f"{text}_{word}", f"{tex}_{{{upright(word)}}}") if word else (text, tex)


def upright(name: str) -> str:
    """A word in LaTeX."""
    return rf"\mathrm{{{name}}}".replace("_", r"\_")


class Writer:
    """Writes expressions of `symbols` as text and as LaTeX.

    Those in `known` are written as said there; parameters that would be written like another symbol
    keep their names.
    """

    def __init__(self, symbols: Iterable[sympy.Symbol], known: dict[sympy.Symbol, Written]) -> None:
        texts = {text for text, _ in known.values()}
        written = {s: parameter(s.name) for s in symbols if s not in known}
        made = [text for text, _ in written.values()]
        for s, (text, _) in written.items():
            if text in texts or made.count(text) > 1:
                written[s] = s.name, upright(s.name)
        self.written = known | written
        # SymPy sorts by names: Greek letters come after those of parameters
        self._symbols = {s: sympy.Symbol(t, real=True) for s, (t, _) in self.written.items()}
        names = {self._symbols[s]: tex for s, (_, tex) in self.written.items()} | {PI: r"\pi"}
        self._text = _Text()
        self._latex = _Latex({"symbol_names": names, "mul_symbol": r" \, "})

    def text(self, value: sympy.Expr) -> str:
        """On one line; it may be broken at its blanks, but not at those that do not break."""
        text = self._text.doprint(self._prepared(value)).replace("*", "\u00a0")
        return re.sub(r" ([+-]) ", " \\1\u00a0", text)

    def latex(self, value: sympy.Expr) -> str:
        """For the math mode of LaTeX."""
        return self._latex.doprint(self._prepared(value))

    def _prepared(self, value: sympy.Expr) -> AnyScalar:
        """With symbols as they are written, also for decimals, which keeps them unevaluated."""
        found: dict[sympy.Basic, AnyScalar] = {**self._symbols, sympy.pi: PI}
        for number in value.atoms(sympy.Rational):
            decimal = f"{float(abs(number)):.{DIGITS}g}"
            if number.q % 5 == 0 and sympy.Rational(decimal) == abs(number):
                symbol = sympy.Symbol(decimal, real=True)
                found[number] = -symbol if number < 0 else symbol
        return value.xreplace(found)


class _Positive:
    """Sums begin with a term without a minus, if they have one."""

    def _as_ordered_terms(self, expr: AnyScalar, order: AnyScalar = None) -> list[AnyScalar]:
        terms = super()._as_ordered_terms(expr, order=order)  # pyrefly: ignore[missing-attribute]
        first = next((t for t in terms if not t.could_extract_minus_sign()), terms[0])
        return sorted(terms, key=lambda term: term is not first)


class _Latex(_Positive, LatexPrinter):
    """LaTeX."""


class _Text(_Positive, StrPrinter):
    """Text in Unicode."""

    def _print_Pow(self, expr: AnyScalar, rational: bool = False) -> str:
        base, exponent = expr.args
        if not exponent.is_Integer or exponent == -1:
            return super()._print_Pow(expr, rational=rational).replace("**", "^")
        power = str(exponent).translate(RAISED)
        if isinstance(base, sympy.sin | sympy.cos | sympy.tan) and exponent > 0:
            return f"{base.func.__name__}{power}({self._print(base.args[0])})"
        return self.parenthesize(base, PRECEDENCE["Pow"], strict=False) + power

    def _print_Abs(self, expr: AnyScalar) -> str:
        return f"|{self._print(expr.args[0])}|"
