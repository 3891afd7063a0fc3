"""Coupled systems that grow without bound: the reported output and time, and no false reports."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.small_systems import Fmus, system

from m4e_fmi.cosim import Simulation, System, load, run, start
from m4e_fmi.cosim.monitoring.instability import Instability
from m4e_fmi.errors import RunError


def failure(given: System, results: Path | None = None) -> RunError:
    with pytest.raises(RunError) as caught:
        run(given, results=results)
    return caught.value


def times_of(message: str) -> tuple[float, float, float]:
    """Since when, until when, and the time for a factor of ten, in the words of a message."""
    found = re.search(r" at t = (\S+) s to .* at t = (\S+) s, tenfold every (\S+) s", message)
    assert found, message
    since, until, tenfold = map(float, found.groups())
    return since, until, tenfold


def pair(
    fmus: Fmus, settings: Simulation, first: str = "mass", second: str = "spring", **values: float
) -> System:
    """A unit mass, x(0) = 1 m, on a spring of 1 N/m in another FMU, which has these `values`."""
    parts, begin = {"a": first, "b": second}, {"a": {"body.m.x": 1.0}, "b": values}
    return system(fmus, parts, "a.m <-> b.end", start=begin, simulation=settings)


def test_steps_that_are_too_long(c_fmu: Fmus, tmp_path: Path) -> None:
    file = tmp_path / "r.nc"
    error = failure(pair(c_fmu, Simulation(1e4, 4.0, "gauss_seidel")), results=file)
    assert re.match(r"unstable: a\.body\.m\.\w+ \(output body\.m\.\w+\) grew from ", error.message)
    assert error.remedy.startswith("try step_size: 1; take algorithm: corrector or implicit")
    since, until, tenfold = times_of(error.message)
    # the largest root of the recursion there
    assert since <= 16.0
    assert until < 500
    results = load(file)
    assert results.time[-1] == pytest.approx(until, abs=1e-3)  # as many digits as are told
    x = results["a.body.m.x"].values
    assert np.isfinite(x).all()
    last = np.abs(x[-10:])
    steps = np.log10(last[-1] / last[0]) / 9
    assert tenfold == pytest.approx(4.0 / steps, rel=0.2)


def test_jacobi_feeds_energy_in(c_fmu: Fmus) -> None:
    error = failure(pair(c_fmu, Simulation(1e6, 0.5, "jacobi")))
    _, _, tenfold = times_of(error.message)
    # a held force makes x grow by (ωH)²/4 a step, to the next order in (ωH)²
    assert tenfold == pytest.approx(0.5 * np.log(10) / (0.5**2 / 4), rel=0.1)
    assert "if half the step_size leaves it as it is, the system itself is unstable" in error.remedy


def test_an_fmu_that_fails_by_itself_after_something_grew(
    c_fmu: Fmus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Simulation(1e4, 1.0, "gauss_seidel")
    fused = pair(c_fmu, settings, second="fuse", stiffness=40.0)
    for file in (None, tmp_path / "r.nc"):
        if file:  # no look falls into the growth: the rows tell
            monkeypatch.setattr(Instability, "look", lambda *_: None)
        error = failure(fused, file)
        assert error.message.startswith("unstable: a.body.m.")
        assert "; then b (fuse.fmu): the step from t = " in error.message
        assert "the fuse has blown" in error.message
        assert "try step_size: 0.25" in error.remedy


def test_an_fmu_that_fails_where_nothing_grew(c_fmu: Fmus, tmp_path: Path) -> None:
    # the mass flies away at 1 m/s: x = t
    parts = {"a": "mass", "b": "fuse"}
    begin = {"a": {"body.m.vx": 1.0}, "b": {"stiffness": 0.0, "limit": 1e5}}
    settings = Simulation(1e6, 10.0, "gauss_seidel")
    flying = system(c_fmu, parts, "a.m <-> b.end", start=begin, simulation=settings)
    error = failure(flying, results=tmp_path / "r.nc")
    assert error.message.startswith("b (fuse.fmu): the step from t = ")


def test_an_added_mass_that_is_exchanged_as_a_force(c_fmu: Fmus) -> None:
    settings = Simulation(100.0, 0.01, "jacobi")
    error = failure(pair(c_fmu, settings, second="late_added_mass", added=3.0))
    assert "a.body.m.ax -> b.end.ax carries an acceleration" in error.remedy
    assert "added_mass: true" in error.remedy


def rising(fmus: Fmus, stop: float) -> System:
    """y = 1e-9 e^t in both of two integrators."""
    parts, begin = dict.fromkeys(["a", "b"], "integrator+state"), {"y": 1e-9}
    links, settings = ("a.y -> b.u", "b.y -> a.u"), Simulation(stop, 0.05)
    return system(fmus, parts, *links, start={"a": begin, "b": begin}, simulation=settings)


def test_growth_that_is_not_large_yet_is_no_matter(c_fmu: Fmus) -> None:
    assert run(rising(c_fmu, 20.0)).warnings == ()  # 0.5


@pytest.mark.verifies(
    "time for a factor of ten that the warning of a growing system states",
    analytic="exact solution, an exponential",
    tolerance="0.02",
)
def test_growth_at_the_end_of_a_run_is_told(c_fmu: Fmus) -> None:
    (warning,) = run(rising(c_fmu, 45.0)).warnings  # 3.5e10
    assert (
        "this seems to be unstable; the steps are not the cause, as the coupling error" in warning
    )
    assert "the model itself grows: look at the signs" in warning
    assert "step_size" not in warning
    _, _, tenfold = times_of(warning)
    assert tenfold == pytest.approx(np.log(10), rel=0.02)


def test_growth_that_ends_a_run_is_not_blamed_on_small_errors(c_fmu: Fmus) -> None:
    error = failure(rising(c_fmu, 90.0))
    stated = re.search(
        r"the coupling error is (\S+) of range: the model itself grows", error.remedy
    )
    assert stated
    # y at H and 2H of the exact exponential: the third-order error of 0.05 s steps over 69 s
    assert 1e-8 < float(stated[1]) < 1e-3
    assert "step_size" not in error.remedy


def test_growth_before_an_fmu_fails_is_not_blamed_on_small_errors(
    c_fmu: Fmus, tmp_path: Path
) -> None:
    # x'' = x: a spring that pushes away
    settings = Simulation(100.0, 0.01, "gauss_seidel")
    pushed = pair(c_fmu, settings, "mass+state", "fuse", stiffness=-1.0, limit=1e9)
    error = failure(pushed, results=tmp_path / "r.nc")
    assert error.message.startswith("unstable: a.body.m.")
    assert "the model itself grows" in error.remedy
    assert "step_size" not in error.remedy


def test_a_run_that_goes_back_forgets_what_grew(c_fmu: Fmus) -> None:
    with start(rising(c_fmu, 60.0)) as stepped:
        first = stepped.save()
        while stepped.time < 50.0:
            stepped.step()
        stepped.restore(first)
        while stepped.time < 10.0:
            stepped.step()
    assert stepped.outcome.warnings == ()


def far(fmus: Fmus) -> System:
    """u = 1 (start), y = 1e12 t, z = 1e12 t²/2 to t = 1e6 s: 5e23, far beyond any size."""
    parts = dict.fromkeys(["a", "b", "c"], "integrator")
    begin = {"a": {"u": 1.0, "gain": 1e12}, "c": {"gain": 1e-30}}
    links, settings = ("a.y -> b.u", "b.y -> c.u"), Simulation(1e6, 100.0, "gauss_seidel")
    return system(fmus, parts, *links, start=begin, simulation=settings)


def limit_cycle(fmus: Fmus) -> System:
    parts, settings = {"a": "van_der_pol", "b": "lag"}, Simulation(100.0, 0.05, "gauss_seidel")
    return system(fmus, parts, "a.x -> b.u", start={"a": {"u": 0.0}}, simulation=settings)


@pytest.mark.parametrize("make", [far, limit_cycle])
def test_what_becomes_large_by_its_nature(make: Callable[[Fmus], System], c_fmu: Fmus) -> None:
    outcome = run(make(c_fmu))
    assert outcome.steps > 1000
    assert outcome.warnings == ()


def test_a_step_that_is_discarded_after_growth_ends_the_run(c_fmu: Fmus) -> None:
    """Shorter ones are not tried: e^(20 t) is 5e8 at 1 s."""
    settings = Simulation(2.0, 0.01, "corrector")
    growing = pair(c_fmu, settings, "mass+state", "spring+state", stiffness=-400.0, damping=0.0)
    begin = {"pump": {"what": 2.0, "when": 1.0}}
    (pump,) = system(c_fmu, {"pump": "rogue+state"}, start=begin).components
    error = failure(replace(growing, components=(*growing.components, pump)))
    assert re.match(r"unstable: a\.body\.m\.\w+ .* grew from .*; then pump ", error.message)
    assert "the pump ran dry" in error.message
    assert "down to" not in error.message
