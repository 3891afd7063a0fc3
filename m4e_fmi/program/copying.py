"""Copies of the nodes of one tape on another."""

from __future__ import annotations

from collections.abc import Mapping

from m4e_fmi.program.tape import Scalar, Tape


class TapeCopy:
    """The nodes of `tape` on the tape `target`, each copied when it is first asked for.

    `symbols` are the scalars that stand for symbols of `tape`; more are given by `give`, before a
    node that needs them is asked for.
    """

    def __init__(self, tape: Tape, target: Tape, symbols: Mapping[str, Scalar]) -> None:
        self.tape, self.target = tape, target
        self._symbols = dict(symbols)
        self._copied: dict[int, Scalar] = {}

    def give(self, name: str, scalar: Scalar) -> None:
        """Let `scalar` stand for the symbol `name`."""
        self._symbols[name] = scalar

    def fork(self) -> TapeCopy:
        """Another copy that knows what this one has copied so far."""
        other = TapeCopy(self.tape, self.target, self._symbols)
        other._copied = dict(self._copied)
        return other

    def __call__(self, node: int) -> Scalar:
        """The copy of a node; KeyError for a symbol that nothing stands for."""
        if node not in self._copied:
            for k in self._missing(node):
                kind, *arguments = self.tape.operations[k]
                if kind == "constant":
                    self._copied[k] = self.target.constant(arguments[0])
                elif kind == "symbol":
                    self._copied[k] = self._symbols[arguments[0]]
                else:
                    first, *others = (self._copied[a] for a in arguments)
                    self._copied[k] = first.record(kind, *others)
        return self._copied[node]

    def _missing(self, node: int) -> list[int]:
        """`node` and all that it needs and that is not copied yet, in order."""
        found = {node}
        waiting = [node]
        while waiting:
            for k in self.tape.arguments(waiting.pop()):
                if k not in found and k not in self._copied:
                    found.add(k)
                    waiting.append(k)
        return sorted(found)
