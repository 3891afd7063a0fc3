"""Recording a sum as a program."""

from __future__ import annotations

from m4e_fmi.program import Program, Recorder, Scalar, Variable
from m4e_fmus.sum.config import FACTOR, TOTAL, Config


def sum_program(config: Config, *, name: str) -> Program:
    """The program of the sum called `name`: one output for each signal, without states.

    Of parameters only the sums are calculated parameters.
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
