"""A model's equations of motion as a Program, with the variables its FMU will have."""

from __future__ import annotations

import gc
from collections.abc import Callable, Container
from functools import partial
from itertools import chain
from pathlib import Path

from m4e_fmi.joints import ATTITUDE, TURNING, attitude
from m4e_fmi.model import (
    Bushing,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
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
from m4e_fmi.multibody.closed_form import ClosedForm, mass_matrix, reactions
from m4e_fmi.multibody.declaration import Described, declared, in_words, state_names
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
MOTIONS = {
    "": ("Position", "m", None),
    "v": ("Velocity", "m/s", ""),
    "a": ("Acceleration", "m/s2", "v"),
}
"""Letter of a vector → its word, its unit, and the letter of the vector that it is the rate of."""
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
Output = Callable[[Variable, AnyScalar], None]
"""Takes the value of an output."""


def model_program(model: Model | str | Path, *, inputs: Container[str] | None = None) -> Program:
    """The Program of a model, or of the model file at a path.

    Inputs: wrench of every body, force of every point, effort of every revolute and prismatic
    joint; only those named in `inputs` if given, the others are zero. States: q and u.
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
    add_outputs(recorder.output, assembly, solved)
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


def add_outputs(output: Output, assembly: Assembly, solved: Accelerations) -> None:
    """All outputs of a model in motion, over any scalar."""
    _add_body_outputs(output, assembly, solved)
    _add_point_outputs(output, assembly, solved)
    _add_load_outputs(output, assembly)
    _add_reactions(output, assembly, solved)
    kinetic, potential = kinetic_energy(assembly), potential_energy(assembly)
    for name, value, text in (
        ("kinetic", kinetic, "Kinetic energy, added mass included"),
        ("potential", potential, "Potential energy of gravity (0 at Z = 0) and springs"),
        ("total", kinetic + potential, "Kinetic and potential energy"),
    ):
        output(Variable(f"energy.{name}", "J", text), value)


def _add_body_outputs(output: Output, assembly: Assembly, solved: Accelerations) -> None:
    planar = assembly.tree.is_planar
    about = [axis for axis in range(TURN) if TURN + axis in assembly.tree.components]
    for k, (link, frame) in enumerate(zip(assembly.tree.links, assembly.frames, strict=True)):
        name, body = f"body.{link.body}", assembly.model.bodies[link.body]
        give = partial(_give, output, body)
        states = [*chain(*state_names(link))]
        vectors = partial(_give_vector, give, name, "CG", assembly.tree)
        if not link.joint_type.is_free:  # whose states these are
            vectors("", frame.position)
            vectors("v", frame.velocity)
        angles = (0, frame.angle, 0) if planar else attitude(frame.rotation)
        for axis in about:
            if (angle := f"{name}.{ATTITUDE[axis]}") not in states:
                give(angle, "rad", "Angle about +Y" if planar else ANGLES[axis], angles[axis])
        for axis in about:
            if (omega := f"{name}.{TURNING[axis]}") not in states:
                text = f"Angular velocity about +{AXES[axis].upper()}"
                give(omega, "rad/s", text, frame.omega[axis], f"{name}.theta" if planar else None)
        vectors("a", solved.of_point(frame, k, frame.arm))
        for axis in about:
            text = f"Angular acceleration about +{AXES[axis].upper()}"
            alpha, omega = f"{name}.{ALPHAS[axis]}", f"{name}.{TURNING[axis]}"
            give(alpha, "rad/s2", text, solved.alphas[k][axis], omega)


def _give(
    output: Output,
    owner: Described,
    name: str,
    unit: str,
    text: str,
    value: AnyScalar,
    of: str | None = None,
) -> None:
    """Give an output of an element; `of` is the variable that it is the rate of."""
    output(Variable(name, unit, in_words(owner, text), derivative_of=of), value)


def _give_vector(
    give: Callable[..., None], name: str, what: str, tree: Topology, letter: str, vector: Vector
) -> None:
    """Give a position (`letter` ""), velocity ("v") or acceleration ("a") of a body or point."""
    word, unit, below = MOTIONS[letter]
    for c in _axes(tree):
        of = None if below is None else f"{name}.{below}{AXES[c]}"
        text = f"{word} of the {what}, world {AXES[c].upper()}"
        give(f"{name}.{letter}{AXES[c]}", unit, text, vector[c], of)


def _add_point_outputs(output: Output, assembly: Assembly, solved: Accelerations) -> None:
    for name, place in assembly.points.items():
        point = assembly.model.points[name]
        if point.body != GROUND:
            give = partial(_give, output, point)
            vectors = partial(_give_vector, give, f"point.{name}", "point", assembly.tree)
            k = assembly.tree.index(point.body)
            vectors("", place.position)
            vectors("v", place.velocity)
            vectors("a", solved.of_point(assembly.frames[k], k, place.arm))


def _add_reactions(output: Output, assembly: Assembly, solved: Accelerations) -> None:
    for reaction in reactions(assembly, solved):
        joint = assembly.model.joints[reaction.joint]
        give, name = partial(_give, output, joint), f"joint.{reaction.joint}.reaction_"
        whose, of = ("world ", "") if joint.reaction_axes == "world" else ("the child's ",) * 2
        for axis in _axes(assembly.tree):
            text = f"Force of the joint on its child, {whose}{AXES[axis].upper()}"
            give(f"{name}{AXES[axis]}", "N", text, reaction.force[axis])
        for axis, part in enumerate(("moment_x", "moment", "moment_z")):
            if TURN + axis in assembly.tree.components:
                about = f"about {of}+{AXES[axis].upper()}"
                text = f"Moment of the joint on its child at the joint, {about}"
                give(f"{name}{part}", "N.m", text, reaction.moment[axis])


def _add_load_outputs(output: Output, assembly: Assembly) -> None:
    """Measures and power of every load, and the power of the inputs, if there are any."""
    powers = load_powers(assembly)
    for name, acting in assembly.loads.items():
        load = assembly.model.loads[name]
        give = partial(_give, output, load)
        for measure, value in acting.measures.items():
            unit, text = _measure(assembly, load, measure)
            whole = RATES.get(measure)
            of = f"load.{name}.{whole}" if whole in acting.measures else None
            give(f"load.{name}.{measure}", unit, text, value, of)
        if name in powers:
            text = "Power by which the load changes the total energy"
            if isinstance(load, TensionSpring | TorsionSpring):
                text += ", in which it has no potential"
            give(f"load.{name}.power", "W", text, powers[name])
    power = input_power(assembly)
    if not isinstance(power, int):
        text = "Power of all forces, moments and efforts from outside"
        output(Variable("inputs.power", "W", text), power)


def _measure(assembly: Assembly, load: Load, measure: str) -> tuple[str, str]:
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
