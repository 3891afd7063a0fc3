"""The binary form of a program: Program → bytes → Program. Standard library only.

The form is versioned, little-endian and checksummed; `src/program.c` documents it byte by byte. It
holds the tape as it is (nodes that results need, in order), so nothing is lost: reading gives the
same program, and writing that gives the same bytes. Hoisting and registers are the reader's work.
"""

from __future__ import annotations

import re
import struct
import sys
import zlib
from array import array
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from m4e_fmi.errors import InputError
from m4e_fmi.program.program import TIME, Program, Variable
from m4e_fmi.program.tape import Operation, Tape

MAGIC = b"\x89M4E\r\n\x1a\n"
VERSION = 2
# fmt: off
OPERATIONS = (
    "literal", "time", "state", "input", "parameter",
    "neg", "abs", "sign", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh",
    "add", "sub", "mul", "div", "pow", "atan2", "min", "max",
)
# fmt: on
LITERAL, TIME_NODE, STATE, INPUT, PARAMETER = range(5)
CODES = {name: code for code, name in enumerate(OPERATIONS)}
FIRST_UNARY, FIRST_BINARY = CODES["neg"], CODES["add"]
_HEADER = struct.Struct("<8sIIQ9II")
_CHECKED_FROM = 16
_GROUPS = ("parameters", "inputs", "states", "outputs", "calculated")
_TUNABLE, _LOCAL = 1, 2

Entry = tuple[int, int, int]


@dataclass
class Code:
    """The nodes that a program's results need, numbered from 0, in order of execution.

    `operation[k]` is a position in OPERATIONS; `a[k]`, `b[k]` are its arguments: earlier nodes, or
    for leaves the index of a literal, state, input or parameter in `a`. `jacobian` has
    (row, column, node): the derivative of rate `row` by state `column`, or by time where column is
    the number of states; what is not listed is 0.
    """

    operation: list[int] = field(default_factory=list)
    a: list[int] = field(default_factory=list)
    b: list[int] = field(default_factory=list)
    literals: list[float] = field(default_factory=list)
    rates: list[int] = field(default_factory=list)
    results: list[int] = field(default_factory=list)
    constants: list[int] = field(default_factory=list)
    jacobian: list[Entry] = field(default_factory=list)


def code_of(program: Program, jacobian: Iterable[Entry] = ()) -> Code:
    """The code of a program; `jacobian` entries name nodes of its tape (see `Code`)."""
    entries = sorted(jacobian)
    operations = program.tape.operations
    roots = [*program.rates, *program.results, *program.constants, *(e[2] for e in entries)]
    needed = _needed(operations, roots)
    leaves = {TIME: (TIME_NODE, 0)}
    for kind, group in (
        (STATE, program.states),
        (INPUT, program.inputs),
        (PARAMETER, program.parameters),
    ):
        leaves |= {v.name: (kind, index) for index, v in enumerate(group)}
    code = Code()
    number = [0] * len(operations)
    for k, operation in enumerate(operations):
        if not needed[k]:
            continue
        number[k] = len(code.operation)
        kind, first = operation[0], operation[1]
        second = 0
        if kind == "constant":
            kind_code, first = LITERAL, len(code.literals)
            code.literals.append(operation[1])
        elif kind == "symbol":
            kind_code, first = leaves[first]
        else:
            kind_code, first = CODES[kind], number[first]
            if len(operation) == 3:
                second = number[operation[2]]
        code.operation.append(kind_code)
        code.a.append(first)
        code.b.append(second)
    code.rates = [number[k] for k in program.rates]
    code.results = [number[k] for k in program.results]
    code.constants = [number[k] for k in program.constants]
    code.jacobian = [(row, column, number[k]) for row, column, k in entries]
    return code


def _needed(operations: list[Operation], roots: list[int]) -> bytearray:
    """For each operation 1 if `roots` need it, else 0."""
    needed = bytearray(len(operations))
    for k in roots:
        needed[k] = 1
    for k in range(max(roots, default=-1), -1, -1):
        if needed[k] and CODES.get(operations[k][0], 0) >= FIRST_UNARY:
            for argument in operations[k][1:]:
                needed[argument] = 1
    return needed


def _words(values: Iterable[int]) -> bytes:
    return _little(array("I", values))


def _doubles(values: Iterable[float]) -> bytes:
    return _little(array("d", values))


def _little(values: array[int] | array[float]) -> bytes:
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def _variables(program: Program) -> list[Variable]:
    return [v for group in _GROUPS for v in getattr(program, group)]


def encode(program: Program, jacobian: Iterable[Entry] = ()) -> bytes:
    """The binary form of `program`; `jacobian` as for `code_of`.

    Raises InputError if a name, unit or description contains a zero byte or half a character.
    """
    code = code_of(program, jacobian)
    variables = _variables(program)
    pieces = [program.name, program.description]
    for v in variables:
        pieces += [v.name, v.unit, v.display_unit or "", v.derivative_of or "", v.description]
    if any(re.search("[\0\ud800-\udfff]", piece) for piece in pieces):
        message = "a name or description contains a zero byte, or half of a character"
        raise InputError.single(f"{program.name}: {message}")
    text = "".join(piece + "\0" for piece in pieces).encode()
    starts = [v.start for g in ("parameters", "inputs", "states") for v in getattr(program, g)]
    body = b"".join(
        (
            _doubles(code.literals),
            _doubles(starts),
            _doubles(x for v in variables for x in (v.minimum, v.maximum, v.nominal)),
            _words(code.a),
            _words(code.b),
            bytes(code.operation) + bytes(-len(code.operation) % 4),
            _words(code.rates),
            _words(code.results),
            _words(code.constants),
            *(_words(e[column] for e in code.jacobian) for column in range(3)),
            _words(v.tunable * _TUNABLE + v.local * _LOCAL for v in variables),
            text,
        )
    )
    counts = (
        len(program.states),
        len(program.inputs),
        len(program.parameters),
        len(program.outputs),
        len(program.calculated),
        len(code.operation),
        len(code.literals),
        len(code.jacobian),
        len(text),
    )
    size = _HEADER.size + len(body)
    checked = _HEADER.pack(MAGIC, VERSION, 0, size, *counts, 0)[_CHECKED_FROM:] + body
    return struct.pack("<8sII", MAGIC, VERSION, zlib.crc32(checked)) + checked


class _Reader:
    """Takes sections off the bytes; InputError where there are not enough."""

    def __init__(self, data: bytes, offset: int) -> None:
        self.data = data
        self.offset = offset

    def take(self, size: int) -> bytes:
        piece = self.data[self.offset : self.offset + size]
        if len(piece) != size:
            raise _refused("has counts that do not match its size")
        self.offset += size
        return piece

    def numbers(self, kind: str, count: int) -> list[Any]:
        values = array(kind)
        values.frombytes(self.take(count * values.itemsize))
        if sys.byteorder == "big":
            values.byteswap()
        return values.tolist()


def _refused(why: str) -> InputError:
    return InputError.single(f"the program file {why}", "write it again with this m4e_fmi")


def _checked_counts(data: bytes) -> tuple[int, ...]:
    if len(data) < _HEADER.size:
        raise _refused("is too short to be a program")
    magic, version, checksum, size, *counts, zero = _HEADER.unpack_from(data)
    for wrong, why in (
        (magic != MAGIC, "is not a program of m4e_fmi"),
        (version > VERSION, f"has version {version}; this m4e_fmi reads up to {VERSION}"),
        (version != VERSION or zero, "has a damaged header"),
        (size > len(data), f"is truncated: {len(data)} of {size} bytes are there"),
        (size < len(data), "has bytes after its end"),
        (zlib.crc32(data[_CHECKED_FROM:]) != checksum, "is damaged: its checksum does not match"),
    ):
        if wrong:
            raise _refused(why)
    return tuple(counts)


def decode(data: bytes) -> tuple[Program, list[Entry]]:
    """The program, and the entries of its Jacobian as nodes of its tape ([] if it has none).

    Raises InputError where the bytes are not a sound program.
    """
    n_x, n_u, n_p, n_y, n_c, nodes, literals, entries, text_size = _checked_counts(data)
    reader = _Reader(data, _HEADER.size)
    values = reader.numbers("d", literals)
    starts = iter(reader.numbers("d", n_p + n_u + n_x))
    limits = iter(reader.numbers("d", 3 * (n_p + n_u + n_x + n_y + n_c)))
    a, b = reader.numbers("I", nodes), reader.numbers("I", nodes)
    operation = reader.take(nodes + -nodes % 4)[:nodes]
    roots = [reader.numbers("I", count) for count in (n_x, n_y, n_c)]
    rows, columns, derivatives = (reader.numbers("I", entries) for _ in range(3))
    flags = iter(reader.numbers("I", n_p + n_u + n_x + n_y + n_c))
    pieces = reader.take(text_size).decode("utf-8", "replace").split("\0")
    if reader.offset != len(data) or len(pieces) != 3 + 5 * (n_p + n_u + n_x + n_y + n_c):
        raise _refused("has counts that do not match its size")
    groups = {}
    fields = iter(pieces[2:])
    for name, count in zip(_GROUPS, (n_p, n_u, n_x, n_y, n_c), strict=True):
        with_start = name in ("parameters", "inputs", "states")
        groups[name] = tuple(
            _variable(fields, next(flags), next(starts) if with_start else 0.0, limits)
            for _ in range(count)
        )
    names = [[v.name for v in groups[g]] for g in ("states", "inputs", "parameters")]
    tape = _tape(operation, a, b, values, names)
    if max([*(k for group in roots for k in group), *derivatives], default=-1) >= nodes:
        raise _refused("has a result out of range")
    program = Program(
        name=pieces[0],
        description=pieces[1],
        tape=tape,
        rates=tuple(roots[0]),
        results=tuple(roots[1]),
        constants=tuple(roots[2]),
        **groups,
    )
    return program, list(zip(rows, columns, derivatives, strict=True))


def _variable(fields: Iterator[str], flags: int, start: float, limits: Iterator[float]) -> Variable:
    name, unit, display_unit, derivative_of, description = (next(fields) for _ in range(5))
    return Variable(
        name=name,
        unit=unit,
        description=description,
        start=start,
        derivative_of=derivative_of or None,
        tunable=bool(flags & _TUNABLE),
        local=bool(flags & _LOCAL),
        display_unit=display_unit or None,
        minimum=next(limits),
        maximum=next(limits),
        nominal=next(limits),
    )


def _tape(
    operation: bytes,
    a: Sequence[int],
    b: Sequence[int],
    literals: Sequence[float],
    names: Sequence[Sequence[str]],
) -> Tape:
    """The tape again; InputError for an operand that is not before its operation."""
    tape = Tape()
    leaves = {STATE: names[0], INPUT: names[1], PARAMETER: names[2]}
    for k, (kind, first, second) in enumerate(zip(operation, a, b, strict=True)):
        if kind >= len(OPERATIONS):
            raise _refused("has an unknown operation")
        limit = {LITERAL: len(literals), TIME_NODE: 1}.get(kind, len(leaves.get(kind, "")))
        if first >= (limit if kind < FIRST_UNARY else k) or second >= max(k, 1):
            raise _refused("has an operand out of range")
        if kind == LITERAL:
            node = ("constant", literals[first])
        elif kind == TIME_NODE:
            node = ("symbol", TIME)
        elif kind < FIRST_UNARY:
            node = ("symbol", leaves[kind][first])
        else:
            arguments = (first,) if kind < FIRST_BINARY else (first, second)
            node = (OPERATIONS[kind], *arguments)
        if tape.node(node) != k:
            raise _refused("has a node twice")
    return tape
