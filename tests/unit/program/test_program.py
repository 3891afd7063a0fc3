"""Programs: recording, and the Python and SymPy forms against direct evaluation of the tape."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.programs import Evaluated

from m4e_fmi import program as functions
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.program.python_form import load_python, python_source
from m4e_fmi.program.tape import BINARY, UNARY


def variable(name: str, unit: str = "1", **fields: Any) -> Variable:
    return Variable(name, unit, f"what {name} is", **fields)


def oscillator() -> Program:
    """ẍ = −(k/m) x + u sin t, with an energy and a calculated natural frequency."""
    r = Recorder("oscillator", "mass on a spring")
    k = r.parameter(variable("k", "N/m", start=50.0))
    m = r.parameter(variable("m", "kg", start=2.0))
    u = r.input(variable("u", "m/s2", start=0.5))
    x = r.state(variable("x", "m", start=0.25))
    v = r.state(variable("v", "m/s", start=-1.0, derivative_of="x"))
    r.rate("x", v)
    r.rate("v", -(k / m) * x + u * functions.sin(r.time))
    r.output(variable("energy", "J"), (m * v**2 + k * x**2) / 2)
    r.calculate(variable("omega", "rad/s"), functions.sqrt(k / m))
    return r.program()


def twice(r: Recorder, declare: str) -> None:
    r.input(variable("x"))
    given = (variable("x"), 1.0) if declare in ("output", "calculate") else (variable("x"),)
    getattr(r, declare)(*given)


def rate(r: Recorder, name: str) -> None:
    r.input(variable("u"))
    r.state(variable("x"))
    r.rate("x", 1.0)
    r.rate(name, 0.0)


def calculated(r: Recorder, what: str) -> None:
    scalars = {"u": r.input(variable("u")), "x": r.state(variable("x")), "time": r.time}
    r.calculate(variable("c"), 2 * scalars[what])


MISUSE: list[tuple[Callable[[Recorder], Any], str]] = [
    *((partial(twice, declare=kind), "thing: variable 'x' is declared twice")
      for kind in ("parameter", "input", "state", "output", "calculate")),
    (lambda r: r.parameter(variable("time")), "'time' is the name of the independent variable"),
    *((partial(rate, name=name), f"thing: '{name}' is not a state, or already has its rate")
      for name in ("u", "nothing", "x")),
    (lambda r: (r.state(variable("x")), r.state(variable("v"))), "thing: no rate for state v, x"),
    (lambda r: r.output(variable("y"), r.tape.symbol("stranger") + 1),
     "'stranger' is used but not declared"),
    (lambda r: (r.output(variable("y"), 1.0), r.output(variable("z"), r.tape.symbol("y"))),
     "'y' is used but not declared"),
    *((partial(calculated, what=what), rf"'c' depends on \['{what}'\]")
      for what in ("u", "x", "time")),
    (lambda r: r.output(variable("v", derivative_of="x"), 1.0),
     "'v' cannot be the derivative of 'x'"),
    (lambda r: r.output(variable("y"), Recorder("other", "").input(variable("u")) + r.time),
     "two tapes"),
]  # fmt: skip


@pytest.mark.parametrize(("use", "message"), MISUSE)
def test_misuse_of_a_recorder(use: Callable[[Recorder], Any], message: str) -> None:
    r = Recorder("thing", "")

    def recorded() -> Program:
        use(r)
        return r.program()

    with pytest.raises(ValueError, match=message):
        recorded()


def test_other_start_values() -> None:
    p = oscillator().with_start({"k": 7, "u": -1.0, "x": 0.5})
    assert (p.parameters[0].start, p.inputs[0].start, p.states[0].start) == (7.0, -1.0, 0.5)
    assert p.states[1].start == -1.0
    assert oscillator().parameters[0].start == 50.0
    with pytest.raises(KeyError, match="oscillator has no parameter, input or state a, energy"):
        oscillator().with_start({"k": 1.0, "energy": 2.0, "a": 3.0})


class TestPythonForm:
    def test_undefined_constants_are_met_at_run_time(self) -> None:
        r = Recorder("undefined", "")
        x = r.state(variable("x"))
        r.rate("x", x / r.tape.constant(0.0))
        r.output(variable("huge"), x * (r.tape.constant(1e308) * 10))
        p = Evaluated(r.program())
        with pytest.raises(ZeroDivisionError):
            p.rates({"x": 1.0})
        assert p.outputs({"x": 1.0}) == {"huge": math.inf}

    @pytest.mark.parametrize("text", [
        "it's", 'say "hi"', '"""\nraise SystemExit\n"""', "'''\nraise SystemExit\n'''",
        "# x\nraise SystemExit\n", "back\\slash\\", "{name} {0}", "%s %n", "é ü 水",
        "line\u2028separator\u2029raise SystemExit\x85raise SystemExit\x0craise SystemExit",
    ])  # fmt: skip
    def test_no_text_of_the_user_becomes_code(self, text: str) -> None:
        r = Recorder(text, text)
        p = r.parameter(Variable(text + "p", "1", text))
        x = r.state(Variable(text, "1", text, start=1.0))
        r.rate(text, x * p)
        r.output(Variable(text + "y", "1", text), x + p)
        program = r.program()
        tree = ast.parse(python_source(program).encode())
        kinds = {type(node) for node in tree.body}
        assert kinds == {ast.ImportFrom, ast.FunctionDef}
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        assert names <= {"a", "c", "p", "t", "u", "x", "float"}
        assert not any(isinstance(n, ast.Constant) and n.value == text for n in ast.walk(tree))
        assert load_python(program).outputs(0.0, [2.0], [], [3.0], []) == [5.0]


class TestFunctions:
    """One source for floats, tapes and SymPy."""

    @pytest.mark.parametrize(
        "algorithm",
        [
            lambda x, y: functions.minimum(functions.sin(x), functions.cos(y)) ** 3,
            lambda x, y: functions.atan2(x, y) - functions.atan2(1, y),
            lambda x, y: functions.sign(x - y) * functions.tanh(x) + functions.sign(2),
            lambda x, y: functions.log(functions.exp(x) + functions.maximum(y, 2)),
            lambda x, y: functions.sqrt(abs(x)) / (2 - functions.tan(y)) + 2**x - y**-2,
            lambda x, y: functions.asin(x / 3) + functions.acos(y / 3) * functions.atan(3.0 * x),
        ],
    )
    def test_three_scalars_agree(self, algorithm: Callable[[Any, Any], Any]) -> None:
        import sympy

        r = Recorder("three", "")
        r.output(variable("z"), algorithm(r.input(variable("x")), r.input(variable("y"))))
        direct = algorithm(0.8, -0.4)
        recorded = Evaluated(r.program()).outputs({"x": 0.8, "y": -0.4})["z"]
        x, y = sympy.symbols("x y", real=True)
        symbolic = float(algorithm(x, y).subs({x: 0.8, y: -0.4}))
        # a dozen operations; powers may be products on the tape
        assert recorded == pytest.approx(direct, rel=1e-14)
        assert symbolic == pytest.approx(direct, rel=1e-14)


Node = tuple[str, int, int]
ROUNDED = sorted({*UNARY, *BINARY} - {"atan2", "sign"})
"""Operations that do not tell 0 from −0."""


def _steps(names: list[str]) -> st.SearchStrategy[list[Node]]:
    """Operations on what was computed before, by its position."""
    step = st.tuples(st.sampled_from(names), st.integers(0), st.integers(0))
    return st.lists(step, min_size=5, max_size=60)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(_steps([*ROUNDED, *(["add", "sub", "neg"] * 8)]), st.floats(-3, 3), st.floats(-3, 3))
def test_folding_changes_no_bit(steps: list[Node], a: float, b: float) -> None:
    """Constants, neutral elements and signs that are moved: against floats, step by step."""
    r = Recorder("folded", "")
    recorded = [r.input(variable("a")), r.input(variable("b"))]
    direct = [a, b]
    for number in (0.0, 1.0, -1.0, 2.5):
        recorded.append(r.tape.constant(number))
        direct.append(number)
    for name, first, second in steps:
        i, j = first % len(direct), second % len(direct)
        others = (j,) if name in BINARY else ()
        try:
            value = {**UNARY, **BINARY}[name](direct[i], *(direct[k] for k in others))
        except (ArithmeticError, ValueError):
            continue
        if math.isfinite(value):  # 0 · x is folded to 0, whatever x
            direct.append(value)
            recorded.append(recorded[i].record(name, *(recorded[k] for k in others)))
    for k, scalar in enumerate(recorded):
        r.output(variable(f"y{k}"), scalar)
    found = Evaluated(r.program()).outputs({"a": a, "b": b})
    assert list(found.values()) == direct


@settings(max_examples=150, deadline=None, derandomize=True)
@given(
    _steps(sorted({*UNARY, *BINARY})),
    st.lists(st.floats(-3, 3), min_size=4, max_size=4),
)
def test_the_python_form_gives_the_bits_of_the_tape(
    steps: list[Node], numbers: list[float]
) -> None:
    r = Recorder("random", "")
    names = ("p", "u", "x", "time")
    scalars = [r.parameter(variable("p")), r.input(variable("u")), r.state(variable("x")), r.time]
    scalars += [r.tape.constant(c) for c in (2.0, 0.5)]
    for name, first, second in steps:
        a, b = scalars[first % len(scalars)], scalars[second % len(scalars)]
        scalars.append(a.record(name, b) if name in BINARY else a.record(name))
    r.rate("x", scalars[-1])
    outputs = scalars[-1:3:-3]
    for k, scalar in enumerate(outputs):
        r.output(variable(f"y{k}"), scalar)
    program = r.program()
    p, u, x, t = numbers
    expected = _interpreted(program, dict(zip(names, numbers, strict=True)), program.results)
    form = load_python(program)
    if expected is None:
        with pytest.raises((ArithmeticError, ValueError)):
            form.outputs(t, [x], [u], [p], form.constants([p]))
        return
    constants = form.constants([p])
    assert _same(form.outputs(t, [x], [u], [p], constants), expected)
    assert _same(form.rates(t, [x], [u], [p], constants), expected[:1])


def _interpreted(
    program: Program, values: dict[str, float], roots: Sequence[int]
) -> list[float] | None:
    """Values of `roots` by executing the tape; None if an operation is undefined."""
    results: dict[int, float] = {}
    for k in program.tape.reachable(list(roots)):
        kind, *arguments = program.tape.operations[k]
        try:
            if kind == "constant":
                results[k] = arguments[0]
            elif kind == "symbol":
                results[k] = values[arguments[0]]
            else:
                results[k] = {**UNARY, **BINARY}[kind](*(results[a] for a in arguments))
        except (ArithmeticError, ValueError):
            return None
    return [results[k] for k in roots]


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    return [x.hex() for x in map(float, one)] == [x.hex() for x in map(float, other)]
