"""The kind `hydraulic_pto`: the circuit as a Program."""

from m4e_fmi.fmu import FmuKind
from m4e_fmi.program import Program, Recorder, Variable

from .circuit import Circuit
from .config import FORCE, OUTPUTS, PARAMETERS, SPEED, STATES, TUNABLE, Config


def build(config: Config, *, name: str, **_: object) -> Program:
    """The program of the component `name`."""
    r = Recorder(name, f"hydraulic power take-off at {config.rod}")
    circuit = Circuit(
        **{
            key: r.parameter(
                Variable(key, *said, getattr(config, key), tunable=key == TUNABLE, minimum=0)
            )
            for key, said in PARAMETERS.items()
        }
    )
    oil = r.state(Variable("oil", *STATES["oil"]))
    r.state(Variable("energy", *STATES["energy"]))
    member, unit, text = SPEED
    speed = r.input(Variable(f"{config.rod}.{member}", unit, text))
    r.rate("oil", circuit.oil_rate(oil, speed))
    r.rate("energy", circuit.delivered(oil))
    member, unit, text = FORCE
    r.output(Variable(f"{config.rod}.{member}", unit, text), circuit.force(oil, speed))
    r.output(Variable("pressure", *OUTPUTS["pressure"]), circuit.pressure(oil))
    r.output(Variable("power", *OUTPUTS["power"]), circuit.delivered(oil))
    return r.program()


KIND = FmuKind(Config, build)
