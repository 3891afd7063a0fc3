"""Programs of which the tests make Python FMUs, and their slaves."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from m4e_fmi.model import Body, Joint, Model, Point
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Variable, exp, sin, sqrt

EXAMPLES = Path(__file__).parents[2] / "examples"
ODD = "odd % %s %n < > & \" ' é 水 {x} \\ \t end"


def double_pendulum() -> Program:
    return model_program(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml")


def floating_body() -> Program:
    model = Model(
        name="floating_body",
        gravity=9.81,
        bodies={"hull": Body(5.0, 2.0, added_mass=True)},
        joints={"sea": Joint("floating", "hull", initial={"x": 1.0, "z": -0.5, "omega": 0.1})},
        points={"eye": Point("hull", (1.0, 0.3))},
    )
    added = ((4.0, 0.3, 0.2), (0.3, 6.0, 0.5), (0.2, 0.5, 1.0))
    start = {f"added_mass[{i + 1},{j + 1}]": added[i][j] for i in range(3) for j in range(3)}
    return model_program(model).with_start(start)


def algebraic() -> Program:
    """No states."""
    r = Recorder("algebraic", "a function of its inputs")
    a, b = r.input(Variable("a", "m", "one", start=3.0)), r.input(Variable("b", "m", "other"))
    gain = r.parameter(Variable("gain", "1", "factor", start=2.0))
    r.output(Variable("norm", "m", "length"), gain * sqrt(a * a + b * b))
    r.output(Variable("clock", "s", "time"), r.time + 0.0)
    return r.program()


def autonomous() -> Program:
    """No inputs and no parameters."""
    r = Recorder("autonomous", "a forced oscillator")
    x = r.state(Variable("x", "m", "place", start=1.0))
    v = r.state(Variable("v", "m/s", "speed", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", -4.0 * x + sin(3.0 * r.time))
    r.output(Variable("energy", "J", "per kilogram"), (v * v + 4.0 * x * x) / 2)
    return r.program()


def tunable(name: str = "tunable", rate: float = 2.0) -> Program:
    """A leaky integrator with a tunable and a fixed parameter, and odd texts."""
    r = Recorder(name, ODD)
    k = r.parameter(Variable("k", "1/s", ODD, start=rate, tunable=True))
    scale = r.parameter(Variable("scale", "kN", ODD, start=1.0))
    u = r.input(Variable("u", "1", ODD, start=1.0))
    x = r.state(Variable("x", "1", ODD))
    hidden = r.state(Variable("hidden", "1", ODD, local=True))
    r.rate("x", k * (u - x))
    r.rate("hidden", x)
    r.output(Variable("y", "kN", ODD, display_unit="N"), scale * x + hidden)
    r.calculate(Variable("time_constant", "s", ODD), 1.0 / k)
    return r.program()


def fragile() -> Program:
    """Steps fail for a < 0, outputs for b = 0."""
    r = Recorder("fragile", "breaks on demand")
    a, b = r.input(Variable("a", "1", "≥ 0", start=1.0)), r.input(Variable("b", "1", "≠ 0"))
    x = r.state(Variable("x", "1", "state"))
    r.rate("x", sqrt(a) + exp(x - 800.0))
    r.output(Variable("y", "1", "quotient"), x / b)
    return r.program()


PYTHON_PROGRAMS: dict[str, Callable[[], Program]] = {
    make.__name__: make
    for make in (double_pendulum, floating_body, algebraic, autonomous, tunable, fragile)
}
