"""FMUs that say they can go back, but whose saved states lack a part."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.small_systems import Fmus, observed, system, watched

from m4e_fmi.cosim import Simulation, System, prepare, run
from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.preparation.state_trials import _different
from m4e_fmi.cosim.system.start_values import Value


def metered(fmus: Fmus, meter: str, algorithm: str = "jacobi") -> System:
    """An oscillator of a mass and a spring, and a meter of y' = 2 v: y = 2 x."""
    names = {"mass": "mass+state", "spring": "spring+state", "meter": meter}
    start = {"mass": {"body.m.x": 1.0}, "meter": {"gain": 2.0, "y": 2.0}}
    links = ("mass.m <-> spring.end", "mass.body.m.vx -> meter.u, units ignored")
    settings = Simulation(6.0, 0.02, algorithm)
    return system(fmus, names, *links, start=start, simulation=settings)


@pytest.mark.parametrize("version", ["", "3:"])
@pytest.mark.parametrize("algorithm", ["jacobi", "corrector"])
def test_one_that_forgets_runs_as_one_that_cannot_go_back(
    c_fmu: Fmus, version: str, algorithm: str
) -> None:
    right = watched(metered(c_fmu, f"{version}integrator", algorithm), "meter.y")
    forgetful = metered(c_fmu, f"{version}integrator+state+forgets", algorithm)
    values, outcome = observed(forgetful, "meter.y")
    assert [row[1:] for row in values] == right
    assert isinstance(outcome.certificate, CouplingErrorReport)
    (warning,) = (text for text in outcome.warnings if "rollback" in text)
    assert warning.startswith("meter: integrator_state_forgets")
    assert "steps repeated after rollback give another y" in warning
    assert "m4e-fmi validate integrator_state_forgets" in warning


def test_outputs_of_type_binary_are_passed_over(c_fmu: Fmus, tmp_path: Path) -> None:
    """`echo` is Binary: a state is tried, and values are recorded, without it."""
    given = system(c_fmu, {"g": "3:gallery+state"}, start={"g": {"word": "four"}})
    found = prepare(given)
    assert found.descriptions["g"].variables["echo"].type == "Binary"
    assert found.descriptions["g"].saves_state
    recorded = run(given, results=tmp_path / "r.nc").results().components["g"]
    assert recorded["sum"].values.tolist() == [4.0] * 11
    assert "echo" not in recorded


def test_a_state_that_is_refused_is_told_before_the_run(c_fmu: Fmus) -> None:
    prepared = prepare(metered(c_fmu, "integrator+claims"))
    (warning,) = (text for text in prepared.warnings if "rollback" in text)
    assert "its state cannot be saved" in warning
    assert "fmi2GetFMUstate answered Error" in warning


def test_states_that_no_other_instance_can_take_are_not_saved(c_fmu: Fmus, tmp_path: Path) -> None:
    """An FMU that crashes in fmi2DeSerializeFMUstate is found before the run."""
    names = {"body": "mass+state+bytes", "spring": "spring+state+bytes+unreadable"}
    start, settings = {"body": {"body.m.x": 1.0}}, Simulation(2.0, 0.02)
    given = system(c_fmu, names, "body.m <-> spring.end", start=start, simulation=settings)
    parts = tuple(replace(part, process="own") for part in given.components)
    given = replace(given, components=parts)
    assert not prepare(given).warnings
    saving = given.changed(checkpoint_interval=0.5)
    (warning,) = prepare(saving).warnings
    assert warning.startswith("spring: spring_state_bytes_unreadable")
    assert "its process was ended by SIGSEGV in fmi2DeSerializeFMUstate" in warning
    told: list[str] = []
    run(saving, results=tmp_path / "r.nc", warn=told.append)
    assert any("spring cannot save states for another process" in line for line in told)


def test_what_solvers_that_begin_anew_and_clocks_do_is_no_fault() -> None:
    """A course that went on may be off by a tolerance; those after a return are the same."""
    on: list[list[Value]] = [[300.0], [300.2]]
    anew: list[list[Value]] = [[300.0], [300.201]]
    assert _different(["T"], on, anew, anew) == set()
    assert _different(["T"], on, anew, [[300.1], [300.4]]) == {"T"}
    assert _different(["y"], [[1.0], [2.0]], [[3.0], [4.0]], [[3.0], [4.0]]) == {"y"}
    assert _different(["n"], [[1], [2]], [[1], [2]], [[1], [2]]) == set()
    assert _different(["n"], [[1], [2]], [[3], [4]], [[5], [6]]) == {"n"}
