"""A driven oscillator with every kind of variable and dependency that an FMU declares."""

from __future__ import annotations

from m4e_fmi.program import Program, Recorder, Variable, sin, sqrt


def driven() -> Program:
    """x' = v, v' = (force − stiffness·x − damping·v)/mass; inputs force [N] and lift [m]."""
    r = Recorder("driven", "a driven oscillator")
    mass = r.parameter(Variable("mass", "kg", "mass", start=2.0))
    stiffness = r.parameter(Variable("stiffness", "N/m", "spring", start=30.0, tunable=True))
    damping = r.parameter(Variable("damping", "N.s/m", "damper", start=0.4))
    force = r.input(Variable("force", "N", "pull", start=1.0))
    lift = r.input(Variable("lift", "m", "of the base"))
    x = r.state(Variable("x", "m", "displacement", start=0.1))
    v = r.state(Variable("v", "m/s", "velocity", derivative_of="x"))
    a = (force - stiffness * x - damping * v) / mass
    r.rate("x", v)
    r.rate("v", a)
    r.output(Variable("a", "m/s2", "acceleration", derivative_of="v"), a)
    r.output(Variable("height", "m", "above ground", display_unit="mm"), x + lift)
    r.output(Variable("pull", "N", "of the spring"), stiffness * x)
    r.output(Variable("momentum", "kg.m/s", "momentum", local=True), mass * v)
    r.output(Variable("energy", "J", "of the spring"), stiffness * x * x / 2.0)
    r.output(Variable("swing", "m", "moving base"), x + lift * sin(3.0 * r.time))
    r.output(Variable("root", "1", "fails below zero"), sqrt(1.0 + x))
    r.calculate(Variable("frequency", "rad/s", "natural"), sqrt(stiffness / mass))
    return r.program()


def fragile() -> Program:
    """x' = rate·x²: from x = 1 at rate 1 the state is infinite at t = 1 s."""
    r = Recorder("fragile", "blows up")
    rate = r.input(Variable("rate", "1/s", "how fast", start=1.0))
    x = r.state(Variable("x", "1", "what grows", start=1.0))
    r.rate("x", sqrt(rate) * x * x)
    r.output(Variable("inverse", "1", "1/(x − 1)"), 1.0 / (x - 1.0))
    return r.program()
