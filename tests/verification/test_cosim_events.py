"""Steps that an FMU discards because of an event within them: they end at the event."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, run
from m4e_fmi.errors import RunError

Fmus = Callable[[str], Path]
WHEN, STOP = 0.737, 2.0


def switched(fmus: Fmus, options: str, settings: Simulation) -> tuple[dict[float, float], Outcome]:
    """The integral z of y, which rises to `WHEN` and falls from there, at all points."""
    source = Component("a", FmuFile(fmus(f"switch{options}")), {"when": WHEN})
    integral = Component("b", FmuFile(fmus(f"integrator{options}")))
    found: dict[float, float] = {}

    def observe(time: float, network: Network) -> None:
        found[time] = network.read("b.y")

    outcome = run(System("s", (source, integral), ("a.y -> b.u",), settings), observers=[observe])
    return found, outcome


@pytest.mark.verifies(
    "integral of a signal with a kink within a step, which its FMU discards",
    analytic="two parabolas",
    tolerance="1e-9",
)
@pytest.mark.parametrize("options", ["+state", "+state+inputs"])
@pytest.mark.parametrize("algorithm", ["corrector", "implicit"])
@pytest.mark.parametrize("tolerance", [None, 1e-4])
def test_the_step_ends_where_the_fmu_could_go(
    c_fmu: Fmus, options: str, algorithm: str, tolerance: float | None
) -> None:
    settings = Simulation(STOP, 0.1, algorithm, coupling_tolerance=tolerance)
    found, outcome = switched(c_fmu, options, settings)
    assert min(abs(time - WHEN) for time in found) < 1e-9
    assert outcome.rejected > 0
    late = STOP - WHEN
    exact = WHEN**2 / 2 + WHEN * late - late**2 / 2
    # each input is a straight line on either side of the kink, which is met to a nanosecond
    assert found[STOP] == pytest.approx(exact, abs=1e-9)
    if tolerance is None:
        # afterwards points are where they would have been
        regular = {round(0.1 * k, 9) for k in range(21)}
        assert {round(time, 9) for time in found} == regular | {WHEN}


def test_without_a_way_back_it_is_an_error(c_fmu: Fmus) -> None:
    with pytest.raises(RunError, match=r"a \(switch.fmu\): the step from .* answered Discard"):
        switched(c_fmu, "", Simulation(STOP, 0.1))


def test_an_fmu_that_gives_up_for_good_is_an_error(c_fmu: Fmus) -> None:
    rogue = Component("a", FmuFile(c_fmu("rogue+state")), {"what": 2.0, "when": 0.55})
    after = Component("b", FmuFile(c_fmu("stage+state")))
    times: list[float] = []
    system = System("s", (rogue, after), ("a.y -> b.u",), Simulation(STOP, 0.1))
    with pytest.raises(RunError, match=r"a \(rogue_state.fmu\): the step .* answered Discard"):
        run(system, observers=[lambda t, _: times.append(t)])
    # as far as it could go
    assert np.max(times) == pytest.approx(0.55, abs=1e-6)
