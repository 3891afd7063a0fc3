"""Exact derivatives of programs: tangents and sparse Jacobians, recorded like everything else.

Forward mode on the tape, operation by operation. Where a program knows how its rates were solved
for (`Solution`), derivatives go around the solution instead of through it; around several, each
after those that its balance depends on.

Functions with corners have the derivative that their operations say: abs' = sign, which is 0 at 0;
sign' = 0; of minimum and maximum that of the argument taken, and the mean of both where they are
equal. sqrt and the powers have none at 0 where it is infinite: a division by zero at run time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Literal

from m4e_fmi.errors import UnknownNameError
from m4e_fmi.program.functions import cos, log, sign, sin, sqrt
from m4e_fmi.program.program import TIME, Program, Recorder, Solution, Variable
from m4e_fmi.program.tape import Scalar, Tape
from m4e_fmi.shown import short

FEW = 4
"""Symbols whose partial derivatives are multiplied by a direction one by one, at most."""

Slopes = dict[int, Scalar]
"""Derivatives of one node by direction (any numbers); an absent one is zero."""


def tangent(program: Program, along: Iterable[str] | None = None) -> Program:
    """The directional derivative of rates and outputs of `program`, as a program.

    It has the variables of `program` and one more input for each variable of `along` (states,
    inputs, parameters, `time`; states and inputs if None), ``d(name)``: the direction. Its states
    have the same rates; its outputs are ``d(der(x))`` for every state x, then ``d(y)`` for every
    output y. UnknownNameError if `along` names something else.
    """
    names = _readable(program, along)
    recorder = _like(program, f"{program.name}: directional derivative")
    known = (*program.states, *program.inputs, *program.parameters)
    units = {TIME: "s", **{v.name: v.unit for v in known}}
    given: dict[int, Slopes] = {}
    for name in names:
        text = f"Direction: change of {name}"
        direction = recorder.input(Variable(f"d({name})", units[name], text))
        given[program.tape.node(("symbol", name))] = {0: direction}
    rates = zip(program.states, program.rates, strict=True)
    outputs = zip(program.outputs, program.results, strict=True)
    rows = [(f"der({v.name})", f"({v.unit})/s", node) for v, node in rates]
    rows += [(v.name, v.unit, node) for v, node in outputs]
    slopes = _around(program, [node for _, _, node in rows], given)
    for (name, unit, _), slope in zip(rows, slopes, strict=True):
        variable = Variable(f"d({name})", unit, f"Change of {name} along the direction")
        recorder.output(variable, slope.get(0, 0.0))
    return recorder.program()


@short
@dataclass(frozen=True)
class Jacobian:
    """A sparse matrix of derivatives: ∂rows[i]/∂columns[j].

    The outputs of `program` are the entries that are not structurally zero, in the order of their
    rows; entry k is in row `row_indices[k]`, column `column_indices[k]`.
    """

    program: Program
    rows: tuple[str, ...]
    columns: tuple[str, ...]
    row_indices: tuple[int, ...]
    column_indices: tuple[int, ...]


def jacobian(
    program: Program,
    of: Literal["rates", "outputs"] = "rates",
    by: Iterable[str] | None = None,
) -> Jacobian:
    """∂rates/∂… or ∂outputs/∂… of `program` by states, inputs, parameters and `time`.

    `by` names the columns; None: states and inputs. Rows are in the order of the states, or of the
    outputs. UnknownNameError if `by` names something else.
    """
    columns = _readable(program, by)
    tape = program.tape
    one = tape.constant(1.0)
    given = {tape.node(("symbol", name)): {j: one} for j, name in enumerate(columns)}
    if of == "rates":
        rows = [f"der({v.name})" for v in program.states]
        nodes = program.rates
    else:
        rows, nodes = [v.name for v in program.outputs], program.results
    recorder = _like(program, f"{program.name}: derivatives of {of}")
    places: list[tuple[int, int]] = []
    for i, slopes in enumerate(_around(program, nodes, given)):
        for j in sorted(slopes):
            places.append((i, j))
            text = f"Derivative of {rows[i]} by {columns[j]}"
            recorder.output(Variable(f"d({rows[i]})/d({columns[j]})", "1", text), slopes[j])
    row_indices, column_indices = (tuple(place[k] for place in places) for k in (0, 1))
    program = recorder.program()
    return Jacobian(program, tuple(rows), tuple(columns), row_indices, column_indices)


def rate_entries(program: Program) -> list[tuple[int, int, int]]:
    """∂rates/∂(states, time) as `binary_form.encode` takes it: row, column, node of the tape."""
    matrix = jacobian(program, by=[*(v.name for v in program.states), TIME])
    entries = zip(matrix.row_indices, matrix.column_indices, matrix.program.results, strict=True)
    return list(entries)


def _readable(program: Program, names: Iterable[str] | None) -> list[str]:
    groups = (program.states, program.inputs)
    if names is None:
        return [v.name for group in groups for v in group]
    names = list(names)
    known = {v.name for group in (*groups, program.parameters) for v in group} | {TIME}
    unknown = sorted(set(names) - known)
    if unknown:
        complaint = f"{program.name} has no parameter, input or state"
        raise UnknownNameError.of(complaint, unknown, known)
    return names


def _like(program: Program, description: str) -> Recorder:
    """A recorder on the tape of `program`, with its variables but for the outputs."""
    recorder = Recorder(program.name, description, tape=program.tape)
    for v in program.parameters:
        recorder.parameter(v)
    for v in program.inputs:
        recorder.input(v)
    for v, rate in zip(program.states, program.rates, strict=True):
        recorder.state(v)
        recorder.rate(v.name, program.tape.scalar(rate))
    return recorder


def _around(program: Program, roots: Sequence[int], given: Mapping[int, Slopes]) -> list[Slopes]:
    """Slopes of `roots`, those of solutions by solves of their own."""
    known = dict(given)
    for solution in _ordered(program):
        for direction, drive in _drives(program.tape, solution, given, known).items():
            for unknown, slope in zip(solution.unknowns, solution.response(drive), strict=True):
                if isinstance(slope, Scalar) and program.tape.value(slope.index) != 0.0:
                    known.setdefault(unknown.index, {})[direction] = slope
        for unknown in solution.unknowns:
            known.setdefault(unknown.index, {})
    return slopes(program.tape, roots, {**known, **given})


def _ordered(program: Program) -> list[Solution]:
    """The solutions of a program, each after those whose unknowns its balance needs.

    Those that need one another are left out: derivatives then go through them.
    """
    waiting = list(program.solutions)
    if len(waiting) < 2:
        return waiting
    tape, order = program.tape, list[Solution]()
    balances = [{s.index for s in solution.balance()} for solution in waiting]
    own = [{s.index for s in solution.unknowns} for solution in waiting]
    reached = [set(tape.reachable(balance)) for balance in balances]
    left = set(range(len(waiting)))
    while True:
        free = [
            k for k in sorted(left) if all(reached[k].isdisjoint(own[j]) for j in left if j != k)
        ]
        if not free:
            return order
        order += [waiting[k] for k in free]
        left.difference_update(free)


def _drives(
    tape: Tape, solution: Solution, given: Mapping[int, Slopes], known: Mapping[int, Slopes]
) -> dict[int, dict[int, Scalar]]:
    """Right-hand side of the solved equations for each direction.

    `known` has slopes of symbols, as `given`, and of other solutions' unknowns. Nodes that depend
    on few symbols, and on no such unknown, are derived by partial derivatives: turning a vector
    gives its neighbour, so most of them are on the tape already.
    """
    balance = [s.index for s in solution.balance()]
    symbols = {tape.operations[k][1]: k for k in given}
    readers = {k: names & symbols.keys() for k, names in tape.symbols_of_each(balance).items()}
    mixed = _depending(tape, balance, known.keys() - given.keys())
    partials: dict[int, dict[int, Scalar]] = defaultdict(dict)
    changes: dict[int, dict[int, Scalar]] = defaultdict(dict)
    one = tape.constant(1.0)
    units: dict[int, Slopes] = {k: {k: one} for k in given}
    few = [k for k in readers if len(readers[k]) <= FEW and k not in mixed]
    many = [k for k in readers if len(readers[k]) > FEW or k in mixed]
    for found, nodes, seeds in ((partials, few, units), (changes, many, known)):
        by_node = dict(zip(nodes, slopes(tape, nodes, seeds), strict=True))
        for place, k in enumerate(balance):
            for key, slope in by_node.get(k, {}).items():
                found[key][place] = slope
    drives = {direction: dict(solution.drive(change)) for direction, change in changes.items()}
    for symbol, partial in partials.items():
        drive = solution.drive(partial)
        for direction, slope in given[symbol].items():
            total = drives.setdefault(direction, {})
            for place, value in drive.items():
                more = value * slope
                total[place] = total[place] + more if place in total else more
    return drives


def _depending(tape: Tape, roots: Sequence[int], on: Set[int]) -> set[int]:
    """Those nodes below `roots` that are computed from one of the nodes `on`."""
    found = set(on)
    if on:
        for k in tape.reachable(roots):
            if not found.isdisjoint(tape.arguments(k)):
                found.add(k)
    return found


def slopes(tape: Tape, roots: Sequence[int], given: Mapping[int, Slopes]) -> list[Slopes]:
    """Derivatives of the nodes `roots` in every direction in which some node of `given` has one."""
    found: dict[int, Slopes] = {}
    for k in tape.reachable(roots):
        if k in given:
            found[k] = given[k]
            continue
        arguments = tape.arguments(k)
        directions = dict.fromkeys(d for a in arguments for d in found[a])
        if not directions:
            found[k] = {}
            continue
        kind, result = tape.operations[k][0], tape.scalar(k)
        operands = [tape.scalar(a) for a in arguments]
        change = _unary_change if len(arguments) == 1 else _binary_change
        found[k] = {}
        for d in directions:
            value = change(kind, result, *operands, *(found[a].get(d) for a in arguments))
            if value is not None and tape.value(value.index) != 0.0:
                found[k][d] = value
    return [found[k] for k in roots]


Change = Scalar | None
"""Of a node in one direction; None for zero."""


def _unary_change(kind: str, c: Scalar, a: Scalar, da: Scalar) -> Change:
    match kind:
        case "neg":
            return -da
        case "abs":
            return sign(a) * da
        case "sqrt":
            return da / (2.0 * c)
        case "exp":
            return c * da
        case "log":
            return da / a
        case "sin":
            return cos(a) * da
        case "cos":
            return -(sin(a) * da)
        case "tan":
            return (1.0 + c * c) * da
        case "asin":
            return da / sqrt(1.0 - a * a)
        case "acos":
            return -(da / sqrt(1.0 - a * a))
        case "atan":
            return da / (1.0 + a * a)
        case "tanh":
            return (1.0 - c * c) * da
        case _:  # sign
            return None


def _binary_change(kind: str, c: Scalar, a: Scalar, b: Scalar, da: Change, db: Change) -> Change:
    match kind:
        case "add":
            return _sum(da, db)
        case "sub":
            return _difference(da, db)
        case "mul":
            return _sum(_times(b, da), _times(a, db))
        case "div":
            above = _difference(da, _times(c, db))
            return None if above is None else above / b
        case "pow":
            by_base = None if da is None else b * a ** (b - 1.0) * da
            return _sum(by_base, None if db is None else c * log(a) * db)
        case "atan2":
            across = _difference(_times(b, da), _times(a, db))
            return None if across is None else across / (b * b + a * a)
        case "min":
            return _chosen(b - a, da, db)
        case _:  # max
            return _chosen(a - b, da, db)


def _sum(a: Change, b: Change) -> Change:
    return b if a is None else a if b is None else a + b


def _difference(a: Change, b: Change) -> Change:
    return a if b is None else -b if a is None else a - b


def _times(factor: Scalar, change: Change) -> Change:
    return None if change is None else factor * change


def _chosen(lead: Scalar, da: Change, db: Change) -> Change:
    """da where `lead` is positive, db where it is negative, the mean of both where it is zero."""
    first = (sign(lead) + 1.0) / 2.0
    return _sum(_times(first, da), _times(1.0 - first, db))
