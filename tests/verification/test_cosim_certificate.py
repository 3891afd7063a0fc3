"""The certificate against the true errors of random linear pairs with exact solutions."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from scipy.linalg import expm
from support.half_step import checked
from support.random_systems import random_system
from support.small_systems import Fmus, observed, system
from unit.cosim.network.test_versions import reworded

from m4e_fmi.cosim import (
    Component,
    CouplingErrorReport,
    FmuFile,
    Simulation,
    System,
    prepare,
    run,
    start,
)
from m4e_fmi.cosim.error.estimator import SMOOTH
from m4e_fmi.cosim.error.report import LITTLE
from m4e_fmi.cosim.run.run import RunOptions
from m4e_fmi.cosim.run.running import running
from m4e_fmi.errors import RunError

STOP, STEP = 4.0, 0.05
PORTS = ("a.body.m.x", "a.body.m.vx")


def pair(fmus: Fmus, algorithm: str, rng: np.random.Generator) -> tuple[System, np.ndarray]:
    """Two masses with random springs, dampers and start; the matrix of x1, v1, x2, v2."""
    m, k, d, kp, kc, dc = rng.uniform((0.5, 0, 0, 0.5, 0.2, 0), (2, 4, 0.5, 4, 4, 0.3))
    begin = {
        "a": {"mass": m, "stiffness": k, "damping": d, "body.m.x": 1.0},
        "b": {"stiffness": kp, "coupling": kc, "damping": dc, "x": 0.0},
    }
    parts, settings = {"a": "mass+state", "b": "partner+state"}, Simulation(STOP, STEP, algorithm)
    coupled = system(fmus, parts, "a.m <-> b.end", start=begin, simulation=settings)
    matrix = np.array(
        [
            [0, 1, 0, 0],
            [-(k + kc) / m, -(d + dc) / m, kc / m, dc / m],
            [0, 0, 0, 1],
            [kc, dc, -kp - kc, -dc],
        ]
    )
    return coupled, matrix


def moved(fmus: Fmus, other: str, settings: Simulation, first: str = "mass+state") -> System:
    """A mass, x(0) = 1 m, and another FMU."""
    parts, begin = {"a": first, "b": other}, {"a": {"body.m.x": 1.0}}
    return system(fmus, parts, "a.m <-> b.end", start=begin, simulation=settings)


@pytest.mark.verifies(
    "coupling error of random pairs by a second run at half the step, over or under the true one "
    "by at most a factor",
    analytic="matrix exponential",
    tolerance="1.5",
)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_a_second_run_states_the_true_error(c_fmu: Fmus, algorithm: str) -> None:
    rng = np.random.default_rng(7)
    ratios = []
    for _ in range(3):
        coupled, matrix = pair(c_fmu, algorithm, rng)
        (stated,) = checked(coupled)[1].errors
        rows, _ = observed(coupled, *PORTS, "b.end.force_x")
        t, *found = np.array(rows).T
        states = np.array([expm(time * matrix)[:, 0] for time in t])
        given = coupled.components[0].start
        m, k, d = (float(str(given[name])) for name in ("mass", "stiffness", "damping"))
        force = m * (states @ matrix[1]) + k * states[:, 0] + d * states[:, 1]
        exact = np.column_stack((states[:, :2], force))
        errors = np.abs(np.transpose(found) - exact).max(axis=0) / np.ptp(exact, axis=0)
        ratios.append(errors.max() / stated.error)
    # where the next order counts, the estimate is off by a part of itself
    assert max(ratios) < 1.5
    assert min(ratios) > 0.5


@pytest.mark.verifies(
    "coupling error that every run states, chains of 2 to 4 random components: true error at most",
    analytic="matrix exponential",
    tolerance="3",
)
@pytest.mark.verifies(
    "coupling error that every run states for FMUs without rollback, chains of 2 to 4 random "
    "components: true error at most",
    analytic="matrix exponential",
    tolerance="3",
)
@pytest.mark.parametrize(
    ("algorithm", "rigid", "steps", "count"),
    [
        ("corrector", "none", (40, 250), 8),
        ("gauss_seidel", "none", (40, 250), 6),
        ("implicit", "none", (40, 250), 3),
        ("jacobi", "none", (40, 250), 6),
        # which have companions
        ("corrector", "some", (40, 250), 6),
        ("gauss_seidel", "all", (40, 250), 6),
        ("gauss_seidel", "some", (700, 1000), 6),
        ("jacobi", "all", (700, 1000), 6),
    ],
)
def test_every_run_states_its_error(
    c_fmu: Fmus,
    algorithm: str,
    rigid: Literal["none", "some", "all"],
    steps: tuple[int, int],
    count: int,
) -> None:
    rng = np.random.default_rng(11 if rigid == "none" else 12)
    chains = [random_system(c_fmu, algorithm, rng, steps=steps, rigid=rigid) for _ in range(count)]
    true, stated = np.array([chain.true_and_stated() for chain in chains]).T
    assert (true / stated).max() < 3
    assert np.median(stated / true) < 10


@pytest.mark.parametrize("algorithm", ["corrector", "gauss_seidel"])
def test_a_long_run_is_judged_by_its_windows(c_fmu: Fmus, algorithm: str) -> None:
    # an eighth of the later steps is made twice: the rest may hide a factor of 3 more
    rng = np.random.default_rng(3)
    for _ in range(2):
        true, stated = random_system(c_fmu, algorithm, rng, steps=(700, 1000)).true_and_stated()
        assert true / 9 < stated < 30 * true


@pytest.mark.parametrize("algorithm", ["corrector", "gauss_seidel"])
@pytest.mark.parametrize(
    ("other", "stop"),
    [("partner+state", 15.0), *(("partner+once", stop) for stop in (2.0, 2.1, 2.07))],
)
def test_the_run_itself_is_not_touched(
    c_fmu: Fmus, algorithm: str, other: str, stop: float
) -> None:
    """Two steps of the run are one of the companion of FMUs without rollback, but for the last."""
    prepared = prepare(moved(c_fmu, other, Simulation(stop, 0.1, algorithm)))
    names = (*PORTS, "b.end.force_x")
    courses: list[list[float]] = []
    for certify in (True, False):
        course: list[float] = []
        observer = lambda _, net, c=course: c.extend(map(net.read, names))  # noqa: E731
        with running(prepared, RunOptions(certify=certify, observers=[observer])) as made:
            made.finish()
        courses.append(course)
    assert courses[0] == courses[1]


@pytest.mark.verifies(
    "coupling error of runs with values set between steps, or with rollback: true error at most",
    analytic="matrix exponential",
    tolerance="3",
)
@pytest.mark.parametrize(
    ("algorithm", "rigid", "share", "detour"),
    [
        ("corrector", "none", 1.0, 0),
        ("corrector", "none", 0.02, 7),
        ("gauss_seidel", "none", 0.1, 0),
        ("gauss_seidel", "none", 0.0, 30),
        ("jacobi", "all", 0.1, 0),
        ("corrector", "some", 1.0, 0),
    ],
)
def test_values_set_between_steps_are_followed(
    c_fmu: Fmus, algorithm: str, rigid: Literal["none", "some", "all"], share: float, detour: int
) -> None:
    rng = np.random.default_rng(13)
    found = []
    for _ in range(4):
        chain = random_system(c_fmu, algorithm, rng, steps=(40, 400), rigid=rigid)
        given = float(str(chain.system.components[0].start["damping"]))
        changes = np.flatnonzero(rng.uniform(size=400) < share)
        dampings = {int(k): given * rng.uniform(0.5, 2.0) + 0.01 for k in changes}
        found.append(chain.true_and_stated_when_set(dampings, detour=detour))
    true, stated = np.array(found).T
    assert (true / stated).max() < 3
    assert np.median(stated / true) < 10


def test_where_there_can_be_no_second_set(c_fmu: Fmus) -> None:
    outcome = run(moved(c_fmu, "spring+alone", Simulation(1.0, 0.1)))
    assert outcome.steps == 10
    assert str(outcome.certificate).startswith(
        "b cannot roll back (canGetAndSetFMUstate), a second set of FMUs fails (b ("
    )


def beside_a_rogue(fmus: Fmus, state: str, settings: Simulation, **begin: float) -> System:
    parts = {"a": f"rogue{state}", "b": f"stage{state}"}
    return system(fmus, parts, "a.y -> b.u", start={"a": begin}, simulation=settings)


@pytest.mark.parametrize("state", ["", "+state"])
def test_where_longer_steps_fail_the_run_goes_on(c_fmu: Fmus, state: str) -> None:
    # its steps are halves of 0.05 s; it discards those longer than 0.06 s
    rows, outcome = observed(
        beside_a_rogue(c_fmu, state, Simulation(40.0, 0.1), what=5.0, when=0.06)
    )
    assert rows[-1] == [40.0]
    if state:  # then it is compared with shorter ones
        assert isinstance(outcome.certificate, CouplingErrorReport)
    else:
        assert str(outcome.certificate).startswith("steps of twice the length fail (a")


def test_where_longer_steps_grow_without_bound_shorter_ones_tell(c_fmu: Fmus) -> None:
    coupled, matrix = pair(c_fmu, "gauss_seidel", np.random.default_rng(0))
    step = round(1.5 / np.abs(np.linalg.eigvals(matrix)).max(), 3)
    rows, outcome = observed(coupled.changed(stop_time=60 * step, step_size=step), *PORTS)
    _, *found = np.array(rows).T
    exact = np.array([expm(k * step * matrix)[:2, 0] for k in range(len(rows))])
    true = (np.abs(np.transpose(found) - exact).max(axis=0) / np.ptp(exact, axis=0)).max()
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert true / 3 < outcome.certificate.errors[0].error < 5 * true


@pytest.mark.parametrize("state", ["", "+state"])
def test_where_longer_steps_are_fatal_the_results_are_there(c_fmu: Fmus, state: str) -> None:
    settings = Simulation(4.0, 0.1, "gauss_seidel")
    coupled = beside_a_rogue(c_fmu, state, settings, what=6.0, when=0.15)
    outcome = run(coupled)
    assert outcome.steps == 40
    assert "steps of twice the length fail (a" in str(outcome.certificate)
    if state:  # within the run it cannot be made good
        with pytest.raises(RunError, match="should discard a step that it cannot make"):
            run(coupled.changed(stop_time=250.0))


def test_a_second_set_that_failed_is_not_called_again(c_fmu: Fmus) -> None:
    settings = Simulation(1.0, 0.01, "gauss_seidel")
    with start(moved(c_fmu, "partner+hundredth", settings, "mass")) as run:
        for _ in run:
            run["a.damping"] = run["b.damping"] = 0.2
    assert run.outcome.steps == 100
    assert str(run.outcome.certificate).startswith("steps of half the length fail (b (")


@pytest.mark.parametrize("is_observed", [False, True])
@pytest.mark.parametrize("when", [0.02, 0.47, 0.92])
def test_a_step_that_is_cut_short_within_a_window(
    c_fmu: Fmus, when: float, *, is_observed: bool
) -> None:
    parts = {"a": "mass+state", "b": "partner+state", "c": "rogue+state"}
    begin = {"a": {"stiffness": 1.0, "body.m.x": 1.0}, "c": {"what": 1.0, "when": when}}
    settings = Simulation(1.0, 0.05)
    coupled = system(c_fmu, parts, "a.m <-> b.end", start=begin, simulation=settings)
    times: list[float] = []
    observers = [lambda t, _: times.append(t)] if is_observed else []
    outcome = run(coupled, observers=observers)
    assert (outcome.steps, outcome.rejected) == (21, 1)
    assert isinstance(outcome.certificate, CouplingErrorReport)
    assert not is_observed or any(abs(t - when) < 1e-9 for t in times)


@pytest.mark.parametrize("steps", [1, 2, 255, 256, 257, 258, 288, 289, 513])
def test_every_number_of_steps_is_judged(c_fmu: Fmus, steps: int) -> None:
    for options in ("+state", "+state+constant", ""):
        settings = Simulation(steps * 0.05, 0.05)
        certificate = run(moved(c_fmu, f"partner{options}", settings)).certificate
        if steps == 1 and "constant" in options:
            assert certificate == "the run has only one step"
        else:
            assert isinstance(certificate, CouplingErrorReport)


@pytest.mark.parametrize("algorithm", ["corrector", "gauss_seidel", "implicit"])
@pytest.mark.parametrize("own", ["25 ms", "12.5 ms"])
def test_own_steps_are_halved_too(c_fmu: Fmus, algorithm: str, own: str) -> None:
    """All ways of telling the error agree: twice the step, half of it, and a second run."""
    a = Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0}, step_size=own)
    b = Component("b", FmuFile(c_fmu("partner+state")), step_size=own)
    coupled = System("s", (a, b), ("a.m <-> b.end",), Simulation(4.0, 0.05, algorithm))
    outcome, second = checked(coupled)
    stated = [outcome.certificate, second]
    errors = [one.errors[0].error for one in stated if isinstance(one, CouplingErrorReport)]
    order = outcome.order
    taken = min(order, SMOOTH)
    assert 0.4 < errors[1] / errors[0] < 1.5
    short = coupled.changed(stop_time=0.2)  # all of which may be made again at half the step
    with start(short) as stepped:
        for _ in stepped:
            stepped["a.damping"] = 0.0
    stated = [checked(short)[1], stepped.outcome.certificate]
    errors = [one.errors[0].error for one in stated if isinstance(one, CouplingErrorReport)]
    errors[1] *= (1 - 2.0**-taken) / (1 - 2.0**-order)
    # of the range of the course at H/2, and of that at H
    assert errors[0] == pytest.approx(errors[1], rel=1e-2)


def test_where_half_the_step_does_not_help_the_line_says_so(c_fmu: Fmus) -> None:
    """A relay that switches at the ends of steps is off by all of its jump, whatever the step."""
    parts = {"lag": "lag+state", "relay": "relay+state"}
    links = ("lag.y -> relay.u", "relay.y -> lag.u")
    errors = []
    for step in (0.1, 0.05, 0.025):
        loop = system(c_fmu, parts, *links, simulation=Simulation(20.0, step))
        certificate = run(loop).certificate
        assert isinstance(certificate, CouplingErrorReport)
        worst = certificate.errors[0]
        assert "half the step would help little" in str(certificate)
        assert not worst.falls
        errors.append(worst.error)
    assert min(errors[1:]) > LITTLE * errors[0]


def test_adaptive_steps_are_checked_at_an_eighth_of_the_tolerance(c_fmu: Fmus) -> None:
    coupled, matrix = pair(c_fmu, "corrector", np.random.default_rng(2))
    adaptive = coupled.changed(step_size=0.5, output_interval=0.5, coupling_tolerance=1e-4)
    rows, _ = observed(adaptive, PORTS[0])
    outcome, second = checked(adaptive)
    found = dict(rows)
    times = np.arange(0, 9) * 0.5
    exact = np.array([expm(t * matrix)[0, 0] for t in times])
    true = np.abs([found[t] for t in times] - exact).max() / np.ptp(exact)
    assert true < 3 * second.errors[0].error
    assert second.errors[0].error < 1e-2
    # the run's own estimate, too
    assert not isinstance(outcome.certificate, str)
    assert true / 3 < outcome.certificate.errors[0].error < 1e-2


@pytest.mark.parametrize("options", ["+state", ""])
def test_errors_in_what_nobody_takes_are_stated(c_fmu: Fmus, options: str) -> None:
    # y' = 1 without error, z' = y with y held: z = t²/2 - t H/2 instead of t²/2
    parts = dict.fromkeys(["a", "b"], f"integrator{options}")
    settings = Simulation(STOP, STEP, "jacobi")
    outcome = run(system(c_fmu, parts, "a.y -> b.u", start={"a": {"u": 1.0}}, simulation=settings))
    assert isinstance(outcome.certificate, CouplingErrorReport)
    (error,) = outcome.certificate.errors
    assert str(error.source) == "b.y"
    assert error.error == pytest.approx(STEP * STOP / 2 / (STOP**2 / 2 - STOP * STEP / 2), rel=1e-9)


def test_outputs_without_a_unit_have_ranges_of_their_own(c_fmu: Fmus, tmp_path: Path) -> None:
    """Two rings of one kind, one a million times as large: a unit shared is a range shared."""
    bare = FmuFile(reworded(c_fmu("integrator"), tmp_path / "bare.fmu", ' unit="1"', ""))
    shares = {}
    for fmu in (bare, FmuFile(c_fmu("integrator"))):
        parts = [
            Component(f"{name}{k}", fmu, {"y": start * size, "gain": gain})
            for k, size in enumerate((1.0, 1e6))
            for name, start, gain in (("a", 1.0, 1.0), ("b", 0.0, -1.0))
        ]
        links = [line for k in "01" for line in (f"a{k}.y -> b{k}.u", f"b{k}.y -> a{k}.u")]
        outcome = run(
            System("s", tuple(parts), tuple(links), Simulation(5.0, 0.05, "gauss_seidel"))
        )
        assert isinstance(outcome.certificate, CouplingErrorReport)
        found = {str(one.source): one.error for one in outcome.certificate.errors}
        shares[fmu is bare] = found["a0.y"] / found["a1.y"]
    assert shares[True] == pytest.approx(1.0)
    assert shares[False] == pytest.approx(1e-6)
