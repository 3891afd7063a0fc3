"""Forces of loads, what these depend on and their power, as outputs of a model's program."""

from __future__ import annotations

from typing import Protocol

from m4e_fmi.model import (
    Bushing,
    JointEffort,
    JointFriction,
    JointStop,
    TensionSpring,
    TorsionSpring,
)
from m4e_fmi.model.loads import Load
from m4e_fmi.multibody.assembly import Assembly
from m4e_fmi.multibody.energy import input_power, load_powers
from m4e_fmi.multibody.model_program.declaration import in_words
from m4e_fmi.program import AnyScalar, Variable

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


def add_load_outputs(recorder: Outputs, assembly: Assembly) -> None:
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
