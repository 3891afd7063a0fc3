"""The sum FMU: signals of several components into one input; README.md says what it computes.

Imports m4e_fmi's document, program and units.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field, StringConstraints, model_validator

from m4e_fmi.files.document import Section, rejected
from m4e_fmi.fmu import FmuKind
from m4e_fmi.program import Program, Recorder, Scalar, Variable
from m4e_fmus.units import KnownUnit

TOTAL = "sum"
FACTOR = "factor"
TIME = "time"

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
Signal = Annotated[
    str, StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\[[0-9]+(,[0-9]+)*\])?$")
]
Factor = Annotated[float, Field(allow_inf_nan=False)]


def _factors(written: object) -> object:
    """A list of names as factors of 1."""
    if not isinstance(written, (list, tuple)):
        return written
    twice = [str(name) for name in written if written.count(name) > 1]
    if twice:
        raise rejected(f"{twice[0]!r} is named twice", "give it a factor: {a: 2, b: 1}")
    return dict.fromkeys(map(str, written), 1.0)


class Config(Section):
    """The keys of a component of `kind: sum`, without `kind` and `start`.

    inputs: the summands, a list of names, or factors by name. unit: that of all inputs and of
    the output; or signals, which makes each input and the sum a connector: units by signal name.
    parameters: inputs that are parameters, for calculated parameters of other components.
    """

    inputs: Annotated[dict[Name, Factor], BeforeValidator(_factors)] = Field(min_length=1)
    unit: KnownUnit | None = None
    signals: dict[Signal, KnownUnit] | None = Field(default=None, min_length=1)
    parameters: tuple[Name, ...] = ()

    @model_validator(mode="after")
    def _clear(self) -> Config:
        if (self.unit is None) == (self.signals is None):
            remedy = "add 'unit: N', or 'signals: {force_x: N, force_z: N}' to add up connectors"
            raise rejected("the summands must be given in one way", remedy)
        taken = [name for name in (TOTAL, FACTOR, TIME) if name in self.inputs]
        if taken:
            message = f"an input cannot be called {' or '.join(taken)}"
            raise rejected(message, "rename it: a variable of the sum has that name")
        unknown = [name for name in self.parameters if name not in self.inputs]
        if unknown:
            remedy = f"name some of: {', '.join(self.inputs)}"
            raise rejected(f"'parameters': there is no input {unknown[0]!r}", remedy)
        return self


def _build(config: Config, *, name: str, **_: object) -> Program:
    """The program of the sum called `name`: one output for each signal, without states.

    Of parameters only the sums are calculated parameters. It reads no files and takes no time.
    """
    r = Recorder(name, f"sum of {', '.join(config.inputs)}")
    once = set(config.parameters)
    is_constant = once == set(config.inputs)
    factors = {
        given: r.parameter(
            Variable(
                f"{FACTOR}.{given}",
                "1",
                f"factor of {given}",
                start=factor,
                tunable=not is_constant,
            )
        )
        for given, factor in config.inputs.items()
    }
    signals = {"": config.unit or "1"} if config.signals is None else config.signals
    for signal, unit in signals.items():
        total: Scalar | float = 0.0
        for given, factor in factors.items():
            text = f"{signal or 'value'} of {given}"
            declare = r.parameter if given in once else r.input
            total = total + factor * declare(Variable(_member(given, signal), unit, text))
        give = r.calculate if is_constant else r.output
        give(Variable(_member(TOTAL, signal), unit, f"sum of all {signal}".rstrip()), total)
    return r.program()


def _member(group: str, signal: str) -> str:
    """Name of a signal's variable in a connector; the group itself where there is but one."""
    return f"{group}.{signal}" if signal else group


KIND = FmuKind(Config, build=_build)
