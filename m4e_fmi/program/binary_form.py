"""The binary form of a program: Program → bytes → Program.

The form is versioned, little-endian and checksummed; `src/program.c` documents it byte by byte. It
holds the tape as it is (nodes that results need, in order), so nothing is lost: reading gives the
same program, and writing that gives the same bytes. Hoisting and registers are the reader's work.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterable, Iterator, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from m4e_fmi.errors import InputError
from m4e_fmi.program.program import GROUPS, TIME, Program, Variable
from m4e_fmi.program.tape import Tape

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
_STARTED = ("parameters", "inputs", "states")
"""Groups of variables with start values."""
_TUNABLE, _LOCAL = 1, 2

Entry = tuple[int, int, int]
"""Row, column and node of a derivative: of rate `row` by state `column`, or by time where column is
the number of states; what is not listed is 0."""


def encode(program: Program, jacobian: Iterable[Entry] = ()) -> bytes:
    """The binary form of `program`; nodes of `jacobian` are those of its tape.

    Raises InputError if a name, unit or description contains a zero byte or half a character.
    """
    variables = [v for group in GROUPS for v in getattr(program, group)]
    pieces = [program.name, program.description]
    for v in variables:
        pieces += [v.name, v.unit, v.display_unit or "", v.derivative_of or "", v.description]
    if any(re.search("[\0\ud800-\udfff]", piece) for piece in pieces):
        message = "a name or description contains a zero byte, or half of a character"
        raise InputError.single(f"{program.name}: {message}")
    text = "".join(piece + "\0" for piece in pieces).encode()
    entries = sorted(jacobian)
    roots = [program.rates, program.results, program.constants, [node for _, _, node in entries]]
    number = [0] * len(program.tape)
    leaves = {TIME: (TIME_NODE, 0)}
    for code, group in (
        (STATE, program.states),
        (INPUT, program.inputs),
        (PARAMETER, program.parameters),
    ):
        leaves |= {v.name: (code, index) for index, v in enumerate(group)}
    codes, a, b, literals = bytearray(), list[int](), list[int](), list[float]()
    for k in program.tape.reachable(k for group in roots for k in group):
        number[k] = len(codes)
        kind, first, *others = program.tape.operations[k]
        if kind == "constant":
            literals.append(first)
            code, first = LITERAL, len(literals) - 1
        elif kind == "symbol":
            code, first = leaves[first]
        else:
            code, first = CODES[kind], number[first]
        codes.append(code)
        a.append(first)
        b.append(number[others[0]] if others else 0)
    body = b"".join(
        (
            _doubles(literals),
            _doubles(v.start for group in _STARTED for v in getattr(program, group)),
            _doubles(x for v in variables for x in (v.minimum, v.maximum, v.nominal)),
            _words(a),
            _words(b),
            bytes(codes) + bytes(-len(codes) % 4),
            *(_words(number[k] for k in group) for group in roots[:3]),
            _words(row for row, _, _ in entries),
            _words(column for _, column, _ in entries),
            _words(number[k] for k in roots[3]),
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
        len(codes),
        len(literals),
        len(entries),
        len(text),
    )
    size = _HEADER.size + len(body)
    checked = _HEADER.pack(MAGIC, VERSION, 0, size, *counts, 0)[_CHECKED_FROM:] + body
    return struct.pack("<8sII", MAGIC, VERSION, zlib.crc32(checked)) + checked


def _words(values: Iterable[int]) -> bytes:
    return np.array([*values], "<u4").tobytes()


def _doubles(values: Iterable[float]) -> bytes:
    return np.array([*values], "<f8").tobytes()


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

    Raises InputError where the bytes are not a program, or damaged.
    """
    try:
        return _decoded(data)
    except (ValueError, LookupError, RuntimeError) as error:  # the checksum is right: forged
        raise InputError.single("is damaged: its checksum is not of this content") from error


def _decoded(data: bytes) -> tuple[Program, list[Entry]]:
    n_x, n_u, n_p, n_y, n_c, nodes, literals, entries, text_size = _checked_counts(data)
    stream, count = BytesIO(data[_HEADER.size :]), n_p + n_u + n_x + n_y + n_c

    def numbers(kind: str, count: int) -> list[Any]:
        values = np.dtype(kind)
        return np.frombuffer(stream.read(count * values.itemsize), values).tolist()

    values = numbers("<f8", literals)
    starts = iter(numbers("<f8", n_p + n_u + n_x))
    limits = iter(numbers("<f8", 3 * count))
    a, b = numbers("<u4", nodes), numbers("<u4", nodes)
    operation = stream.read(nodes + -nodes % 4)[:nodes]
    roots = [numbers("<u4", count) for count in (n_x, n_y, n_c)]
    rows, columns, derivatives = (numbers("<u4", entries) for _ in range(3))
    flags = iter(numbers("<u4", count))
    pieces = stream.read(text_size).decode().split("\0")
    groups: dict[str, Any] = {}
    fields = iter(pieces[2:])
    for name, size in zip(GROUPS, (n_p, n_u, n_x, n_y, n_c), strict=True):
        groups[name] = tuple(
            _variable(fields, next(flags), next(starts) if name in _STARTED else 0.0, limits)
            for _ in range(size)
        )
    names = [[v.name for v in groups[g]] for g in ("states", "inputs", "parameters")]
    tape = _tape(operation, a, b, values, names)
    if max((root for group in roots for root in group), default=-1) >= nodes:
        raise ValueError("results are no nodes")
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
    """The tape again."""
    tape = Tape()
    leaves = {STATE: names[0], INPUT: names[1], PARAMETER: names[2]}
    for kind, first, second in zip(operation, a, b, strict=True):
        if kind == LITERAL:
            node = ("constant", literals[first])
        elif kind == TIME_NODE:
            node = ("symbol", TIME)
        elif kind < FIRST_UNARY:
            node = ("symbol", leaves[kind][first])
        else:
            arguments = (first,) if kind < FIRST_BINARY else (first, second)
            node = (OPERATIONS[kind], *arguments)
        tape.node(node)
    return tape
