"""Steps that an FMU discards because of an event within them: they end at the event."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_systems import Fmus, observed, system

from m4e_fmi.cosim import Simulation, run
from m4e_fmi.errors import RunError

WHEN, STOP = 0.737, 2.0


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
    """The integral z of y, which rises to `WHEN` and falls from there."""
    parts = {"a": f"switch{options}", "b": f"integrator{options}"}
    settings = Simulation(STOP, 0.1, algorithm, coupling_tolerance=tolerance)
    start = {"a": {"when": WHEN}}
    pair = system(c_fmu, parts, "a.y -> b.u", start=start, simulation=settings)
    rows, outcome = observed(pair, "b.y")
    times, course = np.array(rows).T
    assert np.abs(times - WHEN).min() < 1e-9
    assert outcome.rejected > 0
    late = STOP - WHEN
    exact = WHEN**2 / 2 + WHEN * late - late**2 / 2
    # each input is a straight line on either side of the kink, which is met to a nanosecond
    assert course[-1] == pytest.approx(exact, abs=1e-9)
    if tolerance is None:
        # afterwards points are where they would have been
        regular = {round(0.1 * k, 9) for k in range(21)}
        assert {round(time, 9) for time in times} == regular | {WHEN}


def test_an_fmu_that_gives_up_for_good_is_an_error(c_fmu: Fmus) -> None:
    parts, start = {"a": "rogue+state", "b": "stage+state"}, {"a": {"what": 2.0, "when": 0.55}}
    settings, times = Simulation(STOP, 0.1), list[float]()
    pair = system(c_fmu, parts, "a.y -> b.u", start=start, simulation=settings)
    with pytest.raises(RunError, match=r"a \(rogue_state.fmu\): the step .* answered Discard"):
        run(pair, observers=[lambda t, _: times.append(t)])
    # as far as it could go
    assert np.max(times) == pytest.approx(0.55, abs=1e-6)
