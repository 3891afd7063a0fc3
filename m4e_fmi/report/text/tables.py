"""A model as tables of bodies, joints, points, loads and parameters.

The table of joints is that of S. Sabet and A. Diaz-Flores Caminero, "Multibody for Everybody",
figure 2 and table 13; the ground has the number 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from numbers import Real

from m4e_fmi.model import Model
from m4e_fmi.multibody import Topology, topology
from m4e_fmi.shown import columns, one_line
from m4e_fmi.space import AXES


def model_tables(model: Model) -> str:
    """All tables of a model that have rows."""
    tree = topology(model)
    found = (
        _bodies(model, tree),
        _joints(tree),
        _points(model, tree),
        _loads(model, tree),
        _parameters(model),
    )
    return "\n\n".join(filter(None, found))


def _listing(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A title and rows of finished text in columns, with a line under the heads; "" without."""
    if not rows:
        return ""
    rule = ["-" * max(map(len, column)) for column in zip(head, *rows, strict=True)]
    return "\n".join([title, *columns("<" * len(rule), head, rule, *rows)])


def _bodies(model: Model, tree: Topology) -> str:
    rows = []
    for link in tree.links:
        body = model.bodies[link.body]
        given = body.inertia
        inertia = _pair(given) if isinstance(given, (tuple, list)) else _quantity(given)
        held = ", ".join(tree.coordinate_names[k] for k in link.coordinates)
        row = (str(link.number), _word(link.body), _quantity(body.mass), inertia)
        rows.append((*row, _word(held or "none"), _word(body.description)))
    head = ("No.", "Body", "Mass [kg]", "Inertia [kg.m2]", "Coordinates", "Description")
    return _listing("Bodies", head, rows)


def _joints(tree: Topology) -> str:
    rows = []
    for k, link in enumerate(tree.links, start=1):
        joint = link.joint
        free = link.joint_type.is_free
        given = [getattr(joint, f) for f in link.joint_type.vectors]
        direction = ", ".join(_pair(axis) for axis in given) or "-"
        start = ", ".join(f"{key} = {_quantity(value)}" for key, value in joint.initial.items())
        rows.append((
            str(k), _word(link.joint_name), f"{link.parent + 1} {link.number}", _word(joint.type),
            "-" if free else _offset(joint.parent_to_joint, tree),
            "-" if free else _offset(joint.joint_to_child, tree),
            direction, start or "-",
        ))  # fmt: skip
    head = ("No.", "Joint", "Bodies", "Type", "Parent CG to joint", "Joint to child CG",
            "Direction" if tree.is_planar else "Axes", "Start")  # fmt: skip
    return _listing("Joints", head, rows)


def _points(model: Model, tree: Topology) -> str:
    rows = [
        (_word(name), _numbered(tree, point.body), _pair(point.at),
         _word(point.description))
        for name, point in model.points.items()
    ]  # fmt: skip
    return _listing("Points", ("Point", "Body", "From its CG [m]", "Description"), rows)


def _loads(model: Model, tree: Topology) -> str:
    rows = []
    for name, load in model.loads.items():
        ends, quantities = [], []
        for field in fields(load):
            value = getattr(load, field.name)
            if value is None:
                continue
            if field.name in ("body", "bodies"):
                bodies = (value,) if field.name == "body" else value
                ends += [_numbered(tree, body) for body in bodies]
            elif field.name in ("point", "points", "joint"):
                ends += [_word(end) for end in ((value,) if isinstance(value, str) else value)]
            elif about := field.metadata:
                text = _pair(value) if about["is_vector"] else _quantity(value)
                quantities.append(f"{_word(field.name)} = {text}")
            elif value != field.default:
                quantities.append(f"{_word(field.name)}: {_word(value)}")
        row = (name, load.type.replace("_", " "), ", ".join(ends), ", ".join(quantities))
        rows.append((*map(_word, row[:2]), *row[2:]))
    return _listing("Loads", ("Load", "Type", "Acts on", "Quantities"), rows)


def _parameters(model: Model) -> str:
    rows = [
        (_word(name), f"{p.value:.6g}", _word(p.unit), _word(p.description))
        for name, p in model.parameters.items()
    ]
    return _listing("Parameters", ("Parameter", "Value", "Unit", "Description"), rows)


def _numbered(tree: Topology, body: str) -> str:
    return f"{tree.index(body) + 1} {_word(body)}"


def _pair(vector: Sequence[object]) -> str:
    return f"[{', '.join(map(_quantity, vector))}]"


def _offset(vector: Sequence[object], tree: Topology) -> str:
    """A vector of a joint; who gives none has (0, 0) in space, too."""
    return _pair(vector if tree.is_planar or len(vector) == len(AXES) else (0.0, 0.0, 0.0))


def _quantity(value: object) -> str:
    """A number shortly, an expression as it was said."""
    return f"{value:.6g}" if isinstance(value, Real) else str(value)


def _word(text: object) -> str:
    return one_line(str(text))
