"""Programs of which the tests make FMUs of all kinds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from support.driven import driven, fragile
from support.plane import plane

from m4e_fmi.model import Body, Joint, Model, Point, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Variable, sin, sqrt

EXAMPLES = Path(__file__).parents[2] / "examples"
ODD = "odd % %s %n < > & \" ' é 水 {x} \\ \t end"


def pendulum() -> Program:
    return model_program(load_model(EXAMPLES / "double_pendulum/double_pendulum.model.yaml"))


def floating() -> Program:
    model = Model(
        name="floating",
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
    """ẍ = −4x + sin 3t from x = 1, without inputs and parameters."""
    r = Recorder("autonomous", "a forced oscillator")
    x = r.state(Variable("x", "m", "place", start=1.0))
    v = r.state(Variable("v", "m/s", "speed", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", -4.0 * x + sin(3.0 * r.time))
    r.output(Variable("energy", "J", "per kilogram"), (v * v + 4.0 * x * x) / 2)
    return r.program()


def bare() -> Program:
    """No inputs, no parameters, no outputs."""
    r = Recorder("bare", "decays")
    x = r.state(Variable("x", "1", "state", start=1.0))
    r.rate("x", -x)
    return r.program()


def tunable(name: str = "tunable", rate: float = 2.0) -> Program:
    """x' = k (u − x) with a tunable and a fixed parameter, and odd texts."""
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


def brick() -> Program:
    """A free body that turns about the axis of its middle moment of inertia, nearly."""
    model = Model(
        "brick",
        {"brick": Body(1.0, (1.0, 2.0, 3.0))},
        {
            "free": Joint(
                "floating", "brick",
                initial={"phi": 0.3, "theta": -0.2, "psi": 0.5, "omega_x": 0.01, "omega": 2.0},
            )
        },
        gravity=0.0,
        dimensions=3,
    )  # fmt: skip
    return model_program(model)


PROGRAMS: dict[str, Callable[[], Program]] = {
    make.__name__: make
    for make in (
        *(driven, fragile, plane, pendulum, floating, brick, algebraic, autonomous, bare),
        tunable,
    )
}
