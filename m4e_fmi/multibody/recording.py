"""A model's equations of motion as a Program, with the variables its FMU will have."""

from __future__ import annotations

import gc
from collections.abc import Container, Sequence
from itertools import chain
from pathlib import Path
from typing import Protocol

from m4e_fmi.joints import ATTITUDE, TURNING, attitude
from m4e_fmi.model import (
    Body,
    Bushing,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
    Point,
    TensionSpring,
    TorsionSpring,
    as_model,
)
from m4e_fmi.model.elements import GROUND
from m4e_fmi.model.loads import Load
from m4e_fmi.multibody.assembly import (
    Accelerations,
    Assembly,
    assemble,
    input_power,
    kinetic_energy,
    links_with_added_mass,
    load_powers,
    potential_energy,
)
from m4e_fmi.multibody.closed_form import ClosedForm, mass_matrix
from m4e_fmi.multibody.declaration import declared, in_words, state_names
from m4e_fmi.multibody.reactions import reactions
from m4e_fmi.multibody.recursion import Recursion
from m4e_fmi.multibody.topology import Topology, topology
from m4e_fmi.program import AnyScalar, Program, Recorder, Variable
from m4e_fmi.space import AXES, TURN, Vector

ANGLES = (
    "Roll, about the X axis of the body",
    "Pitch, between roll and yaw",
    "Yaw, about the world's Z axis",
)
ALPHAS = ("alpha_x", "alpha", "alpha_z")
LARGEST_CLOSED_FORM = 12
"""Number of coordinates up to which the closed form can need fewer operations."""
UNITS = ("kg", "kg.m", "kg.m2")
"""By the number of angles among the row's and the column's coordinate."""
MEASURES = {
    "tension": ("N", "Tension between the points; negative where it pushes"),
    "distance": ("m", "Distance of the points"),
    "distance_rate": ("m/s", "Rate of the distance of the points"),
    "extension": ("m", "Distance of the points less the natural length"),
    "moment": ("N.m", "Moment on the first body, about +Y; the second feels the opposite"),
    "moment_x": ("N.m", "Moment about the CG, about +X"),
    "moment_z": ("N.m", "Moment about the CG, about +Z"),
    "twist": ("rad", "Angle of the second body less the first's and the angle at rest"),
    "twist_rate": ("rad/s", "Angular velocity of the second body less the first's"),
    "force_x": ("N", "Force, world X"),
    "force_y": ("N", "Force, world Y"),
    "force_z": ("N", "Force, world Z"),
    "effort": ("N.m", "Effort on the joint's child; the parent feels the opposite"),
    "gap": ("m", "How far the nearer limit of the stop is; negative in contact"),
}
"""Unit and text of each measure; an effort's unit is a revolute joint's, a gap's a distance's."""
SPATIAL = {
    "moment": "Moment on the first body, about the axis of the turn; the second feels the opposite",
    "twist": "Angle by which the second body is turned from the first",
    "twist_rate": "Angular velocity of the second body less the first's, about that axis",
}
"""Texts of measures in space."""
RATES = {"distance_rate": "distance", "twist_rate": "twist"}


class Outputs(Protocol):
    """Receiver of outputs: a recorder, or one that reads them."""

    def output(self, variable: Variable, value: AnyScalar) -> None:
        """Take the value of an output."""


def model_program(model: Model | str | Path, *, inputs: Container[str] | None = None) -> Program:
    """The Program of a model, or of the model file at a path.

    Inputs: wrench of every body, force of every point, effort of every revolute and prismatic
    joint; only those named in `inputs` unless that is None, the others are zero. States: q and u.
    Outputs: motion of bodies and points, reactions of joints, forces and power of the loads,
    energies.
    Parameters: the model's, and `added_mass[i,j]` of the bodies that have it.

    Accelerations come from the recursion, or from the closed form where added mass couples bodies;
    of a model with few coordinates both are recorded and the one with fewer operations is taken.
    """
    model = as_model(model)
    collects = gc.isenabled()
    gc.disable()  # many objects are made that stay: a search for garbage is a quarter of the time
    try:
        return _shortest(model, topology(model), inputs)
    finally:
        if collects:
            gc.enable()


def _shortest(model: Model, tree: Topology, inputs: Container[str] | None) -> Program:
    """By the algorithm that needs fewer operations without inputs: it is one for all their choices,
    so that a model gives the same bits whichever inputs there are."""
    if len(links_with_added_mass(model, tree)) > 1:
        return recorded(model, tree, ClosedForm, inputs)
    if len(tree.velocity_names) > LARGEST_CLOSED_FORM:
        return recorded(model, tree, Recursion, inputs)
    bare = {kind: recorded(model, tree, kind, ()) for kind in (Recursion, ClosedForm)}
    best = min(bare, key=lambda kind: len(bare[kind].operations(bare[kind].rates)))
    return bare[best] if inputs == () else recorded(model, tree, best, inputs)


def recorded(
    model: Model,
    tree: Topology,
    algorithm: type[ClosedForm] | type[Recursion],
    inputs: Container[str] | None = None,
) -> Program:
    """The Program of a model whose u̇ comes from `algorithm`; `inputs` as for `model_program`."""
    recorder = Recorder(model.name, model.description or f"Multibody system {model.name}")
    scalars = declared(recorder, model, tree, inputs)
    assembly = assemble(model, tree, scalars)
    solution = algorithm(assembly)
    solved = solution.accelerations
    for link in tree.links:
        positions, velocities = state_names(link)
        q, u = [scalars.q[k] for k in link.coordinates], [scalars.u[j] for j in link.speeds]
        for name, rate in zip(positions, link.joint_type.rates(q, u), strict=True):
            recorder.rate(name, rate)
        for name, j in zip(velocities, link.speeds, strict=True):
            recorder.rate(name, solved.rates[j])
    add_outputs(recorder, assembly, solved)
    solutions = (solution,) if isinstance(solution, Recursion) else ()
    return recorder.program(solutions=solutions)


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


def add_outputs(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    """All outputs of a model in motion, over any scalar."""
    _add_body_outputs(recorder, assembly, solved)
    _add_point_outputs(recorder, assembly, solved)
    _add_load_outputs(recorder, assembly)
    _add_reactions(recorder, assembly, solved)
    kinetic, potential = kinetic_energy(assembly), potential_energy(assembly)
    for name, value, text in (
        ("kinetic", kinetic, "Kinetic energy, added mass included"),
        ("potential", potential, "Potential energy of gravity (0 at Z = 0) and springs"),
        ("total", kinetic + potential, "Kinetic and potential energy"),
    ):
        recorder.output(Variable(f"energy.{name}", "J", text), value)


def _add_body_outputs(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    axes, planar = _axes(assembly.tree), assembly.tree.is_planar
    about = [axis for axis in range(TURN) if TURN + axis in assembly.tree.components]
    for k, (link, frame) in enumerate(zip(assembly.tree.links, assembly.frames, strict=True)):
        name, body = f"body.{link.body}", assembly.model.bodies[link.body]
        states = [*chain(*state_names(link))]
        if not link.joint_type.is_free:  # whose states these are
            _motion(recorder, name, "CG", body, frame.position, frame.velocity, axes)
        angles = (0, frame.angle, 0) if planar else attitude(frame.rotation)
        for axis in about:
            text = in_words(body, "Angle about +Y" if planar else ANGLES[axis])
            if f"{name}.{ATTITUDE[axis]}" not in states:
                angle = Variable(f"{name}.{ATTITUDE[axis]}", "rad", text)
                recorder.output(angle, angles[axis])
        for axis in about:
            text = in_words(body, f"Angular velocity about +{AXES[axis].upper()}")
            of = f"{name}.theta" if planar else None
            if f"{name}.{TURNING[axis]}" not in states:
                omega = Variable(f"{name}.{TURNING[axis]}", "rad/s", text, derivative_of=of)
                recorder.output(omega, frame.omega[axis])
        _accelerations(recorder, name, "CG", body, solved.of_point(frame, k, frame.arm), axes)
        for axis in about:
            text = in_words(body, f"Angular acceleration about +{AXES[axis].upper()}")
            omega = f"{name}.{TURNING[axis]}"
            alpha = f"{name}.{ALPHAS[axis]}"
            variable = Variable(alpha, "rad/s2", text, derivative_of=omega)
            recorder.output(variable, solved.alphas[k][axis])


def _add_point_outputs(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    for name, place in assembly.points.items():
        point = assembly.model.points[name]
        if point.body != GROUND:
            axes = _axes(assembly.tree)
            _motion(recorder, f"point.{name}", "point", point, place.position, place.velocity, axes)
            k = assembly.tree.index(point.body)
            acceleration = solved.of_point(assembly.frames[k], k, place.arm)
            _accelerations(recorder, f"point.{name}", "point", point, acceleration, axes)


def _add_reactions(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    for reaction in reactions(assembly, solved):
        name, joint = f"joint.{reaction.joint}", assembly.model.joints[reaction.joint]
        in_axes = "world" if joint.reaction_axes == "world" else "the child's"
        about = "about +" if joint.reaction_axes == "world" else "about the child's +"
        for axis in _axes(assembly.tree):
            letter = AXES[axis].upper()
            text = in_words(joint, f"Force of the joint on its child, {in_axes} {letter}")
            variable = Variable(f"{name}.reaction_{AXES[axis]}", "N", text)
            recorder.output(variable, reaction.force[axis])
        for axis, part in enumerate(("moment_x", "moment", "moment_z")):
            if TURN + axis in assembly.tree.components:
                text = f"Moment of the joint on its child at the joint, {about}{AXES[axis].upper()}"
                variable = Variable(f"{name}.reaction_{part}", "N.m", in_words(joint, text))
                recorder.output(variable, reaction.moment[axis])


def _add_load_outputs(recorder: Outputs, assembly: Assembly) -> None:
    """Measures and power of every load, and the power of the inputs, if there are any."""
    powers = load_powers(assembly)
    for name, acting in assembly.loads.items():
        load = assembly.model.loads[name]
        for measure, value in acting.measures.items():
            unit, text = _told(assembly, load, measure)
            whole = RATES.get(measure)
            of = f"load.{name}.{whole}" if whole in acting.measures else None
            variable = Variable(
                f"load.{name}.{measure}", unit, in_words(load, text), derivative_of=of
            )
            recorder.output(variable, value)
        if name in powers:
            text = "Power by which the load changes the total energy"
            if isinstance(load, TensionSpring | TorsionSpring):
                text += ", in which it has no potential"
            recorder.output(Variable(f"load.{name}.power", "W", in_words(load, text)), powers[name])
    power = input_power(assembly)
    if not isinstance(power, int):
        text = "Power of all forces, moments and efforts from outside"
        recorder.output(Variable("inputs.power", "W", text), power)


def _told(assembly: Assembly, load: Load, measure: str) -> tuple[str, str]:
    """Unit and text of a measure of a load."""
    unit, text = MEASURES[measure]
    if isinstance(load, JointEffort | JointFriction | JointStop):
        joint_type = assembly.values.state.link(load.joint).joint_type
        coordinate = joint_type.coordinates[joint_type.number_of(load.along)]
        unit = {"effort": coordinate.effort_unit, "gap": coordinate.unit}[measure]
    if measure == "moment" and hasattr(load, "body"):
        text = "Moment about the CG, about +Y"
    elif measure in SPATIAL and not assembly.tree.is_planar:
        text = SPATIAL[measure]
    if isinstance(load, Bushing) and measure.startswith("force"):
        text = (
            f"Force on the first point, world {measure[-1].upper()}; the second feels the opposite"
        )
    return unit, text


def _axes(tree: Topology) -> list[int]:
    """The axes along which bodies move."""
    return [c for c in tree.components if c < TURN]


def _motion(
    recorder: Outputs,
    name: str,
    what: str,
    owner: Body | Point,
    position: Vector,
    velocity: Vector,
    axes: Sequence[int],
) -> None:
    for c in axes:
        text = in_words(owner, f"Position of the {what}, world {AXES[c].upper()}")
        recorder.output(Variable(f"{name}.{AXES[c]}", "m", text), position[c])
    for c in axes:
        text, of = f"Velocity of the {what}, world {AXES[c].upper()}", f"{name}.{AXES[c]}"
        variable = Variable(f"{name}.v{AXES[c]}", "m/s", in_words(owner, text), derivative_of=of)
        recorder.output(variable, velocity[c])


def _accelerations(
    recorder: Outputs,
    name: str,
    what: str,
    owner: Body | Point,
    acceleration: Vector,
    axes: Sequence[int],
) -> None:
    for c in axes:
        text, of = f"Acceleration of the {what}, world {AXES[c].upper()}", f"{name}.v{AXES[c]}"
        variable = Variable(f"{name}.a{AXES[c]}", "m/s2", in_words(owner, text), derivative_of=of)
        recorder.output(variable, acceleration[c])
