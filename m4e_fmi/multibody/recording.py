"""A model's equations of motion as a Program, with the variables its FMU will have."""

from __future__ import annotations

import gc
from collections.abc import Container, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from m4e_fmi.model import JointStop, Model, TensionSpring, TorsionSpring, load_model
from m4e_fmi.model.elements import GROUND, as_expression, parameter_values
from m4e_fmi.multibody.assembly import Accelerations, Assembly, Scalars, assemble, wet_links
from m4e_fmi.multibody.closed_form import ClosedForm
from m4e_fmi.multibody.energy import (
    input_power,
    kinetic_energy,
    load_powers,
    potential_energy,
)
from m4e_fmi.multibody.reactions import reactions
from m4e_fmi.multibody.sensitivity import Recursion
from m4e_fmi.multibody.topology import Link, Topology, topology
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.units import parse_unit

STATES = {
    "revolute": (("q", "u", "rad"),),
    "prismatic": (("q", "u", "m"),),
    "floating": (("x", "vx", "m"), ("z", "vz", "m"), ("theta", "omega", "rad")),
    "fixed": (),
}
DOF_UNITS = ("m", "m", "rad")
LARGEST_CLOSED_FORM = 12
"""Number of coordinates up to which the closed form can need fewer operations."""


def model_program(model: Model | str | Path, *, inputs: Container[str] | None = None) -> Program:
    """The Program of a model, or of the model file at a path.

    Inputs: wrench of every body, force of every point, effort of every revolute and prismatic
    joint; only those named in `inputs` unless that is None, the others are zero. States: q and u.
    Outputs: motion of bodies and points, reactions of joints, power of the loads, energies.
    Parameters: the model's, and `added_mass[i,j]` of the bodies that have it.

    Accelerations come from the recursion, or from the closed form where added mass couples bodies;
    of a model with few coordinates both are recorded and the one with fewer operations is taken.
    """
    if not isinstance(model, Model):
        model = load_model(model)
    tree = topology(model)
    with _collection_paused():
        return _shortest(model, tree, inputs)


@contextmanager
def _collection_paused() -> Iterator[None]:
    """No search for garbage while many objects are made that stay: a quarter of the time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _shortest(model: Model, tree: Topology, inputs: Container[str] | None) -> Program:
    """By the algorithm that needs fewer operations without inputs: it is one for all their choices,
    so that a model gives the same bits whichever inputs there are."""
    if len(wet_links(model, tree)) > 1:
        return recorded(model, tree, ClosedForm, inputs)
    if len(tree.coordinate_names) > LARGEST_CLOSED_FORM:
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
        for (position, velocity), k in zip(state_names(link), link.coordinates, strict=True):
            recorder.rate(position, scalars.u[k])
            recorder.rate(velocity, solved.rates[k])
    add_outputs(recorder, assembly, solved)
    return recorder.program(solution=solution if isinstance(solution, Recursion) else None)


class Inputs(Protocol):
    """What gives scalars for inputs: a recorder, or whoever has others."""

    def input(self, variable: Variable) -> Any: ...


class Outputs(Protocol):
    """What takes outputs: a recorder, or whoever wants to read them."""

    def output(self, variable: Variable, value: Any) -> None: ...


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


def state_names(link: Link) -> list[tuple[str, str]]:
    """(coordinate, velocity) variable names of the states of a link."""
    floating = link.joint.type == "floating"
    owner = f"body.{link.body}" if floating else f"joint.{link.joint_name}"
    return [(f"{owner}.{p}", f"{owner}.{v}") for p, v, _ in STATES[link.joint.type]]


def declared(
    recorder: Recorder, model: Model, tree: Topology, inputs: Container[str] | None = None
) -> Scalars:
    """The parameters, inputs and states of a model, declared."""
    parameters: dict[str, Any] = {}
    for name, parameter in model.parameters.items():
        unit = parse_unit(parameter.unit)
        parameters[name] = recorder.parameter(
            Variable(
                name,
                unit.text if unit.factor == 1.0 else unit.si_text,
                parameter.description or f"Parameter {name}",
                start=parameter.value * unit.factor,
                display_unit=None if unit.factor == 1.0 else unit.text,
            )
        )
    added_mass = _declared_added_mass(recorder, model, tree)
    acting = declared_inputs(recorder, model, tree, inputs)
    q, u = _declared_states(recorder, model, tree)
    return Scalars(q, u, recorder.time, parameters, added_mass=added_mass, **acting)


def _declared_added_mass(recorder: Recorder, model: Model, tree: Topology) -> list[list[Any]]:
    dofs = [
        (link.body, unit)
        for link in tree.links
        if model.bodies[link.body].added_mass
        for unit in DOF_UNITS
    ]
    rows = []
    for i, (body, unit) in enumerate(dofs, start=1):
        row = []
        for j, (other, other_unit) in enumerate(dofs, start=1):
            # force per acceleration: kg, kg.m (force per rad/s² or moment per m/s²), kg.m2
            power = (unit, other_unit).count("rad")
            kind = ("kg", "kg.m", "kg.m2")[power]
            text = f"Added mass at infinite frequency, world axes at the CG, {body} by {other}"
            row.append(recorder.parameter(Variable(f"added_mass[{i},{j}]", kind, text)))
        rows.append(row)
    return rows


def declared_inputs(
    recorder: Inputs, model: Model, tree: Topology, chosen: Container[str] | None = None
) -> dict[str, Any]:
    """What acts from outside, as fields of `Scalars`; of the inputs those that are `chosen`."""

    def force(name: str, unit: str, text: str) -> Any:
        return recorder.input(Variable(name, unit, text)) if chosen is None or name in chosen else 0

    wrench = {
        link.body: (
            force(f"body.{link.body}.force_x", "N", "Force at the CG, world X"),
            force(f"body.{link.body}.force_z", "N", "Force at the CG, world Z"),
            force(f"body.{link.body}.moment_y", "N.m", "Moment about the CG, about +Y"),
        )
        for link in tree.links
    }
    points = {
        name: (
            force(f"point.{name}.force_x", "N", "Force at the point, world X"),
            force(f"point.{name}.force_z", "N", "Force at the point, world Z"),
        )
        for name, point in model.points.items()
        if point.body != GROUND
    }
    efforts = {
        link.joint_name: force(
            f"joint.{link.joint_name}.effort",
            "N.m" if link.joint.type == "revolute" else "N",
            "Generalised force along the joint's coordinate",
        )
        for link in tree.links
        if link.joint.type in ("revolute", "prismatic")
    }
    groups = {"body_wrench": wrench, "point_force": points, "effort": efforts}
    silent = (0, (0, 0), (0, 0, 0))
    return {
        group: {name: value for name, value in members.items() if value not in silent}
        for group, members in groups.items()
    }


def _declared_states(
    recorder: Recorder, model: Model, tree: Topology
) -> tuple[list[Any], list[Any]]:
    values = parameter_values(model.parameters)
    q: list[Any] = [None] * len(tree.coordinate_names)
    u: list[Any] = list(q)
    for link in tree.links:
        pairs = zip(state_names(link), STATES[link.joint.type], link.coordinates, strict=True)
        for (position, velocity), (key, rate_key, unit), k in pairs:
            initial = {
                name: float(as_expression(link.joint.initial.get(name, 0.0)).evaluate(values))
                for name in (key, rate_key)
            }
            symbol = tree.coordinate_names[k]
            q[k] = recorder.state(
                Variable(
                    position,
                    unit,
                    f"Coordinate {symbol} of body {link.body}",
                    start=initial[key],
                )
            )
            u[k] = recorder.state(
                Variable(
                    velocity,
                    f"{unit}/s",
                    f"Velocity {tree.velocity_names[k]} of body {link.body}",
                    start=initial[rate_key],
                    derivative_of=position,
                )
            )
    return q, u


def _add_body_outputs(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    for k, (link, frame) in enumerate(zip(assembly.tree.links, assembly.frames, strict=True)):
        name = f"body.{link.body}"
        if link.joint.type != "floating":
            _motion(recorder, name, "CG", frame.position, frame.velocity)
            recorder.output(Variable(f"{name}.theta", "rad", "Angle about +Y"), frame.angle)
            text = "Angular velocity about +Y"
            omega = Variable(f"{name}.omega", "rad/s", text, derivative_of=f"{name}.theta")
            recorder.output(omega, frame.omega)
        _accelerations(recorder, name, "CG", solved.of_point(frame, k, frame.arm))
        text = "Angular acceleration about +Y"
        variable = Variable(f"{name}.alpha", "rad/s2", text, derivative_of=f"{name}.omega")
        recorder.output(variable, solved.alphas[k])


def _add_point_outputs(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    for name, point in assembly.points.items():
        body = assembly.model.points[name].body
        if body != GROUND:
            _motion(recorder, f"point.{name}", "point", point.position, point.velocity)
            k = assembly.tree.index(body)
            acceleration = solved.of_point(assembly.frames[k], k, point.arm)
            _accelerations(recorder, f"point.{name}", "point", acceleration)


def _add_load_outputs(recorder: Outputs, assembly: Assembly) -> None:
    for name, power in load_powers(assembly).items():
        text = "Power by which the load changes the total energy"
        if isinstance(assembly.model.loads[name], TensionSpring | TorsionSpring):
            text += ", in which it has no potential"
        recorder.output(Variable(f"load.{name}.power", "W", text, local=True), power)
    for name, load in assembly.loads.items():
        if load.gap is not None:
            unit = "rad" if _turns(assembly, name) else "m"
            text = "How far the nearer limit of the stop is; negative in contact"
            recorder.output(Variable(f"load.{name}.gap", unit, text, local=True), load.gap)
    power = input_power(assembly)
    if not isinstance(power, int):
        text = "Power of all forces, moments and efforts from outside"
        recorder.output(Variable("inputs.power", "W", text, local=True), power)


def _turns(assembly: Assembly, name: str) -> bool:
    """Whether a stop limits an angle."""
    stop, joints = assembly.model.loads[name], assembly.model.joints
    return isinstance(stop, JointStop) and joints[stop.joint].type == "revolute"


def _add_reactions(recorder: Outputs, assembly: Assembly, solved: Accelerations) -> None:
    for reaction in reactions(assembly, solved):
        name = f"joint.{reaction.joint}"
        for axis, value in zip("xz", reaction.force, strict=True):
            text = f"Force of the joint on its child, world {axis.upper()}"
            recorder.output(Variable(f"{name}.reaction_{axis}", "N", text), value)
        text = "Moment of the joint on its child at the joint, about +Y"
        recorder.output(Variable(f"{name}.reaction_moment", "N.m", text), reaction.moment)


def _motion(recorder: Outputs, name: str, what: str, position: Any, velocity: Any) -> None:
    for axis, value in zip("xz", position, strict=True):
        text = f"Position of the {what}, world {axis.upper()}"
        recorder.output(Variable(f"{name}.{axis}", "m", text), value)
    for axis, value in zip("xz", velocity, strict=True):
        text = f"Velocity of the {what}, world {axis.upper()}"
        variable = Variable(f"{name}.v{axis}", "m/s", text, derivative_of=f"{name}.{axis}")
        recorder.output(variable, value)


def _accelerations(recorder: Outputs, name: str, what: str, acceleration: Any) -> None:
    for axis, value in zip("xz", acceleration, strict=True):
        text = f"Acceleration of the {what}, world {axis.upper()}"
        variable = Variable(f"{name}.a{axis}", "m/s2", text, derivative_of=f"{name}.v{axis}")
        recorder.output(variable, value)
