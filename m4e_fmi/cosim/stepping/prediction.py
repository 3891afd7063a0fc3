"""Mean, end value and mean slope of an exchanged signal over a step, from what is known before it.

Each is a linear combination of entries of the network's `values`; here are the coefficients. The
formulas and their order are explained in `gauss_seidel`.
"""

from __future__ import annotations

from dataclasses import dataclass

Terms = dict[int, float]
"""A linear combination: index into `Network.values` → coefficient."""
MOST_TERMS = 3


@dataclass(frozen=True)
class Signal:
    """Where the values of one source stand in `Network.values`.

    `stepped` is its end-of-step value, None if its component steps later; `rate` and `curvature`
    are its declared first and second time derivative now, None if there is none. One that `stays`
    is the same all through the step.
    """

    now: int
    before: int
    stepped: int | None
    rate: int | None
    curvature: int | None
    stays: bool = False

    def mean(self, size: float, last: float) -> Terms:
        """Mean over a step of `size` [s] after one of `last` [s] (0: there was none)."""
        if self.stays:
            return self.start(size, last)
        if self.stepped is not None:
            return self._parabola_mean(self.stepped, size, last)
        if self.rate is not None:
            return self._taylor(size / 2, size**2 / 6)
        return self._line(size / 2, last)

    def start(self, size: float, last: float) -> Terms:
        """Value at the start of the step."""
        del size, last
        return {self.now: 1.0}

    def along(self, share: float, size: float, last: float) -> Terms:
        """Value at a share of the step on the straight line to its end."""
        if share == 0.0:
            return self.start(size, last)
        terms = {index: share * factor for index, factor in self.end(size, last).items()}
        terms[self.now] = terms.get(self.now, 0.0) + 1.0 - share
        return terms

    def end(self, size: float, last: float) -> Terms:
        """Value at the end of the step."""
        if self.stays:
            return self.start(size, last)
        if self.stepped is not None:
            return {self.stepped: 1.0}
        if self.rate is not None:
            return self._taylor(size, size**2 / 2)
        return self._line(size, last)

    def slope(self, size: float, last: float) -> Terms:
        """Mean slope over the step: (end − now)/size."""
        terms = {index: factor / size for index, factor in self.end(size, last).items()}
        terms[self.now] = terms.get(self.now, 0.0) - 1.0 / size
        return terms

    def _parabola_mean(self, stepped: int, size: float, last: float) -> Terms:
        if last == 0.0:
            return {self.now: 0.5, stepped: 0.5}
        # quadratic coefficient c of the parabola; mean = (now + stepped)/2 − c size²/6
        total = size + last
        weight = size**2 / 6
        return {
            stepped: 0.5 - weight / (size * total),
            self.now: 0.5 + weight / (size * last),
            self.before: -weight / (last * total),
        }

    def _taylor(self, first: float, second: float) -> Terms:
        assert self.rate is not None
        terms = {self.now: 1.0, self.rate: first}
        if self.curvature is not None:
            terms[self.curvature] = second
        return terms

    def _line(self, ahead: float, last: float) -> Terms:
        if last == 0.0:
            return {self.now: 1.0}
        return {self.now: 1.0 + ahead / last, self.before: -ahead / last}
