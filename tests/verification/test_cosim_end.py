"""FMUs of FMI 2.0 that request the end of the simulation by discarding a step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from netCDF4 import Dataset
from support.small_systems import Fmus

from m4e_fmi.cli import main
from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Outcome,
    Simulation,
    System,
    load,
    run,
    start,
)
from m4e_fmi.results.results_file import Results

ALGORITHMS = ["jacobi", "gauss_seidel", "corrector", "implicit"]


def pair(fmus: Fmus, options: str, when: float, **settings: Any) -> System:
    """A fuse of which y' = 1 + u, and an integral of that y which is fed back: nothing is exact."""
    parts = (
        Component("sum", FmuFile(fmus(f"integrator{options}"))),
        Component("fuse", FmuFile(fmus(f"ending{options}")), {"when": when}),
        Component("after", FmuFile(fmus(f"lag{options}"))),
    )
    links = (
        "fuse.y -> sum.u, units ignored",
        "sum.y -> fuse.u, units ignored",
        "fuse.y -> after.u, units ignored",
    )
    given: dict[str, Any] = {"stop_time": 5.0, "step_size": 0.1, **settings}
    return System("s", parts, links, Simulation(**given))


def results(system: System, path: Path) -> tuple[Outcome, Results]:
    outcome = run(system, results=path)
    return outcome, load(path)


@pytest.mark.verifies(
    "rows of a run that an FMU ends at a communication point",
    independent="the same system with that stop time",
    tolerance="identical",
)
@pytest.mark.usefixtures("loop")
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("interval", [None, 0.4])
def test_the_run_ends_there(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, interval: float | None
) -> None:
    """At a communication point: all rows are those of a run that was to end there."""
    settings: dict[str, Any] = {"algorithm": algorithm, "output_interval": interval}
    outcome, found = results(pair(c_fmu, "+state", 1.0, **settings), tmp_path / "r.nc")
    _, other = results(pair(c_fmu, "+state", 9.0, stop_time=1.0, **settings), tmp_path / "o.nc")
    np.testing.assert_array_equal(found.time, other.time)
    for name in ("fuse.y", "sum.y", "after.y"):
        np.testing.assert_array_equal(found[name].values, other[name].values)
    assert outcome.notes[-1] == "fuse requested the end of the simulation at t = 1 s"
    assert outcome.steps == 10
    assert isinstance(outcome.certificate, CouplingErrorReport)
    with Dataset(tmp_path / "r.nc") as file:
        assert file.ended == "fuse requested the end of the simulation at t = 1 s"


@pytest.mark.verifies(
    "last value of a run that an FMU ends within a step",
    analytic="exact solution, a hyperbolic sine",
    tolerance="2e-3",
)
@pytest.mark.parametrize(
    ("algorithm", "tolerance"),
    [("corrector", None), ("implicit", None), *((name, 1e-4) for name in ALGORITHMS)],
)
def test_an_end_within_a_step_is_met_by_all(
    c_fmu: Fmus, tmp_path: Path, algorithm: str, tolerance: float | None
) -> None:
    system = pair(c_fmu, "+state", 1.0333, algorithm=algorithm, coupling_tolerance=tolerance)
    outcome, found = results(system, tmp_path / "r.nc")
    assert found.time[-1] == pytest.approx(1.0333, abs=1e-9)
    assert "fuse requested the end of the simulation at t = 1.0333 s" in outcome.notes[-1]
    assert found["fuse.y"].values[-1] == pytest.approx(np.sinh(1.0333), rel=2e-3)  # y'' = y


@pytest.mark.parametrize("algorithm", ALGORITHMS[:3])
def test_where_some_cannot_go_back_it_ends_at_the_point_before(
    c_fmu: Fmus, tmp_path: Path, algorithm: str
) -> None:
    outcome, found = results(pair(c_fmu, "", 1.0333, algorithm=algorithm), tmp_path / "r.nc")
    assert found.time[-1] == pytest.approx(1.0)
    assert "fuse requested the end of the simulation at t = 1.0333 s" in outcome.notes[-1]
    outcome, found = results(pair(c_fmu, "", 1.1, algorithm=algorithm), tmp_path / "r.nc")
    assert found.time[-1] == pytest.approx(1.1)


def test_alone_it_ends_where_it_is(c_fmu: Fmus, tmp_path: Path) -> None:
    fuse = Component("fuse", FmuFile(c_fmu("ending")), {"when": 1.0333, "u": 1.0})
    _, found = results(System("s", (fuse,), (), Simulation(5.0, 0.1)), tmp_path / "r.nc")
    assert found.time[-1] == pytest.approx(1.0333, abs=1e-9)
    assert found["fuse.y"].values[-1] == pytest.approx(2 * 1.0333, rel=1e-12)


def test_stepped_by_python(c_fmu: Fmus) -> None:
    with start(pair(c_fmu, "+state", 0.5)) as stepped:
        kept = stepped.save()
        first = [point.time for point in stepped]
        stepped.restore(kept)
        assert not stepped.done
        assert [point.time for point in stepped] == first
    assert first[-1] == pytest.approx(0.5)


def test_the_command_ends_well(
    c_fmu: Fmus, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "s.yaml").write_text(
        f"name: s\ncomponents:\n  fuse: {{fmu: {c_fmu('ending')}, start: {{when: 0.5}}}}\n"
        "simulation: {stop_time: 2, step_size: 0.1}\n"
    )
    assert main(["run", str(tmp_path / "s.yaml"), "--output-file", str(tmp_path / "r.nc")]) == 0
    told = capsys.readouterr()
    assert "fuse requested the end of the simulation at t = 0.5 s" in told.out + told.err
