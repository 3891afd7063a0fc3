"""Orders that follow from declared dependencies, and the loops that have none."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from support.small_systems import Fmus, system

from m4e_fmi.cosim import Prepared, Simulation, Timing, prepare

LINK = "body.m <-> spring.end"


def prepared(
    fmus: Fmus, names: Mapping[str, str], *links: str, algorithm: str = "gauss_seidel"
) -> Prepared:
    return prepare(system(fmus, names, *links, simulation=Simulation(1, 0.1, algorithm)))


def test_sources_of_unpredictable_values_step_first(c_fmu: Fmus) -> None:
    names = {"body": "mass", "far": "spring", "spring": "spring"}
    found = prepared(c_fmu, names, LINK, "body.body.m.x -> far.end.x")
    assert found.structure.execution_order == ("far", "spring", "body")
    assert found.structure.delayed == ()
    assert [str(port) for port in found.wiring.unconnected] == ["far.end.vx"]


def test_a_cycle_is_broken_where_listed_first_and_told(c_fmu: Fmus) -> None:
    found = prepared(c_fmu, dict.fromkeys("ab", "integrator"), "b.y -> a.u", "a.y -> b.u")
    assert found.structure.execution_order == ("a", "b")
    assert [str(link) for link in found.structure.delayed] == ["b.y -> a.u"]
    told = str(found).splitlines()
    assert "extrapolated from the step before" in told[told.index("  b.y -> a.u  (1 variable)") + 1]


@pytest.mark.parametrize(
    ("algorithm", "options", "force", "motion"),
    [
        ("jacobi", "", Timing.LATE, Timing.LATE),
        ("gauss_seidel", "", Timing.KNOWN, Timing.PREDICTED),
        ("corrector", "+state", Timing.CORRECTED, Timing.CORRECTED),
        ("corrector", "", Timing.KNOWN, Timing.PREDICTED),
        ("implicit", "+state", Timing.SOLVED, Timing.SOLVED),
    ],
)
def test_how_late_each_connection_is(
    c_fmu: Fmus, algorithm: str, options: str, force: Timing, motion: Timing
) -> None:
    names = {"body": f"mass{options}", "spring": f"spring{options}", "c": f"stage{options}"}
    links = (LINK, "spring.end.force_x * 2 -> c.u, units ignored")
    found = prepared(c_fmu, names, *links, algorithm=algorithm)
    timings = {str(link): timing for link, timing in found.timings.items()}
    assert timings["spring.end.force_x -> body.body.m.force_x"] is force
    assert timings["body.body.m.x -> spring.end.x"] is motion
    beyond = Timing.KNOWN if algorithm in ("corrector", "gauss_seidel") else force
    assert timings["spring.end.force_x -> c.u"] is beyond
    assert "components that interact:\n  spring, body" in str(found)
    assert "converted: c.u = 2 * spring.end.force_x" in str(found)
