"""The plain-Python form of a program: a module of straight-line functions, standard library only.

The text defines four functions over sequences of floats (t is a float):

- ``constants(p)``: what depends on parameters only, computed once per change of a parameter;
- ``rates(t, x, u, p, c)``: the time derivatives of the states;
- ``outputs(t, x, u, p, c)``: the outputs;
- ``calculated(p, c)``: the calculated parameters.

Each returns a list. Every operation is done in the order of the tape, so the same program gives the
same bits wherever this text runs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from m4e_fmi.program.program import TIME, Program
from m4e_fmi.program.tape import needed

Function = Callable[..., list[float]]

_BINARY = {"add": "+", "sub": "-", "mul": "*", "div": "/"}
_CALLS = {"abs": "abs", "min": "min", "max": "max", "sign": "sign", "pow": "pow"}
_DEEPEST_NESTING = 12

_HEADER = """# program {name!r}

from math import acos, asin, atan, atan2, cos, exp, log, pow, sin, sqrt, tan, tanh


def sign(a):
    return float((a > 0) - (a < 0))

"""


def python_source(program: Program) -> str:
    """Text of a Python module that computes `program` (see the module's docstring)."""
    writer = _Writer(program)
    return _HEADER.format(name=program.name) + "\n\n".join(
        (
            writer.function("constants", "p", writer.hoisted),
            writer.function("rates", "t, x, u, p, c", list(program.rates)),
            writer.function("outputs", "t, x, u, p, c", list(program.results)),
            writer.function("calculated", "p, c", list(program.constants)),
        )
    )


@dataclass(frozen=True)
class PythonForm:
    """The four functions of a program, loaded in this process."""

    constants: Function
    rates: Function
    outputs: Function
    calculated: Function


def load_python(program: Program) -> PythonForm:
    """The program's functions, ready to call (see the module's docstring)."""
    namespace: dict[str, Function] = {}
    code = compile(python_source(program), f"<program {program.name}>", "exec")
    exec(code, namespace)  # our own generated text: names in it are indices, never user strings
    return PythonForm(**{k: namespace[k] for k in PythonForm.__dataclass_fields__})


class _Writer:
    """Writes functions of one program; nodes that need only parameters are hoisted into c."""

    def __init__(self, program: Program) -> None:
        self.tape = program.tape
        self.where = {TIME: "t"}
        for letter, group in (
            ("p", program.parameters),
            ("x", program.states),
            ("u", program.inputs),
        ):
            self.where |= {v.name: f"{letter}[{k}]" for k, v in enumerate(group)}
        roots = [*program.rates, *program.results, *program.constants]
        varying = set(program.operations(roots))
        read = {*roots, *(a for k in varying for a in self.tape.arguments(k))}
        self.hoisted = [
            k
            for k in self.tape.reachable(roots)
            if k in read and k not in varying and self.tape.arguments(k)
        ]
        self._slot = {index: f"c[{k}]" for k, index in enumerate(self.hoisted)}

    def function(self, name: str, arguments: str, roots: list[int]) -> str:
        available = {} if name == "constants" else self._slot
        nodes = needed(self.tape, roots, known=available)
        uses = Counter([*roots, *(a for k in nodes for a in self.tape.arguments(k))])
        text: dict[int, str] = dict(available)
        depth: dict[int, int] = {}
        lines = [f"def {name}({arguments}):"]
        for k in nodes:
            text[k] = self._expression(k, text)
            below = self.tape.arguments(k)
            depth[k] = 1 + max((depth.get(a, 0) for a in below), default=0)
            if below and (uses[k] > 1 or depth[k] > _DEEPEST_NESTING):
                lines.append(f"    v{k} = {text[k]}")
                text[k] = f"v{k}"
                depth[k] = 0
        lines.append(f"    return [{', '.join(text[k] for k in roots)}]\n")
        return "\n".join(lines)

    def _expression(self, k: int, text: dict[int, str]) -> str:
        kind, *arguments = self.tape.operations[k]
        if kind == "constant":
            return repr(arguments[0]) if arguments[0] >= 0 else f"({arguments[0]!r})"
        if kind == "symbol":
            return self.where[arguments[0]]
        if kind == "neg":
            return f"(-{text[arguments[0]]})"
        if kind in _BINARY:
            return f"({text[arguments[0]]} {_BINARY[kind]} {text[arguments[1]]})"
        return f"{_CALLS.get(kind, kind)}({', '.join(text[a] for a in arguments)})"
