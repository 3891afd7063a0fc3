"""Orders that follow from declared dependencies, and the loops that have none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from m4e_fmi.cosim import Component, FmuFile, Prepared, Simulation, System, Timing, prepare

Fmus = Callable[[str], Path]


def prepared(fmus: Fmus, components: dict[str, str], *connections: str) -> Prepared:
    parts = tuple(Component(name, FmuFile(fmus(model))) for name, model in components.items())
    return prepare(System("s", parts, connections, Simulation(1, 0.1, "gauss_seidel")))


def test_sources_of_unpredictable_values_step_first(c_fmu: Fmus) -> None:
    names = {"body": "mass", "far": "spring", "near": "spring"}
    found = prepared(c_fmu, names, "body.m <-> near.end", "body.body.m.x -> far.end.x")
    assert found.structure.execution_order == ("far", "near", "body")
    assert found.structure.delayed == ()
    assert [str(port) for port in found.wiring.unconnected] == ["far.end.vx"]


def test_a_cycle_is_broken_where_listed_first_and_told(c_fmu: Fmus) -> None:
    names = {"a": "integrator", "b": "integrator"}
    found = prepared(c_fmu, names, "b.y -> a.u", "a.y -> b.u")
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
    names = {"a": f"mass{options}", "b": f"spring{options}", "c": f"stage{options}"}
    parts = tuple(Component(name, FmuFile(c_fmu(model))) for name, model in names.items())
    links = ("a.body.m <-> b.end", "b.end.force_x * 2 -> c.u, units ignored")
    found = prepare(System("s", parts, links, Simulation(1, 0.1, algorithm)))
    timings = {str(link): timing for link, timing in found.timings.items()}
    assert timings["b.end.force_x -> a.body.m.force_x"] is force
    assert timings["a.body.m.x -> b.end.x"] is motion
    beyond = Timing.KNOWN if algorithm in ("corrector", "gauss_seidel") else force
    assert timings["b.end.force_x -> c.u"] is beyond
    told = str(found)
    assert "components that interact:\n  b, a" in told
    assert "converted: c.u = 2 * b.end.force_x" in told


def test_loops_are_named(c_fmu: Fmus) -> None:
    parts = tuple(Component(name, FmuFile(c_fmu("stage"))) for name in "ab")
    ring = System("s", parts, ("a.y -> b.u", "b.y -> a.u"), Simulation(1, 0.1))
    found = prepare(ring)
    assert [list(map(str, loop)) for loop in found.structure.loops] == [
        ["a.u", "a.y", "b.u", "b.y"]
    ]
    told = str(found).splitlines()
    at = told.index("algebraic loops, solved at every communication point:")
    assert told[at + 1] == "  a.u -> a.y -> b.u -> b.y -> a.u"
