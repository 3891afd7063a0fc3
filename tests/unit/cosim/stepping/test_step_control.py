"""Sizes of adaptive steps: the law of the estimate, bounds, and attempts that went astray."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest

from m4e_fmi.cosim.exchange.network import Network
from m4e_fmi.cosim.stepping.step_control import LEAST, MOST, OF_NOMINAL, SAFETY, StepControl
from m4e_fmi.errors import RunError

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


@pytest.mark.parametrize(
    ("error", "factor"),
    [
        (4.0, SAFETY / 2),
        (100.0, LEAST),  # 0.09 otherwise
        (1.01, SAFETY / np.sqrt(1.01)),
    ],
)
def test_a_rejected_step_shrinks_by_the_law_of_its_order(error: float, factor: float) -> None:
    one = control()
    assert not step(one, error)
    assert one.size == int(LARGEST * factor)
    assert one.rejected == 1


def test_accepted_steps_grow_by_their_law_but_not_right_after_a_rejection() -> None:
    one = control()
    assert not step(one, 400.0)
    small = one.size
    assert step(one, 0.01)  # the law says 9 times
    assert one.size == small
    assert step(one, 0.5, now=small)
    assert one.size == int(small * SAFETY / np.sqrt(0.5))
    before = one.size
    assert step(one, 0.0, now=2 * small)
    assert one.size == MOST * before
    assert step(one, 0.5, size=before // 100)  # one cut short does not shrink the next
    assert one.size == MOST * before


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


def test_the_smallest_step_passes_once_and_then_ends_the_run() -> None:
    one = control()
    smallest = LARGEST // 1_000_000
    assert step(one, 1e6, size=smallest)
    assert one.passed
    with pytest.raises(RunError, match=r"a\.y at t = 0 s stays above coupling_tolerance"):
        step(one, 1e6, size=smallest)
