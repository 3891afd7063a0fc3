"""Coupled systems that grow without bound: the reported output and time, and no false reports."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, system

from m4e_fmi.cosim import Simulation, System, load, run, start
from m4e_fmi.errors import RunError


def failure(given: System, results: Path | None = None) -> RunError:
    with pytest.raises(RunError) as caught:
        run(given, results=results)
    return caught.value


def pair(
    fmus: Fmus, settings: Simulation, first: str = "mass", second: str = "spring", **values: float
) -> System:
    """A unit mass, x(0) = 1 m, on a spring of 1 N/m in another FMU, which has these `values`."""
    parts, begin = {"a": first, "b": second}, {"a": {"body.m.x": 1.0}, "b": values}
    return system(fmus, parts, "a.m <-> b.end", start=begin, simulation=settings)


def test_steps_that_are_too_long(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "r.nc"
    error = failure(pair(c_fmu, Simulation(1e4, 4.0, "gauss_seidel")), results=file)
    assert re.match(r"unstable: a\.body\.m\.\w+ \(output body\.m\.\w+\) is ", error.message)
    assert error.remedy.startswith("try step_size: 1; take algorithm: corrector or implicit")
    results = load(file)
    assert results.time[-1] < 500
    assert f"at t = {results.time[-1]:.9g} s" in error.message
    assert np.isfinite(results["a.body.m.x"].values).all()


def test_jacobi_feeds_energy_in(c_fmu: Fmus) -> None:
    error = failure(pair(c_fmu, Simulation(1e6, 0.5, "jacobi")))
    assert "if neither helps, the system itself is unstable" in error.remedy


def test_an_fmu_that_fails_says_so_itself(c_fmu: Fmus, tmp_path: Path) -> None:
    # the mass flies away at 1 m/s: x = t
    parts = {"a": "mass", "b": "fuse"}
    begin = {"a": {"body.m.vx": 1.0}, "b": {"stiffness": 0.0, "limit": 1e5}}
    settings = Simulation(1e6, 10.0, "gauss_seidel")
    flying = system(c_fmu, parts, "a.m <-> b.end", start=begin, simulation=settings)
    error = failure(flying, results=tmp_path / "r.nc")
    assert error.message.startswith("b (fuse.fmu): the step from t = ")


def rising(fmus: Fmus, stop: float) -> System:
    """y = 1e-9 e^t in both of two integrators."""
    parts, begin = dict.fromkeys(["a", "b"], "integrator+state"), {"y": 1e-9}
    links, settings = ("a.y -> b.u", "b.y -> a.u"), Simulation(stop, 0.05)
    return system(fmus, parts, *links, start={"a": begin, "b": begin}, simulation=settings)


def test_a_run_that_goes_back_forgets_what_grew(c_fmu: Fmus) -> None:
    with start(rising(c_fmu, 60.0)) as stepped:
        first = stepped.save()
        while stepped.time < 50.0:
            stepped.step()
        stepped.restore(first)
        while stepped.time < 10.0:
            stepped.step()
    assert stepped.outcome.warnings == ()


def test_a_limit_cycle_is_no_growth(c_fmu: Fmus) -> None:
    parts, settings = {"a": "van_der_pol", "b": "lag"}, Simulation(100.0, 0.05, "gauss_seidel")
    given = system(c_fmu, parts, "a.x -> b.u", start={"a": {"u": 0.0}}, simulation=settings)
    outcome = run(given)
    assert outcome.steps > 1000
    assert outcome.warnings == ()
