"""A system that starts at its equilibrium."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.equilibrium import equilibrium
from m4e_fmi.analysis.points import OperatingPoint, local_parts, operating_point
from m4e_fmi.cosim.composition.compose import resting_program
from m4e_fmi.cosim.composition.static_law import StaticLaw
from m4e_fmi.cosim.preparation.components import Tell
from m4e_fmi.cosim.preparation.inputs import silent
from m4e_fmi.cosim.system.component import Start, StartValue
from m4e_fmi.cosim.system.system import System
from m4e_fmi.joints import ATTITUDE
from m4e_fmi.program import Program

ORIGIN = "equilibrium"
"""Who gives the start values, in messages and results."""


def at_equilibrium(
    system: System, *, build_directory: str | Path = "build", tell: Tell | None = None
) -> System:
    """The system, with all states of its equations at the equilibrium found from its start values.

    What is no equation is settled with what it takes there, as a run initialises it; of an FMU that
    comes to rest only after its start, `tell` gets a warning, as it gets one line of what moved
    most. Inputs that nothing is connected to keep their start values; loads that depend on time are
    those at the start time. InputError and RunError as from `system_program` and `equilibrium`.
    """
    tell = tell or silent
    program = resting_program(system, build_directory=build_directory, tell=tell)
    start = operating_point(program, time=system.simulation.start_time)
    rest = equilibrium(program, at=start)
    for part, law in local_parts(program):
        if isinstance(law, StaticLaw) and law.last.steps:
            tell(
                f"warning: {part.name} is not at rest at its start: it comes to rest "
                f"{law.last.time:g} s later, with its inputs held"
            )
    tell(_moved_most(program, start, rest))
    values = {v.name: float(x) for v, x in zip(program.states, rest.states, strict=True)}
    return _without_angles(system, program).changed(start=values, origin=ORIGIN)


def _moved_most(program: Program, start: OperatingPoint, rest: OperatingPoint) -> str:
    """A line with the change of a state that is largest, over 1 + its value; angles in deg."""
    turned = {k for a in attitudes(program) for k in a.quaternion}
    found: list[tuple[float, str]] = []
    for k, v in enumerate(program.states):
        old, new = float(start.states[k]), float(rest.states[k])
        if k not in turned and not v.local:
            text = f"{v.name}, from {old:.6g} to {new:.6g} {v.unit}"
            found.append((abs(new - old) / (1.0 + abs(new)), text))
    for a in attitudes(program):
        angle = _angle(start.states[list(a.quaternion)], rest.states[list(a.quaternion)])
        found.append((angle, f"the attitude of {a.owner}, by {math.degrees(angle):.4g} deg"))
    largest, text = max(found, default=(0.0, ""))
    if largest == 0.0:
        return "starts at its equilibrium, where it is by its start values"
    return f"starts at its equilibrium; moved most: {text}"


def _angle(one: np.ndarray, other: np.ndarray) -> float:
    """The angle [rad] between two attitudes as quaternions (4,) [1]."""
    cosine = abs(float(one @ other)) / float(np.linalg.norm(one) * np.linalg.norm(other))
    return 2.0 * math.acos(min(1.0, cosine))


def _without_angles(system: System, program: Program) -> System:
    """The system without start values of angles, in whose place are those of quaternions."""
    angles = {f"{a.owner}.{angle}" for a in attitudes(program) for angle in ATTITUDE}

    def kept(component: str, start: Start) -> dict[str, StartValue]:
        return {k: v for k, v in start.items() if f"{component}.{k}" not in angles}

    components = tuple(replace(c, start=kept(c.name, c.start)) for c in system.components)
    return replace(system, components=components)
