"""A model as tables of bodies, joints, points, loads and parameters: plain text or LaTeX.

The table of joints is that of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody",
figure 2 and table 13; the ground has the number 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from numbers import Real
from typing import TYPE_CHECKING, Any

from m4e_fmi.model import Model
from m4e_fmi.model.expression import Expression, ExpressionError, Values
from m4e_fmi.model.quantity import as_expression
from m4e_fmi.multibody import Topology, topology
from m4e_fmi.shown import one_line
from m4e_fmi.space import AXES

if TYPE_CHECKING:
    import sympy

Show = Callable[[object], str]
LATEX = str.maketrans(
    {c: rf"\{c}" for c in "&%$#_{}"} | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}",
     "^": r"\textasciicircum{}"}
)  # fmt: skip


@dataclass(frozen=True)
class Listing:
    """A table: a title, column heads, rows of finished text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def text(self) -> str:
        """In columns, with a line under the heads."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.head))]
        made = ["  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)) for line in lines]
        made.insert(1, "  ".join("-" * width for width in widths))
        return "\n".join([self.title, *(f"  {line}".rstrip() for line in made)])

    def latex(self) -> str:
        """A table environment in the style of the package booktabs; cells are LaTeX already."""
        rows = [" & ".join(row) + r" \\" for row in self.rows]
        head = " & ".join(h.translate(LATEX) for h in self.head) + r" \\"
        return "\n".join([
            r"\begin{table}", rf"\caption{{{self.title.translate(LATEX)}}}",
            rf"\begin{{tabular}}{{{'l' * len(self.head)}}}", r"\toprule", head, r"\midrule",
            *rows, r"\bottomrule", r"\end{tabular}", r"\end{table}",
        ])  # fmt: skip


def model_tables(model: Model, *, latex: bool = False) -> str:
    """All tables of a model that have rows, as text or as LaTeX (needs the package booktabs)."""
    listings = [table for table in model_listings(model, latex=latex) if table.rows]
    if latex:
        return "\n\n".join(table.latex() for table in listings)
    return "\n\n".join(table.text() for table in listings)


def model_listings(model: Model, *, latex: bool = False) -> list[Listing]:
    """Tables of bodies, joints, points, loads and parameters, cells as text or as LaTeX."""
    show: Show = _latex_quantity if latex else _quantity

    def word(text: object) -> str:
        return one_line(str(text)).translate(LATEX if latex else {})

    tree = topology(model)
    return [
        _bodies(model, tree, show, word),
        _joints(tree, show, word),
        _points(model, tree, show, word),
        _loads(model, tree, show, word),
        _parameters(model, word),
    ]


def _bodies(model: Model, tree: Topology, show: Show, word: Show) -> Listing:
    rows = []
    for link in tree.links:
        body = model.bodies[link.body]
        held = ", ".join(tree.coordinate_names[k] for k in link.coordinates)
        row = (str(link.number), word(link.body), show(body.mass), _numbers(body.inertia, show))
        rows.append((*row, word(held or "none"), word(body.description)))
    head = ("No.", "Body", "Mass [kg]", "Inertia [kg.m2]", "Coordinates", "Description")
    return Listing("Bodies", head, tuple(rows))


def _joints(tree: Topology, show: Show, word: Show) -> Listing:
    rows = []
    for k, link in enumerate(tree.links, start=1):
        joint = link.joint
        free = link.joint_type.is_free
        given = [getattr(joint, f) for f in link.joint_type.vectors]
        direction = ", ".join(_pair(axis, show) for axis in given) or "-"
        start = ", ".join(f"{key} = {show(value)}" for key, value in joint.initial.items())
        rows.append((
            str(k), word(link.joint_name), f"{link.parent + 1} {link.number}", word(joint.type),
            "-" if free else _offset(joint.parent_to_joint, tree, show),
            "-" if free else _offset(joint.joint_to_child, tree, show),
            direction, start or "-",
        ))  # fmt: skip
    head = ("No.", "Joint", "Bodies", "Type", "Parent CG to joint", "Joint to child CG",
            "Direction" if tree.is_planar else "Axes", "Start")  # fmt: skip
    return Listing("Joints", head, tuple(rows))


def _points(model: Model, tree: Topology, show: Show, word: Show) -> Listing:
    rows = [
        (word(name), _numbered(tree, point.body, word), _pair(point.at, show),
         word(point.description))
        for name, point in model.points.items()
    ]  # fmt: skip
    return Listing("Points", ("Point", "Body", "From its CG [m]", "Description"), tuple(rows))


def _loads(model: Model, tree: Topology, show: Show, word: Show) -> Listing:
    rows = []
    for name, load in model.loads.items():
        ends, quantities = [], []
        for field in fields(load):
            value = getattr(load, field.name)
            if value is None:
                continue
            if field.name in ("body", "bodies"):
                bodies = (value,) if field.name == "body" else value
                ends += [_numbered(tree, body, word) for body in bodies]
            elif field.name in ("point", "points", "joint"):
                ends += [word(end) for end in ((value,) if isinstance(value, str) else value)]
            elif field.name in getattr(load, "vectors", ()):
                quantities.append(f"{word(field.name)} = {_pair(value, show)}")
            elif field.name in getattr(load, "scalars", {}):
                quantities.append(f"{word(field.name)} = {show(value)}")
            elif value != field.default:
                quantities.append(f"{word(field.name)}: {word(value)}")
        row = (name, load.type.replace("_", " "), ", ".join(ends), ", ".join(quantities))
        rows.append((*map(word, row[:2]), *row[2:]))
    return Listing("Loads", ("Load", "Type", "Acts on", "Quantities"), tuple(rows))


def _parameters(model: Model, word: Show) -> Listing:
    rows = [
        (word(name), f"{p.value:.6g}", word(p.unit), word(p.description))
        for name, p in model.parameters.items()
    ]
    return Listing("Parameters", ("Parameter", "Value", "Unit", "Description"), tuple(rows))


def _numbered(tree: Topology, body: str, word: Show) -> str:
    return f"{tree.index(body) + 1} {word(body)}"


def _pair(vector: Sequence[object], show: Show) -> str:
    return f"[{', '.join(map(show, vector))}]"


def _offset(vector: Sequence[object], tree: Topology, show: Show) -> str:
    """A vector of a joint; who gives none has (0, 0) in space, too."""
    return _pair(vector if tree.is_planar or len(vector) == len(AXES) else (0.0, 0.0, 0.0), show)


def _numbers(value: object, show: Show) -> str:
    """A number, or the numbers of a tensor."""
    return _pair(value, show) if isinstance(value, tuple | list) else show(value)


def _quantity(value: object) -> str:
    """A number shortly, an expression as it was said."""
    return f"{value:.6g}" if isinstance(value, Real) else str(value)


def _latex_quantity(value: Any) -> str:
    import sympy

    if isinstance(value, Real):
        return f"${sympy.latex(sympy.Float(float(value)).n(6) if value % 1 else int(value))}$"  # type: ignore[operator]
    try:
        expression = as_expression(value)
        return f"${sympy.latex(_symbolic(expression))}$"
    except ExpressionError:
        return str(value).translate(LATEX)


def _symbolic(expression: Expression) -> sympy.Expr:
    """An expression over SymPy's symbols, numbers as they are read: 0.1 is 1/10 no longer."""
    import sympy

    def number(value: float) -> sympy.Expr:
        return sympy.Integer(int(value)) if value == int(value) else sympy.Float(value, 6)

    symbols = {name: sympy.Symbol(name) for name in expression.names()}
    return expression.evaluate(Values({**symbols, "pi": sympy.pi}, number=number))
