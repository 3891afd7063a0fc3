"""How a kind of message is told: how often, from when to when."""

from __future__ import annotations

import pytest

from m4e_fmi.cosim import FmuMessage


@pytest.mark.parametrize(
    ("count", "last", "said"),
    [
        (1, 0.1, "warning at t = 0.1 s"),
        (3, 0.4, "warning, 3 times, t = 0.1 s to 0.4 s"),
        (3, 0.1, "warning, 3 times, t = 0.1 s"),
    ],
)
def test_words(count: int, last: float, said: str) -> None:
    message = FmuMessage("pump", "warning", "hot", count, 0.1, last)
    assert str(message) == f"pump, {said}: hot"
