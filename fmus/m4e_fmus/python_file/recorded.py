"""The user's class as a Program: its methods recorded on scalars, and compared with themselves."""

from __future__ import annotations

import math
import random
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from m4e_fmi.program import Program, Recorder, Scalar, Variable
from m4e_fmi.program.tape import evaluated
from m4e_fmus.python_file.declarations import Lines, Variables
from m4e_fmus.python_file.recording_file import (
    CannotBeRecordedError,
    check,
    nothing_is_equal,
    prepare,
)
from m4e_fmus.python_file.user_class import (
    Declared,
    UserClass,
    UserCodeError,
    Value,
    Values,
    loaded,
)

SAMPLES = 48  # of inputs, states and time at which program and code are compared
CLOSE = 1e-9


def recorded(path: Path, shown: str, *, name: str, variables: Variables, lines: Lines) -> Program:
    """The program of the class in the file; CannotBeRecordedError if it has none.

    The file is recorded without those beside it, whose changes would go unnoticed.
    """
    check(lines.source)
    with TemporaryDirectory() as folder:
        alone = Path(shutil.copy(path, folder))
        try:
            program, again = (
                _program(alone, shown, name=name, variables=variables, lines=lines)
                for _ in range(2)
            )
        except UserCodeError as error:
            raise CannotBeRecordedError(str(error)) from None
        if program != again:
            raise CannotBeRecordedError("it computes something else each time")
        _compare(program, alone, shown, variables)
    return program


def _program(path: Path, shown: str, *, name: str, variables: Variables, lines: Lines) -> Program:
    user = UserClass(loaded(path, shown, f"recorded_{path.stem}", prepare), path, shown)
    if user.has("step") or user.has("start"):
        raise CannotBeRecordedError("it has a method step or start")
    recorder = Recorder(name, user.kind.__doc__ or f"{user.kind.__name__} of {shown}")
    values = _declare(recorder, variables)
    seen = Values(
        {k: v for group in ("parameters", "inputs", "states") for k, v in variables[group].items()}
    )
    before = dict(vars(user.object))
    rates = {}
    with nothing_is_equal():
        if variables["states"]:
            rates = user.results("rates", variables["states"], recorder.time, seen.filled(values))
        results = user.results(
            "calculate", variables["outputs"], recorder.time, seen.filled(values)
        )
    if vars(user.object) != before:
        raise CannotBeRecordedError("its object changes while it computes")
    for element, rate in rates.items():
        recorder.rate(element, _scalar(rate, element))
    method = user.line("calculate")
    for variable in variables["outputs"].values():
        place = f"{shown}:{lines.of_result(variable.name, method)}"
        for element in variable.elements:
            value = _scalar(results[element], element)
            recorder.output(Variable(element, variable.unit, variable.made_at(place)), value)
    return recorder.program()


def _declare(recorder: Recorder, variables: Variables) -> dict[str, Scalar]:
    """All parameters, inputs and states, by element."""
    kinds: Mapping[str, Callable[[Variable], Scalar]] = {
        "parameters": recorder.parameter, "inputs": recorder.input, "states": recorder.state,
    }  # fmt: skip
    return {
        element: declare(
            Variable(element, v.unit, v.text, start=v.start, tunable=group == "parameters")
        )
        for group, declare in kinds.items()
        for v in variables[group].values()
        for element in v.elements
    }


def _scalar(value: Value, name: str) -> Scalar | float:
    if isinstance(value, Scalar):
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise CannotBeRecordedError(f"{name} is {value!r}")
    return number


def _compare(program: Program, path: Path, shown: str, variables: Variables) -> None:
    """CannotBeRecordedError unless the program gives what the code does, at sampled places.

    Where the code fails there is nothing to compare; it must not fail everywhere.
    """
    user = UserClass(loaded(path, shown, f"compared_{path.stem}"), path, shown)
    groups = {g: variables[g] for g in ("parameters", "inputs", "states")}
    seen = Values({k: v for group in groups.values() for k, v in group.items()})
    nodes = [*program.rates, *program.results]
    generator, compared = random.Random(1), 0
    for k in range(SAMPLES):
        values = _sample(groups, generator, k=k)
        time = 0.0 if k == 0 else generator.uniform(0.0, 100.0)
        given = evaluated(program.tape, nodes, {**values, "time": time})
        own = _own(user, variables, seen.filled(values), time)
        if own is None:
            continue
        compared += 1
        for node, value in zip(nodes, own, strict=True):
            if not abs(value - given[node]) <= CLOSE * (1.0 + abs(value)):  # also if it is nan
                raise CannotBeRecordedError("its results are not those of what it records")
    if not compared:
        raise CannotBeRecordedError("it fails at all values that were tried")


def _sample(
    groups: Mapping[str, Mapping[str, Declared]], generator: random.Random, *, k: int
) -> dict[str, float]:
    """Values by element of sample `k`: the start values, others around them, small whole numbers.

    Around means relative to the start value, or to 1 where that is 0.
    """
    found: dict[str, float] = {}
    spread = 10.0 ** -(k % 4) if k else 0.0
    for group, variables in groups.items():
        for v in variables.values():
            for element in v.elements:
                change = spread * generator.gauss(0.0, 1.0)
                if group == "parameters" and k % 3 != 1:
                    change = 0.0
                found[element] = v.start + change * (abs(v.start) or 1.0)
                if k % 3 == 2:
                    found[element] = generator.choice((v.start, 0.0, 1.0, 2.0, 3.0))
    return found


def _own(user: UserClass, variables: Variables, seen: Value, time: float) -> Sequence[float] | None:
    """Rates and results of the code itself; None where it has none."""
    try:
        found: list[float] = []
        if variables["states"]:
            found += user.results("rates", variables["states"], time, seen).values()
        found += user.results("calculate", variables["outputs"], time, seen).values()
        numbers = [float(value) for value in found]
    except (UserCodeError, TypeError, ValueError):
        return None
    return numbers if all(map(math.isfinite, numbers)) else None
