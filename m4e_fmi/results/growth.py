"""Growth without bound: by how much a quantity has grown that a failure is blamed on, in words.

A quantity of an unstable system grows by the same factor in equal times, so that it has grown by a
large factor since half of the run. What becomes large by its nature, as a free fall, has not.
"""

from __future__ import annotations

from dataclasses import dataclass

FACTOR = 1e4
"""Growth since half of the run, or earlier, that tells an unstable system where something fails."""


@dataclass(frozen=True)
class Growth:
    """`name` was at most `low` until `since` [s], and is `high` at `until` [s], in its unit."""

    name: str
    since: float
    low: float
    until: float
    high: float

    def text(self, description: str = "", unit: str = "") -> str:
        """The growth in words."""
        unit = "" if unit in ("", "1") else f" {unit}"
        what = f" ({description})" if description else ""
        return (
            f"{self.name}{what} grew from {self.low:.3g}{unit}, its largest until "
            f"t = {self.since:.6g} s, to {self.high:.3g}{unit} at t = {self.until:.6g} s"
        )
