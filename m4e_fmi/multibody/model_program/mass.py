"""The mass matrix of a model as a Program, to evaluate at any configuration."""

from __future__ import annotations

from itertools import chain

from m4e_fmi.model import Model
from m4e_fmi.multibody.assembly import assemble
from m4e_fmi.multibody.closed_form import mass_matrix
from m4e_fmi.multibody.model_program.declaration import declared, state_names
from m4e_fmi.multibody.topology import topology
from m4e_fmi.program import Program, Recorder, Variable

UNITS = ("kg", "kg.m", "kg.m2")
"""By the number of angles among the row's and the column's coordinate."""


def mass_matrix_program(model: Model) -> Program:
    """The mass matrix Bᵀ(𝓜 + A)B as n² outputs ``mass_matrix[i,j]``, row by row.

    Parameters, inputs and states are those of `model_program`; the states' rates are zero.
    """
    tree = topology(model)
    recorder = Recorder(model.name, f"Mass matrix of {model.name}")
    scalars = declared(recorder, model, tree)
    for name in chain.from_iterable(chain.from_iterable(map(state_names, tree.links))):
        recorder.rate(name, 0.0)
    rows = mass_matrix(assemble(model, tree, scalars))
    angles = [turns for link in tree.links for turns in link.joint_type.turns]
    for i, row in enumerate(rows):
        for j in range(len(rows)):
            text = f"Mass matrix, {tree.velocity_names[i]} by {tree.velocity_names[j]}"
            variable = Variable(f"mass_matrix[{i + 1},{j + 1}]", UNITS[angles[i] + angles[j]], text)
            recorder.output(variable, row.get(j, 0.0))
    return recorder.program()
