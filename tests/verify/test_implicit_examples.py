"""`implicit` on all systems of examples/, at their step, at half and at twice it.

The reference is `corrector` at a quarter of the smallest of these steps. What a run states must be
true within 3 at the points that it is found at: those of steps of twice the length. Of what is
stated to be below 1e-5, the reference's own error may be a part.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.example_systems import example_system, hydraulic_kinds

from m4e_fmi.cosim import Network, Outcome, System, run
from m4e_fmi.cosim.error.report import CouplingErrorReport

CASES = {
    "sphere_decay/system.yaml": 20.0,
    "flexible_pendulum/system.yaml": 5.0,
    "moored_buoy/system.yaml": 5.0,
    "moored_buoy/system.yaml without mooring": 20.0,
    "hydraulic_pto/system.yaml": 12.0,
    "hydraulic_pto/system_scipy.yaml": 4.0,
}
"""How long each is run [s]."""
ROUGH = {"moored_buoy/system.yaml": 3e-4}
"""Share of range that lines on the seabed leave in their forces, however short the step."""

Courses = dict[int, np.ndarray]


@pytest.fixture(scope="module", autouse=True)
def _kinds(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with hydraulic_kinds(tmp_path_factory.mktemp("site")):
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("build")


def system(case: str) -> System:
    name, _, without = case.partition(" without ")
    found = example_system(name, without=without)
    return replace(found, simulation=replace(found.simulation, output_interval=None))


def course(case: str, folder: Path, **settings: Any) -> tuple[Courses, Network, Outcome]:
    """Judged outputs at all communication points."""
    seen: Courses = {}
    networks: list[Network] = []

    def observe(time: float, network: Network) -> None:
        networks[:] = [network]
        places = [network.index(port) for _, port in network.monitored_outputs]
        seen[round(time * 1e9)] = network.values[places]

    changed = system(case).changed(stop_time=CASES[case], **settings)
    outcome = run(changed, build_directory=folder, observers=[observe])
    return seen, networks[0], outcome


@pytest.fixture(scope="module", params=CASES)
def reference(request: pytest.FixtureRequest, folder: Path) -> tuple[str, Courses]:
    case = request.param
    step = system(case).simulation.step_size / 8
    return case, course(case, folder, algorithm="corrector", step_size=step)[0]


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_implicit_runs_the_examples(
    reference: tuple[str, Courses], folder: Path, factor: float
) -> None:
    case, true = reference
    step = factor * system(case).simulation.step_size
    found, network, outcome = course(case, folder, algorithm="implicit", step_size=step)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    times = sorted(t for t in found.keys() & true.keys() if not t % round(2e9 * step))
    assert len(times) > len(found) / 3
    mine, others = (np.array([values[t] for t in times]) for values in (found, true))
    errors, ranges = np.abs(mine - others).max(axis=0), np.ptp(others, axis=0)
    units = [network.unit(port) for _, port in network.monitored_outputs]
    of_unit = {u: max(r for v, r in zip(units, ranges, strict=True) if v == u) for u in units}
    relative = [e / of_unit[u] for e, u in zip(errors, units, strict=True) if of_unit[u] > 0.0]
    error = max(relative)
    stated = outcome.certificate.errors[0].error
    print(f"{case} step {step:g} s: true {error:.2e}, stated {stated:.2e}")
    assert error < 3 * stated + ROUGH.get(case, 0.0)
    assert stated < 3 * error + 1e-5
