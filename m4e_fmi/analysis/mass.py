"""The mass matrix of a program at an operating point: of its model, or its parts' models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from m4e_fmi.analysis.points import Evaluation, Floats, OperatingPoint, operating_point
from m4e_fmi.model import Model
from m4e_fmi.multibody import mass_matrix_program
from m4e_fmi.program import Part, Program, Variable

MassMatrix = Callable[[OperatingPoint], Floats]
"""The mass matrix (n, n) [kg, kg.m, kg.m2] at a point, in the order of the coordinates."""


def mass_matrix(program: Program, model: Model | None, size: int) -> MassMatrix | None:
    """The mass matrix of a program with `size` coordinates; None unless models have all of them.

    It is that of `model`, or of the parts of `program` that come from models, one after the other.
    """
    if model is not None:
        return _of_model(model)
    masses = [_of_part(program, part) for part in program.parts if isinstance(part.origin, Model)]
    if not masses or sum(count for _, count in masses) != size:
        return None
    return lambda point: np.asarray(block_diag(*(mass(point) for mass, _ in masses)), dtype=float)


def _of_model(model: Model) -> MassMatrix:
    evaluation = Evaluation(mass_matrix_program(model))

    def at(point: OperatingPoint) -> Floats:
        found = evaluation.at(point)
        n = round(len(found) ** 0.5)
        return found.reshape(n, n)

    return at


def _of_part(program: Program, part: Part) -> tuple[MassMatrix, int]:
    """The mass matrix of a part, whose values follow from those of `program`; its size."""
    assert isinstance(part.origin, Model)
    mass = mass_matrix_program(part.origin)
    names = [v.name for v in (*mass.parameters, *mass.inputs, *mass.states)]
    variables = tuple(Variable(f"{part.name}.{name}", "1", "value in the part") for name in names)
    nodes = tuple(part.nodes[name] for name in names)
    values = Evaluation(replace(program, outputs=variables, results=nodes))
    evaluation = Evaluation(mass)
    count = round(len(mass.outputs) ** 0.5)

    def at(point: OperatingPoint) -> Floats:
        own = dict(zip(names, values.at(point).tolist(), strict=True))
        inner = operating_point(mass, own, time=point.time)
        return evaluation.at(inner).reshape(count, count)

    return at, count
