"""Programs of which the tests make native FMUs of FMI 2.0 and 3.0."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from support.driven import driven, fragile
from support.plane import plane

from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Variable

EXAMPLES = Path(__file__).parents[2] / "examples"


def pendulum() -> Program:
    return model_program(load_model(EXAMPLES / "double_pendulum/double_pendulum.model.yaml"))


def buoy() -> Program:
    return model_program(load_model(EXAMPLES / "moored_buoy/buoy.model.yaml"))


def algebraic() -> Program:
    r = Recorder("algebraic", "no states")
    u = r.input(Variable("u", "1", "input", start=2.0))
    r.output(Variable("y", "1", "output"), 3.0 * u)
    return r.program()


def autonomous() -> Program:
    r = Recorder("autonomous", "no inputs, no parameters, no outputs")
    x = r.state(Variable("x", "1", "state", start=1.0))
    r.rate("x", -x)
    return r.program()


NATIVE_PROGRAMS: dict[str, Callable[[], Program]] = {
    make.__name__: make for make in (driven, fragile, pendulum, algebraic, autonomous)
}
NATIVE_PROGRAMS_3: dict[str, Callable[[], Program]] = {
    make.__name__: make for make in (driven, fragile, plane, pendulum, buoy, algebraic)
}
