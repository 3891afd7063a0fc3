"""Compiled kernels: blocks of a model as straight-line C, compiled and kept by content.

The C does the instructions of the interpreter in their order, with the same sine and cosine, so
results are the same bits. Worth it below about 5,000 operations: above, compile time grows faster
than the code, and the code no longer fits the processor's cache.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence

import numpy as np

from m4e_fmi.program.binary_form import OPERATIONS
from m4e_fmi.runtime.compiler import VECTOR_FLAGS, cached_shared
from m4e_fmi.runtime.declarations import BlockStruct, Counts

LARGEST = 5000
"""Instructions of a block that is compiled, at most."""

_RING = ("+", "-", "*")
_FUSED = tuple(
    outer.format(f"({{a}} {inner} {{b}})")
    for outer in ("{} + {{c}}", "{} - {{c}}", "{} * {{c}}", "{{c}} - {}")
    for inner in _RING
)
_CHAINED = tuple(f"({{c}} {x} {{a}} * {{b}}) {y} {{e}} * {{f}}" for x in "+-" for y in "+-")
_PAIRED = tuple(
    f"({{a}} {first} {{b}}) {outer} ({{e}} {second} {{f}})"
    for outer in _RING
    for second in _RING
    for first in _RING
)
SEVERAL = (*_FUSED, *_CHAINED, *_PAIRED)
"""Instructions for several operations, in order of their codes; `operations.h` has them in C."""
_FIRST_CHAINED = len(OPERATIONS) + len(_FUSED)
_SINCOS = len(OPERATIONS) + len(SEVERAL)
_WRITTEN = {
    "neg": "-{a}",
    "add": "{a} + {b}",
    "sub": "{a} - {b}",
    "mul": "{a} * {b}",
    "div": "{a} / {b}",
}


def kernel_source(blocks: Mapping[str, BlockStruct], counts: Counts, *, lanes: int = 1) -> str:
    """C source of the blocks that are not too large, functions of their names; "" if all are."""
    writer = _Writer(counts)
    small = {name: block for name, block in blocks.items() if 1 < block.length <= LARGEST}
    functions = [writer.function(name, block) for name, block in small.items()]
    return "\n".join([f'#define LANES {lanes}\n#include "kernel.h"', *functions] if small else [])


def load_kernel(source: str, instruction_set: str = "") -> ctypes.CDLL:
    """`source` compiled, or taken from the cache. Raises CompilationError, OSError."""
    flags = VECTOR_FLAGS[instruction_set]
    return ctypes.CDLL(str(cached_shared("kernel", [], source, flags=flags)))


class _Writer:
    """C functions of one model's blocks: `text` says what a register is at present."""

    def __init__(self, counts: Counts) -> None:
        self.fixed = 1 + counts.states
        many = counts.inputs + counts.parameters + counts.hoisted + counts.literals + counts.timely
        self.leaves = ["OF(t, 0)", *(f"OF(x, {k})" for k in range(counts.states))]
        self.leaves += [f"OF(fixed, {k})" for k in range(many)]

    def function(self, name: str, block: BlockStruct) -> str:
        words = ctypes.cast(block.code, ctypes.POINTER(ctypes.c_uint32))
        rows = np.ctypeslib.as_array(words, (block.length, 4)).tolist()
        text = dict(enumerate(self.leaves))
        lines = [f"\nM4E_KERNEL({name}) {{", "    M4E_ARGUMENTS {"]
        index = 0
        while index < len(rows) - 1:  # the last one ends the block
            code = rows[index][0]
            if code & 255 == _SINCOS:
                group = rows[index : index + (code >> 8)]
                lines += self._trigonometry(index, group, text)
                index += len(group)
                continue
            expression = self._expression(rows[index], rows[index + 1], text)
            lines.append(f"    const real v{index} = {expression};")
            text[rows[index][1]] = f"v{index}"
            index += 2 if _FIRST_CHAINED <= code & 255 < _SINCOS else 1
        registers = np.ctypeslib.as_array(
            ctypes.cast(block.result, ctypes.POINTER(ctypes.c_uint32)), (block.results,)
        )
        lines += [f"    OF(result, {i}) = {text[r]};" for i, r in enumerate(registers.tolist())]
        return "\n".join([*lines, "    }", "}", ""])

    def _trigonometry(
        self, index: int, group: Sequence[Sequence[int]], text: dict[int, str]
    ) -> list[str]:
        """Consecutive sines and cosines, as vectors."""
        values = ", ".join(text[a] for _, _, a, _ in group)
        count = len(group)
        for k, (_, cosine, _, sine) in enumerate(group):
            text[sine], text[cosine] = f"s{index}[{k}]", f"c{index}[{k}]"
        return [
            f"    const real a{index}[] = {{{values}}};",
            f"    real s{index}[{count}], c{index}[{count}];",
            f"    el_sincos_many({count} * AT_A_TIME, (const double *)a{index},",
            f"                   (double *)s{index}, (double *)c{index});",
        ]

    def _expression(self, row: Sequence[int], more: Sequence[int], text: Mapping[int, str]) -> str:
        """Of an instruction; `more` is what follows it, where e and f may be."""
        code, _, a, b = row
        kind = code & 255
        names = {"a": text[a], "b": text[b], "c": text.get(code >> 8, "")}
        names |= {"e": text.get(more[2], ""), "f": text.get(more[3], "")}
        if kind >= len(OPERATIONS):
            return SEVERAL[kind - len(OPERATIONS)].format(**names)
        name = OPERATIONS[kind]
        written = _WRITTEN.get(name, f"each_{name.upper()}({{a}}, {{b}})")
        return written.format(**names)
