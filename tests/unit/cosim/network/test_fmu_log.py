"""How a kind of message is told: how often, in which steps, from when to when."""

from __future__ import annotations

import pytest

from m4e_fmi.cosim import FmuMessage


@pytest.mark.parametrize(
    ("count", "steps", "last", "said"),
    [
        (1, 1, 0.1, "warning at t = 0.1 s"),
        (3, 3, 0.4, "warning, 3 times, t = 0.1 s to 0.4 s"),
        (3, 2, 0.4, "warning, 3 times in 2 steps of the system, t = 0.1 s to 0.4 s"),
        (3, 1, 0.1, "warning, 3 times in 1 step of the system, t = 0.1 s"),
        (3, 0, 0.4, "warning, in 3 steps of the FMU, t = 0.1 s to 0.4 s"),
    ],
)
def test_words(count: int, steps: int, last: float, said: str) -> None:
    message = FmuMessage("pump", "warning", "hot", count, 0.1, last, steps)
    assert str(message) == f"pump, {said}: hot"
