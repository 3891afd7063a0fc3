"""Compiled kernels: a program's blocks as straight-line C, compiled and kept by content.

The C does the operations of the interpreter with the same sine and cosine, so results are the same
bits. Worth it below about 5,000 operations: above, compile time grows faster than the code, and the
code no longer fits the processor's cache.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from m4e_fmi.runtime.bytecode import (
    CODES,
    FIRST_BINARY,
    FIRST_UNARY,
    INPUT,
    LITERAL,
    OPERATIONS,
    PARAMETER,
    STATE,
    TIME_NODE,
    Code,
)
from m4e_fmi.runtime.compiler import cached_shared

LARGEST = 5000
_TRIGONOMETRIC = (CODES["sin"], CODES["cos"])
_NOT_FINITE = {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}
_FORMATS = {
    "neg": "-{a}",
    "abs": "fabs({a})",
    "sign": "(double)(({a} > 0) - ({a} < 0))",
    "add": "{a} + {b}",
    "sub": "{a} - {b}",
    "mul": "{a} * {b}",
    "div": "{a} / {b}",
    "min": "{b} < {a} ? {b} : {a}",
    "max": "{b} > {a} ? {b} : {a}",
}


@dataclass(frozen=True)
class Kernel:
    """Addresses of compiled blocks, None for those too large; `library` keeps them loaded."""

    library: ctypes.CDLL
    rates: int | None
    outputs: int | None
    jacobian: int | None


def kernel_source(code: Code, *, inputs: int, parameters: int, outputs: Sequence[int]) -> str:
    """C source of the blocks of `code` that are not too large; "" if all are.

    `outputs` are the positions of the outputs wanted.
    """
    writer = _Writer(code, inputs, parameters)
    blocks = {
        "rates": code.rates,
        "outputs": [code.results[k] for k in outputs],
        "jacobian": [entry[2] for entry in code.jacobian],
    }
    functions = [writer.function(name, roots) for name, roots in blocks.items() if roots]
    return '#include "elementary.h"\n' + "".join(functions) if any(functions) else ""


def load_kernel(source: str) -> Kernel:
    """`source` compiled, or taken from the cache. Raises CompilationError."""
    loaded = ctypes.CDLL(str(cached_shared("kernel", [], source)))

    def address(name: str) -> int | None:
        function = getattr(loaded, f"m4e_kernel_{name}", None)
        return ctypes.cast(function, ctypes.c_void_p).value if function else None

    return Kernel(loaded, address("rates"), address("outputs"), address("jacobian"))


class _Writer:
    def __init__(self, code: Code, inputs: int, parameters: int) -> None:
        self.code = code
        self.text = self._leaves(inputs)
        for index, k in enumerate(_hoisted(code)):
            self.text[k] = f"fixed[{inputs + parameters + index}]"

    def _leaves(self, inputs: int) -> dict[int, str]:
        code = self.code
        text = {}
        for k, (kind, index) in enumerate(zip(code.operation, code.a, strict=True)):
            if kind == LITERAL:
                value = code.literals[index].hex()
                text[k] = f"({_NOT_FINITE.get(value, value)})"
            elif kind == TIME_NODE:
                text[k] = "t"
            elif kind == STATE:
                text[k] = f"x[{index}]"
            elif kind in (INPUT, PARAMETER):
                text[k] = f"fixed[{index + (inputs if kind == PARAMETER else 0)}]"
        return text

    def function(self, name: str, roots: Sequence[int]) -> str:
        """C function of one block; "" if it is too large."""
        nodes = self._needed(roots)
        if len(nodes) > LARGEST:
            return ""
        lines = [
            "",
            '__attribute__((visibility("default")))',
            f"void m4e_kernel_{name}(double t, const double *restrict x,",
            "    const double *restrict fixed, double *restrict result);",
            f"void m4e_kernel_{name}(double t, const double *restrict x,",
            "    const double *restrict fixed, double *restrict result) {",
            "    (void)t, (void)x, (void)fixed;",
        ]
        text = dict(self.text)
        depth = self._depths(nodes)
        for key, group in groupby(sorted(nodes, key=depth.__getitem__), key=depth.__getitem__):
            members = list(group)
            if key % 2 == 0:
                lines += self._trigonometry(key, members, text)
                continue
            for k in members:
                lines.append(f"    const double v{k} = {self._expression(k, text)};")
                text[k] = f"v{k}"
        lines += [f"    result[{i}] = {text[k]};" for i, k in enumerate(roots)]
        return "\n".join([*lines, "}", ""])

    def _needed(self, roots: Sequence[int]) -> list[int]:
        code, needed = self.code, {k for k in roots if k not in self.text}
        for k in range(max(needed, default=-1), -1, -1):
            if k in needed:
                arguments = (code.a[k], code.b[k])[: 2 if code.operation[k] >= FIRST_BINARY else 1]
                needed.update(a for a in arguments if a not in self.text)
        return sorted(needed)

    def _depths(self, nodes: Sequence[int]) -> dict[int, int]:
        """Even for sines and cosines, odd for what follows them: the order of execution."""
        code, depth = self.code, {}
        for k in nodes:
            kind = code.operation[k]
            deepest = depth.get(code.a[k], 1)
            if kind >= FIRST_BINARY:
                deepest = max(deepest, depth.get(code.b[k], 1))
            depth[k] = (deepest | 1) + (kind in _TRIGONOMETRIC)
        return depth

    def _trigonometry(self, key: int, members: Sequence[int], text: dict[int, str]) -> list[str]:
        """All sines and cosines of one depth, as vectors."""
        code = self.code
        arguments = dict.fromkeys(code.a[k] for k in members)
        place = {k: index for index, k in enumerate(arguments)}
        values = ", ".join(text[k] for k in arguments)
        count = len(arguments)
        for k in members:
            letter = "s" if code.operation[k] == _TRIGONOMETRIC[0] else "c"
            text[k] = f"{letter}{key}[{place[code.a[k]]}]"
        return [
            f"    const double a{key}[] = {{{values}}};",
            f"    double s{key}[{count}], c{key}[{count}];",
            f"    el_sincos_many({count}, a{key}, s{key}, c{key});",
        ]

    def _expression(self, k: int, text: dict[int, str]) -> str:
        code = self.code
        name = OPERATIONS[code.operation[k]]
        a, b = text[code.a[k]], text.get(code.b[k], "")
        if name in _FORMATS:
            return _FORMATS[name].format(a=a, b=b)
        return f"{name}({a}, {b})" if code.operation[k] >= FIRST_BINARY else f"{name}({a})"


def _hoisted(code: Code) -> list[int]:
    """Operations done once per change of a parameter, in the order of the library's registers."""
    roots = [*code.rates, *code.results, *code.constants, *(e[2] for e in code.jacobian)]
    read = set(roots)
    fixed: list[bool] = []
    for k, (kind, a, b) in enumerate(zip(code.operation, code.a, code.b, strict=True)):
        if kind < FIRST_UNARY:
            fixed.append(kind in (LITERAL, PARAMETER))
            continue
        fixed.append(fixed[a] and (kind < FIRST_BINARY or fixed[b]))
        if not fixed[k]:
            read.add(a)
            if kind >= FIRST_BINARY:
                read.add(b)
    operations = enumerate(code.operation)
    return [k for k, kind in operations if kind >= FIRST_UNARY and fixed[k] and k in read]
