"""Scales of inputs that are set otherwise than their sources are: to factor·v + offset for v."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

PLAIN = 1.0, -0.0
"""Factor and offset that leave every value as it is, to the last bit."""


class InputScales:
    """Factor and offset of inputs that are set as factor·v + offset, v in their sources' units.

    Those that are to be followed may change: calls and operations that use them change with them.
    """

    def __init__(self) -> None:
        self._of: dict[str, tuple[float, float]] = {}
        self._followed: set[str] = set()
        self._uses: list[tuple[list[str], np.ndarray, np.ndarray | None]] = []

    def set(self, name: str, factor: float, offset: float) -> None:
        """From now on, `name` is given factor·v + offset, in its FMU's unit."""
        self._of[name] = factor, offset
        for names, factors, offsets in self._uses:
            for k, used in enumerate(names):
                if used == name:
                    factors[k] = factor
                    if offsets is not None:
                        offsets[k] = offset

    def follow(self, name: str) -> None:
        """The factor and the offset of `name` are going to change: before they are used."""
        self._of.setdefault(name, PLAIN)
        self._followed.add(name)

    def factor(self, name: str) -> float:
        """The factor of an input, in its FMU's unit over its source's."""
        return self._of.get(name, PLAIN)[0]

    def of(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray] | None:
        """Factors and offsets (n_names,), in FMU units over the sources'; None if all are plain."""
        if self._of.keys().isdisjoint(names):
            return None
        pairs = np.array([self._of.get(name, PLAIN) for name in names])
        factors, offsets = pairs[:, 0].copy(), pairs[:, 1].copy()
        self._use(names, factors, offsets)
        return factors, offsets

    def of_derivatives(self, names: Sequence[str]) -> np.ndarray | None:
        """Factors (n_names,) of a time derivative of each, as `of` has them, in the same units."""
        if self._of.keys().isdisjoint(names):
            return None
        factors = np.array([self.factor(name) for name in names])
        self._use(names, factors, None)
        return factors

    def _use(self, names: Sequence[str], factors: np.ndarray, offsets: np.ndarray | None) -> None:
        if not self._followed.isdisjoint(names):
            self._uses.append((list(names), factors, offsets))
