"""The kind `hydraulic_pto_scipy`: the circuit as Python code that travels inside the FMU."""

from collections.abc import Iterator
from pathlib import Path

from m4e_fmi.fmu import FmuKind, FmuVariable, ModelDescription, PythonSource

from .config import FORCE, OUTPUTS, PARAMETERS, SPEED, STATES, TUNABLE, Config

HERE = Path(__file__).parent


def build(config: Config, *, name: str, **_: object) -> PythonSource:
    """The source of the component `name`."""
    text = f"hydraulic power take-off at {config.rod}, by SciPy"
    travels = ("slave.py", "accumulator.py", "circuit.py")
    return PythonSource(
        description=ModelDescription(name, text, tuple(variables(config))),
        slave="slave:HydraulicSlave",
        modules={file: HERE / file for file in travels},
        data={"rod.txt": config.rod.encode()},
    )


def variables(config: Config) -> Iterator[FmuVariable]:
    """The variables of the FMU, in the order of their value references."""
    for key, said in PARAMETERS.items():
        variability = "tunable" if key == TUNABLE else "fixed"
        yield FmuVariable(
            key,
            *said,
            causality="parameter",
            variability=variability,
            initial="exact",
            start=getattr(config, key),
            minimum=0,
        )
    member, unit, text = SPEED
    speed = f"{config.rod}.{member}"
    yield FmuVariable(speed, unit, text, causality="input", start=0.0)
    for key, said in STATES.items():
        yield FmuVariable(key, *said, causality="output", initial="exact", start=0.0)
    member, unit, text = FORCE
    yield FmuVariable(
        f"{config.rod}.{member}",
        unit,
        text,
        causality="output",
        initial="calculated",
        dependencies=(speed,),
        initial_dependencies=(speed, "oil", *PARAMETERS),
    )
    for key, said in OUTPUTS.items():
        yield FmuVariable(
            key,
            *said,
            causality="output",
            initial="calculated",
            initial_dependencies=("oil", *PARAMETERS),
        )


KIND = FmuKind(Config, build)
