"""A controller of joints: each is led to its target on a smooth path, by proportional, integral and
derivative action."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, StringConstraints

from m4e_fmi.files.document import Section
from m4e_fmi.program import Program, Recorder, Scalar, Variable, maximum, minimum

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
SHORTEST = 1e-6
"""Least duration [s] that the parameter of the FMU may have."""


class JointSection(Section):
    """One joint: where it goes [rad], and the gains.

    proportional [N·m/rad]; integral [N·m/(rad·s)]; derivative [N·m·s/rad]; most [N·m] limits the
    effort. Of a joint that slides all are in m and N instead, which `slides` says.
    """

    target: Finite
    begin: Finite = 0.0
    proportional: NonNegative
    integral: NonNegative = 0.0
    derivative: NonNegative = 0.0
    most: Positive | None = None
    slides: bool = False


class JointPidConfig(Section):
    """The keys of a component of `kind: joint_pid`, without `kind` and `start`.

    joints: by name, in the order of the FMU's variables; duration [s] of the way from `begin` to
    the target, which starts at the time `after` [s].
    """

    joints: Annotated[dict[Name, JointSection], Field(min_length=1)]
    duration: Annotated[float, Field(ge=SHORTEST, allow_inf_nan=False)]
    after: NonNegative = 0.0


def joint_pid(config: JointPidConfig, *, name: str) -> Program:
    """The program of the controller called `name`.

    With the way r(t) from begin to target, effort = proportional (r − q) + integral ∫(r − q) dt +
    derivative (ṙ − u), between −most and most.
    """
    r = Recorder(name, f"controller of {', '.join(config.joints)}")
    text = "time from begin to target"
    duration = r.parameter(Variable("duration", "s", text, config.duration, minimum=SHORTEST))
    text = "time at which the way begins"
    after = r.parameter(Variable("after", "s", text, config.after, minimum=0.0))
    s = maximum(0.0, minimum(1.0, (r.time - after) / duration))
    # 10 s³ − 15 s⁴ + 6 s⁵ begins and ends without speed and acceleration
    way, rate = s * s * s * (10 - s * (15 - 6 * s)), 30 * s * s * (1 - s) * (1 - s)
    for joint, section in config.joints.items():
        _add_joint(r, joint, section, way, rate / duration)
    return r.program()


def _add_joint(r: Recorder, joint: str, section: JointSection, way: Scalar, rate: Scalar) -> None:
    angle, effort = ("m", "N") if section.slides else ("rad", "N.m")
    units = {
        "begin": angle,
        "target": angle,
        "proportional": f"{effort}/{angle}",
        "integral": f"{effort}/({angle}.s)",
        "derivative": f"{effort}.s/{angle}",
    }
    value: dict[str, Scalar] = {}
    for key, unit in units.items():
        text, start = f"{key} of {joint}", getattr(section, key)
        least = -math.inf if unit == angle else 0.0
        variable = Variable(f"{joint}.{key}", unit, text, start, minimum=least, tunable=True)
        value[key] = r.parameter(variable)
    q = r.input(Variable(f"{joint}.q", angle, f"coordinate of {joint}", section.begin))
    u = r.input(Variable(f"{joint}.u", f"{angle}/s", f"rate of {joint}"))
    stroke = value["target"] - value["begin"]
    wanted = value["begin"] + stroke * way
    error = wanted - q
    total = r.state(Variable(f"{joint}.sum", f"{angle}.s", f"integral of the error of {joint}"))
    r.rate(f"{joint}.sum", error)
    push = value["proportional"] * error + value["integral"] * total
    push = push + value["derivative"] * (stroke * rate - u)
    if section.most is not None:
        text = f"largest effort on {joint}"
        most = r.parameter(Variable(f"{joint}.most", effort, text, section.most, minimum=0.0))
        push = maximum(-most, minimum(most, push))
    r.output(Variable(f"{joint}.effort", effort, f"effort on {joint}'s child"), push)
    r.output(Variable(f"{joint}.wanted", angle, f"where {joint} is to be"), wanted)
    r.output(Variable(f"{joint}.error", angle, f"wanted less coordinate of {joint}"), error)
