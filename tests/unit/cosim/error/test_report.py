"""The report of coupling errors: moments beside large forces, outputs that switch."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from m4e_fmi.cosim.error.report import CouplingErrorReport, Spans, certificate
from m4e_fmi.cosim.wiring.links import Link, Port

if TYPE_CHECKING:
    from m4e_fmi.cosim.network.network import Network

FORCE, MOMENT = Port("hull", "force_z"), Port("hull", "moment_y")
SERVO, BRAKE = Port("servo", "torque"), Port("brake", "force_z")
LATCH, MOTION = Port("latch", "damping"), Port("body", "v")
UNITS = {"force_z": "N", "moment_y": "N.m", "torque": "N.m", "damping": "N.s/m", "v": "m/s"}


def network_of(ports: dict[Port, float]) -> Network:
    """What of a network a report asks for: outputs with their values; the latch is sampled."""
    found = SimpleNamespace(
        monitored_outputs=tuple(enumerate(ports)),
        unit=lambda port: UNITS[port.variable],
        index=list(ports).index,
        nominal=lambda _: 1.0,
        values=np.array(list(ports.values())),
        sampled=frozenset({"latch"}),
        links=[Link(LATCH, Port("body", "damping"), 0)],
        discrete=SimpleNamespace(outputs=[], takers=frozenset()),
    )
    return cast("Network", found)


def report(
    ports: dict[Port, float],
    errors: list[float],
    ranges: list[float],
    leaps: list[float] | None = None,
) -> CouplingErrorReport:
    return certificate(
        network_of(ports),
        [str(port) for port in ports],
        errors=np.array(errors),
        halved=0.5 * np.array(errors),
        ranges=np.array(ranges),
        leaps=None if leaps is None else np.array(leaps),
    )


@pytest.mark.parametrize(
    ("other", "error", "span", "largest", "told"),
    [
        # 1e-8 N.m of rounding about the hull's own axis, all of it 'error'
        (MOMENT, 1e-8, 1e-8, FORCE, 1e-5),
        # a real error of a small lever, 1 mm, of the same force
        (MOMENT, 2e3, 4e3, MOMENT, 0.5),
        # a servo of 1 mN.m beside a hull that floats by 4 MN
        (SERVO, 5e-4, 1e-3, SERVO, 0.5),
    ],
)
def test_errors_of_moments(
    other: Port, error: float, span: float, largest: Port, told: float
) -> None:
    found = report({FORCE: 4e6, other: 0.0}, [30.0, error], [3e6, span])
    assert found.errors[0].source == largest
    assert found.errors[0].error == pytest.approx(told)
    assert ("unusable" in found.warning()) == (told > 0.1)


@pytest.mark.parametrize(
    ("errors", "leaps", "usable"),
    [
        ([0.4, 0.02], [1.0, 0.05], True),
        ([0.4, 0.3], [1.0, 0.05], False),  # the motion is wrong, too
        ([0.4, 0.02], [0.3, 0.05], False),  # more than the latch changes within one step
        ([0.4, 0.3], [1.0, 1.0], False),  # nothing is left that would say more
        ([0.4, 0.02], None, False),  # nothing is sampled
    ],
)
def test_what_switches_a_step_later_leaves_the_motion_usable(
    errors: list[float], leaps: list[float] | None, usable: bool
) -> None:
    """A latch that switches between 0 and 1, and a motion of the range 1."""
    found = report({LATCH: 0.0, MOTION: 0.0}, errors, [1.0, 1.0], leaps)
    assert ("unusable" not in found.warning()) == usable
    assert found.errors[0].source == LATCH  # the largest first, as ever
    if usable:
        assert found.worst
        assert found.worst.source == MOTION
        assert "latch.damping switches a step earlier or later: wrong there by" in str(found)


def test_what_is_unstable_far_from_the_latch_is_unusable() -> None:
    """It changes by much in every step, and nothing tells it when to switch."""
    ports = {LATCH: 0.0, MOTION: 0.0, BRAKE: 0.0}
    found = report(ports, [0.4, 0.02, 0.43], [1.0, 1.0, 1.0], [1.0, 0.05, 1.0])
    assert {e.source: e.switched for e in found.errors} == {BRAKE: 0, LATCH: 1, MOTION: 0}
    assert "brake.force_z: the results are unusable" in found.warning()


def test_ranges_of_rounding_noise_are_no_scale_of_errors() -> None:
    """Of a force of 4 MN and a speed of 0, whose noise is all that they range over."""
    spans = Spans(network_of({FORCE: 4e6, MOTION: 0.0}))
    np.testing.assert_allclose(spans(np.array([1e-9, 2e-15])), [4e-6, 1e-12], rtol=1e-15)
    np.testing.assert_array_equal(spans(np.array([1.0, 1e-9])), [1.0, 1e-9])
