"""Models that grow without bound: the message names the state, since when, and what to do."""

from __future__ import annotations

import re

import pytest

from m4e_fmi.errors import RunError
from m4e_fmi.model import Body, Joint, JointEffort, Model
from m4e_fmi.simulate import simulate


def slider(effort: str) -> Model:
    """A unit mass on a rail, x(0) = 1 m."""
    joint = Joint("prismatic", "cart", direction=(1.0, 0.0), initial={"q": 1.0})
    loads = {"push": JointEffort("rail", effort)}
    return Model("cart", {"cart": Body(1.0, 1.0)}, {"rail": joint}, loads=loads, gravity=0.0)


@pytest.mark.parametrize(("stop", "then"), [(40.0, False), (400.0, True)])
def test_an_unstable_model(stop: float, *, then: bool) -> None:
    # x = cosh(2 t): tenfold in 1.15 s; its square overflows after 178 s
    with pytest.raises(RunError) as caught:
        simulate(slider("4*joint.rail.q"), stop_time=stop, output_interval=0.5)
    error = caught.value
    assert error.message.startswith("cart is unstable: ")
    assert " grew from " in error.message
    assert re.search(r"until t = (20|88\.5) s, to ", error.message)
    assert ("; then cart" in error.message) == then
    assert "signs of stiffness, damping and feedback" in error.remedy


def test_steps_that_are_too_long() -> None:
    # x'' = -100 x by fixed steps of 0.5 s: rk4 is stable to 0.28 s
    with pytest.raises(RunError, match=r"cart is unstable: .* grew from") as caught:
        simulate(slider("-100*joint.rail.q"), stop_time=60, method="rk4", output_interval=0.5)
    assert "smaller step_size" in caught.value.remedy


@pytest.mark.parametrize(
    "effort",
    [
        "1.0e+3",  # free fall along the rail: x = 500 t² m
        "1.0e+3*t**2",
        # from 1e-6 m/s along an exponential to a limit cycle
        "2*(1 - (joint.rail.q - 1)**2)*joint.rail.u - (joint.rail.q - 1) + 1.0e-6*exp(-t)",
    ],
)
def test_what_becomes_large_by_its_nature(effort: str) -> None:
    result = simulate(slider(effort), stop_time=60, output_interval=0.5)
    assert result.time[-1] == 60.0


def test_a_launch_that_fails_for_another_reason_is_not_called_unstable() -> None:
    effort = "1.0e+6 + sqrt(30 - t)"  # no number after 30 s
    with pytest.raises(RunError) as caught:
        simulate(slider(effort), stop_time=60, output_interval=0.5)
    assert "unstable" not in str(caught.value)
