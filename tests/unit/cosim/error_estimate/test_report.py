"""The report of coupling errors: ranges of moments beside large forces."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np
import pytest

from m4e_fmi.cosim.connections.links import Link, Port
from m4e_fmi.cosim.error_estimate.report import CouplingErrorReport, Spans, certificate

if TYPE_CHECKING:
    from m4e_fmi.cosim.exchange.network import Network

HULL = (Port("hull", "force_z"), Port("hull", "moment_y"))
UNITS = {"force_z": "N", "moment_y": "N.m", "torque": "N.m", "damping": "N.s/m", "v": "m/s"}


def network_of(*ports: Port, values: list[float]) -> Network:
    found = SimpleNamespace(
        monitored_outputs=tuple(enumerate(ports)),
        unit=lambda port: UNITS[port.variable],
        index=ports.index,
        nominal=lambda _: 1.0,
        values=np.array(values),
        sampled=frozenset({"latch"}),
        links=[Link(LATCH[0], Port("body", "damping"), 0)],
        discrete=SimpleNamespace(outputs=[], takers=frozenset()),
    )
    return cast("Network", found)


def told(
    *ports: Port, values: list[float], errors: list[float], ranges: list[float]
) -> CouplingErrorReport:
    return certificate(
        network_of(*ports, values=values),
        [str(port) for port in ports],
        errors=np.array(errors),
        halved=0.5 * np.array(errors),
        ranges=np.array(ranges),
    )


def test_moments_of_rounding_about_an_axis_of_symmetry_are_no_error() -> None:
    """Of 4 MN about the hull's own axis: 1e-8 N.m of rounding, all of it 'error'."""
    report = told(*HULL, values=[4e6, 0.0], errors=[30.0, 1e-8], ranges=[3e6, 1e-8])
    assert not report.warning()
    assert report.errors[0].source == HULL[0]
    assert report.errors[0].error == pytest.approx(1e-5)
    assert report.errors[1].span == pytest.approx(4e-3)


def test_a_real_error_of_a_moment_is_told() -> None:
    """Of a small lever, 1 mm, of the same force."""
    report = told(*HULL, values=[4e6, 0.0], errors=[30.0, 2e3], ranges=[3e6, 4e3])
    assert report.errors[0].source == HULL[1]
    assert report.errors[0].error == pytest.approx(0.5)
    assert "unusable" in report.warning()


def test_forces_of_another_component_hide_no_error_of_a_moment() -> None:
    """A servo of 1 mN.m beside a hull that floats by 4 MN."""
    servo = Port("servo", "torque")
    report = told(HULL[0], servo, values=[4e6, 0.0], errors=[30.0, 5e-4], ranges=[3e6, 1e-3])
    assert report.errors[0].source == servo
    assert report.errors[0].error == pytest.approx(0.5)


def test_the_estimate_does_not_know_the_noise_of_moments() -> None:
    """The steps that are repeated are those of before: only the report has the bound."""
    spans = Spans(network_of(*HULL, values=[4e6, 0.0]))
    np.testing.assert_array_equal(spans(np.array([3e6, 1e-8])), [3e6, 1e-8])


def test_what_does_not_move_has_no_range() -> None:
    report = told(*HULL, values=[4e6, 0.0], errors=[0.0, 0.0], ranges=[0.0, 0.0])
    assert [found.error for found in report.errors] == [0.0, 0.0]


LATCH = (Port("latch", "damping"), Port("body", "v"))


def switched(*, errors: list[float], leaps: list[float] | None) -> CouplingErrorReport:
    """Errors of a latch that switches between 0 and 1, and of a motion of the range 1."""
    network = network_of(*LATCH, values=[0.0, 0.0])
    return certificate(
        network,
        [str(port) for port in LATCH],
        errors=np.array(errors),
        halved=0.5 * np.array(errors),
        ranges=np.array([1.0, 1.0]),
        leaps=None if leaps is None else np.array(leaps),
    )


def test_what_switches_a_step_later_leaves_the_motion_usable() -> None:
    report = switched(errors=[0.4, 0.02], leaps=[1.0, 0.05])
    assert not report.warning()
    assert report.worst
    assert report.worst.source == LATCH[1]
    assert str(report).endswith(
        "; latch.damping switches a step earlier or later: wrong there by the whole jump"
    )
    assert report.errors[0].source == LATCH[0]  # the largest first, as ever


@pytest.mark.parametrize(
    ("errors", "leaps"),
    [
        ([0.4, 0.3], [1.0, 0.05]),  # the motion is wrong, too
        ([0.4, 0.02], [0.3, 0.05]),  # more than the latch changes within one step
        ([0.4, 0.3], [1.0, 1.0]),  # nothing is left that would say more
        ([0.4, 0.02], None),  # nothing is sampled
    ],
)
def test_errors_that_no_shift_of_a_step_explains_are_unusable(
    errors: list[float], leaps: list[float] | None
) -> None:
    assert "unusable" in switched(errors=errors, leaps=leaps).warning()


def test_what_is_unstable_far_from_the_latch_is_unusable() -> None:
    """It changes by much in every step, and nothing tells it when to switch."""
    far = Port("brake", "force_z")
    report = certificate(
        network_of(*LATCH, far, values=[0.0, 0.0, 0.0]),
        [str(port) for port in (*LATCH, far)],
        errors=np.array([0.4, 0.02, 0.43]),
        halved=np.array([0.2, 0.01, 0.4]),
        ranges=np.ones(3),
        leaps=np.array([1.0, 0.05, 1.0]),
    )
    assert {str(e.source): e.switched for e in report.errors} == {
        "brake.force_z": False,
        "latch.damping": True,
        "body.v": False,
    }
    assert "brake.force_z: the results are unusable" in report.warning()
