"""Statuses with which FMUs answer calls that fail, by FMPy."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from fmpy.fmi1 import FMICallException

DISCARD, ERROR = 2, 3


def answers(status: int, action: Callable[[], object]) -> None:
    """Assert that a call answers `status`."""
    with pytest.raises(FMICallException) as caught:
        action()
    assert caught.value.status == status


def discarded(call: Callable[[], object]) -> None:
    """Assert that a call answers Discard."""
    answers(DISCARD, call)
