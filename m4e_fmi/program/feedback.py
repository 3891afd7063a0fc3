"""A program whose inputs follow a law: feedback, prescribed forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from m4e_fmi.errors import Named, UnknownNameError
from m4e_fmi.program.copying import TapeCopy
from m4e_fmi.program.program import TIME, Program, Recorder
from m4e_fmi.program.tape import Scalar

Law = Callable[[Mapping[str, Scalar]], Scalar | float]
"""The value of an input as a function of states, parameters, other inputs and `time` by name."""


def with_feedback(program: Program, laws: Mapping[str, Law]) -> Program:
    """`program` with the inputs named by `laws` replaced by what these record.

    Such an input becomes an output of the same name. UnknownNameError for an input that is not
    there, or if a law asks for a name that is not.

    >>> brake = with_feedback(program, {"joint.wheel.effort": lambda x: -2.0 * x["joint.wheel.u"]})
    """
    known = {v.name for v in program.inputs}
    unknown = sorted(set(laws) - known)
    if unknown:
        raise UnknownNameError.of(f"{program.name} has no input", unknown, known)
    recorder = Recorder(program.name, program.description)
    scalars = {TIME: recorder.time}
    scalars |= {v.name: recorder.parameter(v) for v in program.parameters}
    scalars |= {v.name: recorder.input(v) for v in program.inputs if v.name not in laws}
    scalars |= {v.name: recorder.state(v) for v in program.states}
    readable = Named("no law can depend on", scalars)
    given = {name: _scalar(recorder, law(readable)) for name, law in laws.items()}
    copy = TapeCopy(program.tape, recorder.tape, {**scalars, **given})
    for v, rate in zip(program.states, program.rates, strict=True):
        recorder.rate(v.name, copy(rate))
    for v, result in zip(program.outputs, program.results, strict=True):
        recorder.output(v, copy(result))
    for v, constant in zip(program.calculated, program.constants, strict=True):
        recorder.calculate(v, copy(constant))
    for v in program.inputs:
        if v.name in laws:
            recorder.output(v, given[v.name])
    return recorder.program()


def _scalar(recorder: Recorder, value: Scalar | float) -> Scalar:
    return value if isinstance(value, Scalar) else recorder.tape.constant(value)
