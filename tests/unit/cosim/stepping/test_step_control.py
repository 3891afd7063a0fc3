"""Sizes of adaptive steps: the law of the estimate, bounds, and attempts that went astray."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.stepping.step_control import OF_NOMINAL, StepControl

LARGEST, ORDER, TOLERANCE, NOMINAL = 1_000_000_000, 2, 1e-3, 5.0


@dataclass
class OneOutput:
    """What of a network a control asks for: one monitored output in m."""

    values: np.ndarray = field(default_factory=lambda: np.array([2.0]))
    outputs: tuple[str, ...] = ("a.y",)
    monitored_outputs: tuple[tuple[str, str], ...] = (("a", "a.y"),)
    time: float = 0.0

    def index(self, port: str) -> int:
        return self.outputs.index(port)

    def unit(self, port: str) -> str:
        return {"a.y": "m"}[port]

    def nominal(self, port: str) -> float:
        return {"a.y": NOMINAL}[port]


def control(start: float = 2.0) -> StepControl:
    network = OneOutput(np.array([start]))
    return StepControl(cast(Network, network), TOLERANCE, LARGEST, ORDER)


def step(one: StepControl, error: float, *, size: int = 0, now: int = 0) -> bool:
    """A step from `now` [ns] with an `error` over tolerance times value; True if it is accepted."""
    change = np.array([error * TOLERANCE * 2.0])
    return one.accepts(change, np.array([2.0]), now, size or one.size)


def test_steps_never_exceed_the_largest() -> None:
    one = control()
    assert step(one, 0.0)
    assert one.size == LARGEST
    assert not step(one, 2.0, now=LARGEST)
    for k in range(3):
        assert step(one, 0.0, now=(k + 1) * LARGEST)
    assert one.size == LARGEST


def test_an_attempt_gone_astray_counts_up_to_a_share_of_the_nominal_value() -> None:
    """From zero, with a nominal value of 5: errors are measured by 0.05 at most."""
    one = control(0.0)
    astray = np.array([1e6])
    assert not one.accepts(astray, astray, 0, one.size)
    bound = TOLERANCE * OF_NOMINAL * NOMINAL
    assert bound == pytest.approx(5e-5)
    at_rest = np.array([0.0])
    assert not one.accepts(np.array([1.01 * bound]), at_rest, 0, one.size)
    assert one.accepts(np.array([0.99 * bound]), at_rest, 0, one.size)


def test_a_value_next_to_nothing_has_no_error() -> None:
    """Its product with the tolerance is 0."""
    next_to_nothing = np.array([5e-324])
    assert control(0.0).accepts(next_to_nothing, next_to_nothing, 0, LARGEST)
