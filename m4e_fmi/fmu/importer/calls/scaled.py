"""Scales of inputs that are set otherwise than their sources are: to factor·v + offset for v."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np

PLAIN = 1.0, -0.0
"""Factor and offset that leave every value as it is, to the last bit."""


class InputScales:
    """Factor and offset of links whose inputs get factor·v + offset, v in their sources' units.

    A link is known by its ends. Those that are to be followed may change: operations that use them
    change with them.
    """

    def __init__(self) -> None:
        self._of: dict[Hashable, tuple[float, float]] = {}
        self._added: dict[Hashable, float] = {}
        self._followed: set[Hashable] = set()
        self._uses: list[tuple[list[Hashable], np.ndarray, np.ndarray | None]] = []

    def set(self, link: Hashable, factor: float, offset: float) -> None:
        """From now on, a link gives factor·v + offset, in its input's unit."""
        self._of[link] = factor, offset + self._added.get(link, 0.0)
        for links, factors, offsets in self._uses:
            for k, used in enumerate(links):
                if used == link:
                    factors[k] = factor
                    if offsets is not None:
                        offsets[k] = self._of[link][1]

    def add(self, link: Hashable, amount: float) -> None:
        """From now on, a link that is followed gives an `amount` more, in its input's unit."""
        factor, offset = self._of[link]
        self._added[link] = amount
        self.set(link, factor, offset)

    def follow(self, link: Hashable) -> None:
        """The factor and the offset of a link are going to change: before they are used."""
        self._of.setdefault(link, PLAIN)
        self._followed.add(link)

    def factor(self, link: Hashable) -> float:
        """The factor of a link, in its input's unit over its source's."""
        return self._of.get(link, PLAIN)[0]

    def of(self, links: Sequence[Hashable]) -> tuple[np.ndarray, np.ndarray] | None:
        """Factors and offsets (n_links,), in the inputs' over the sources' units; None if plain."""
        if self._of.keys().isdisjoint(links):
            return None
        pairs = np.array([self._of.get(link, PLAIN) for link in links])
        factors, offsets = pairs[:, 0].copy(), pairs[:, 1].copy()
        self._use(links, factors, offsets)
        return factors, offsets

    def of_derivatives(self, links: Sequence[Hashable]) -> np.ndarray | None:
        """Factors (n_links,) of a time derivative of each, as `of` has them, in the same units."""
        if self._of.keys().isdisjoint(links):
            return None
        factors = np.array([self.factor(link) for link in links])
        self._use(links, factors, None)
        return factors

    def _use(
        self, links: Sequence[Hashable], factors: np.ndarray, offsets: np.ndarray | None
    ) -> None:
        if not self._followed.isdisjoint(links):
            self._uses.append((list(links), factors, offsets))
