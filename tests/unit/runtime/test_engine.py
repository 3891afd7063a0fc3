"""The engine: evaluations, compiled kernels, runs, events, failures, ensembles."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest
from support.runtime_programs import (
    chain,
    every_fusion,
    every_operation,
    exact,
    waves,
)

from m4e_fmi.errors import InputError
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.program.binary_form import OPERATIONS
from m4e_fmi.program.functions import log, sqrt
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime.engine import (
    BLOCKS,
    DONE,
    EVENT,
    MANY_EVENTS,
    NOT_FINITE,
    SMALL_STEP,
    Control,
    Engine,
    Integrator,
    Watch,
    ensemble,
)
from m4e_fmi.runtime.kernel import SEVERAL

PROGRAMS = [chain(1), chain(7), every_operation(), every_fusion(), waves()]


def _plain(program: Program, t: float, x: np.ndarray) -> tuple[list[float], list[float]]:
    form = load_python(program)
    p = [v.start for v in program.parameters]
    u = [v.start for v in program.inputs]
    c = form.constants(p)
    state = x.tolist()
    return form.rates(t, state, u, p, c), form.outputs(t, state, u, p, c)


def _points(program: Program, count: int) -> np.ndarray:
    start = np.array([v.start for v in program.states])
    return start + np.random.default_rng(2).uniform(-0.25, 0.25, (count, start.size))


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda p: p.name)
def test_the_interpreter_agrees_with_plain_python(program: Program) -> None:
    engine = Engine(program)
    for x in _points(program, 20):
        rates, outputs = _plain(program, 0.4, x)
        # only sine and cosine differ, by an ulp each; 1e-13 leaves room for cancellation after them
        np.testing.assert_allclose(engine.rates(0.4, x), rates, rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(engine.outputs(0.4, x), outputs, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda p: p.name)
def test_compiled_kernels_give_the_interpreters_bits(program: Program) -> None:
    interpreted, compiled = Engine(program), Engine(program)
    assert compiled.compile()
    for x in _points(program, 50):
        np.testing.assert_array_equal(interpreted.rates(0.4, x), compiled.rates(0.4, x))
        np.testing.assert_array_equal(interpreted.outputs(0.4, x), compiled.outputs(0.4, x))


def test_operations_that_share_an_instruction_are_rounded_each_by_itself() -> None:
    program = every_fusion()
    engine = Engine(program)
    block = engine.library.m4e_model_block(engine.handle, BLOCKS["outputs"]).contents
    words = ctypes.cast(block.code, ctypes.POINTER(ctypes.c_uint32))
    codes = {words[4 * k] & 255 for k in range(block.length)}
    assert codes >= set(range(len(OPERATIONS), len(OPERATIONS) + len(SEVERAL)))
    points = _points(program, 20)
    for x in points:
        np.testing.assert_array_equal(engine.outputs(0.0, x), _plain(program, 0.0, x)[1])
    for run, x in zip(
        ensemble(program, [0.0], parameters=np.zeros((20, 0)), states=points), points, strict=True
    ):
        np.testing.assert_array_equal(run.outputs, [engine.outputs(0.0, x)])


@pytest.mark.parametrize("method", ["rk45", "dop853", "rodas", "rk4"])
def test_runs_repeat_to_the_bit_interpreted_or_compiled_in_one_call_or_many(method: str) -> None:
    program, times = chain(3), np.linspace(0.0, 2.0, 101)
    control = Control(method)
    first = Engine(program).simulate(times, control=control)
    compiled = Engine(program)
    assert compiled.compile()
    np.testing.assert_array_equal(first.states, compiled.simulate(times, control=control).states)
    integrator = Integrator(Engine(program), control)
    integrator.start(0.0, np.zeros(6))
    parts = [integrator.advance(part, bound=2.0) for part in np.array_split(times, 7)]
    np.testing.assert_array_equal(first.states, np.concatenate(parts))
    assert integrator.report.evaluations == first.evaluations


def test_fixed_steps() -> None:
    """The fewest equal ones to the next output time, of four evaluations each; no tolerance."""
    program, times = chain(2), np.linspace(0.0, 1.0, 11)
    for longest, steps in ((np.inf, 1), (0.1, 1), (0.0999, 2), (0.02, 5), (0.019, 6)):
        loose, tight = (
            Engine(program).simulate(times, control=Control("rk4", t, t, max_step=longest))
            for t in (1e-2, 1e-12)
        )
        assert (loose.accepted, loose.rejected) == (10 * steps, 0)
        assert loose.evaluations == 40 * steps
        np.testing.assert_array_equal(loose.states, tight.states)


def test_the_step_size_survives_a_restart() -> None:
    """As in a co-simulation: restarted every 10 ms, steps of 10 ms each, no start-up."""
    program = chain(2)
    whole = Engine(program).simulate(np.linspace(0.0, 1.0, 101))
    integrator = Integrator(Engine(program))
    x, step, evaluations = np.zeros(4), 0.0, 0
    for k in range(100):
        integrator.start(k / 100, x, step=step)
        x = integrator.advance([(k + 1) / 100], bound=(k + 1) / 100)[-1]
        step = integrator.report.step
        evaluations += integrator.report.evaluations
        assert step >= 0.01 or k == 0
    # 12 evaluations and one of the rates at the start each; some more while the step size grows
    assert evaluations < 100 * 13 + 50
    # both within some local errors of 1e-8 of the solution
    np.testing.assert_allclose(x, whole.states[-1], atol=1e-6)


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("method", ["rk45", "dop853", "rk4"])
def test_every_model_of_an_ensemble_is_the_single_run_to_the_bit(
    method: str, compiled: bool
) -> None:
    program, times = every_operation(), np.linspace(0.0, 3.0, 31)
    count = 21  # more than two fillings of the lanes, the last one not full
    states = np.linspace(0.1, 0.9, count)[:, None]
    parameters = np.linspace(0.5, 30.0, count)[:, None]  # so that lanes end at different times
    control = Control(method, 1e-7, 1e-7)
    runs = ensemble(
        program, times, parameters=parameters, states=states, control=control, compiled=compiled
    )
    engine = Engine(program)
    for k, run in enumerate(runs):
        engine.set_parameters(parameters[k])
        single = engine.simulate(times, states=states[k], control=control)
        assert (run.status, run.evaluations) == (DONE, single.evaluations)
        np.testing.assert_array_equal(run.states, single.states)
        np.testing.assert_array_equal(run.outputs, single.outputs)


def test_one_failing_model_does_not_disturb_its_ensemble() -> None:
    program, times = exact(), np.linspace(0.0, 1.0, 5)
    states = np.ones((9, 2))
    states[4] = (1.0, -2.0)  # y' = −y² blows up at t = 0.5
    runs = ensemble(program, times, parameters=np.empty((9, 0)), states=states)
    good = Engine(program).simulate(times)
    assert [run.status == DONE for run in runs] == [k != 4 for k in range(9)]
    for k in {*range(9)} - {4}:
        np.testing.assert_array_equal(runs[k].states, good.states)
    assert runs[4].stopped_at == pytest.approx(0.5, abs=1e-3)


def _ball() -> Program:
    recorder = Recorder("ball", "falling ball")
    height = recorder.state(Variable("height", "m", "above the ground", start=1.0))
    speed = recorder.state(Variable("speed", "m/s", "upwards", start=2.0))
    recorder.rate("height", speed)
    recorder.rate("speed", recorder.tape.constant(-10.0))
    recorder.output(Variable("gap", "m", "to the ground"), height)
    recorder.output(Variable("climb", "m/s", "upwards"), speed)
    return recorder.program()


@pytest.mark.parametrize("method", ["rk45", "dop853", "rodas", "rk4"])
def test_events_are_located_and_a_terminal_one_ends_the_run(method: str) -> None:
    watches = [Watch("gap", -1, terminal=True), Watch("climb")]
    run = Engine(_ball(), watches=watches).simulate(
        np.linspace(0.0, 5.0, 51), control=Control(method)
    )
    hit = 0.2 + np.sqrt(0.24)  # 1 + 2 t − 5 t² = 0; highest at t = 0.2 s
    assert (run.status, list(run.event_index)) == (EVENT, [1, 0])
    # the equations are integrated without error: what is left is rounding of time and state
    np.testing.assert_allclose(run.event_time, [0.2, hit], atol=2e-14)
    np.testing.assert_allclose(run.event_states[1], [0.0, 2 - 10 * hit], atol=1e-13)
    assert run.event_states[1][0] <= 0.0  # the far side of the crossing
    assert run.time[-1] == pytest.approx(0.6)
    assert run.stopped_at == run.event_time[-1]


def test_events_by_direction_and_more_than_there_is_room_for() -> None:
    for direction, count in ((1, 1), (-1, 0), (0, 1)):
        run = Engine(exact(), watches=[Watch("late", direction)]).simulate([0.0, 1.0])
        assert run.event_time.size == count
    assert run.event_time[0] == pytest.approx(0.5, rel=1e-14)
    recorder = Recorder("wave", "oscillator")
    x = recorder.state(Variable("x", "1", "position"))
    y = recorder.state(Variable("y", "1", "velocity", start=1.0))
    recorder.rate("x", y)
    recorder.rate("y", -x)
    recorder.output(Variable("y.out", "1", "velocity"), y)
    engine = Engine(recorder.program(), watches=[Watch("y.out")])
    run = engine.simulate([0.0, 100.0], most_events=3)
    assert run.status == MANY_EVENTS
    np.testing.assert_allclose(run.event_time, np.pi * np.array([0.5, 1.5, 2.5]), atol=1e-6)


def _one_state(rate) -> Program:
    recorder = Recorder("one", "one state")
    x = recorder.state(Variable("level", "1", "state", start=1.0))
    recorder.rate("level", rate(x, recorder.time))
    return recorder.program()


@pytest.mark.parametrize("method", ["rk45", "dop853", "rodas"])
@pytest.mark.parametrize(
    ("rate", "status", "time"),
    [
        (lambda x, t: x * x + 0 * t, {SMALL_STEP, NOT_FINITE}, 1.0),  # x = 1/(1 − t)
        (lambda x, t: sqrt(0.5 - t) + 0 * x, {NOT_FINITE}, 0.5),
        (lambda x, t: log(x - 1.0) * t, {NOT_FINITE}, 0.0),
    ],
    ids=["blow-up", "undefined later", "undefined at once"],
)
def test_failures_say_where_and_why(method: str, rate, status: set[int], time: float) -> None:
    run = Engine(_one_state(rate)).simulate([0.0, 0.25, 2.0], control=Control(method))
    assert run.status in status
    # the last steps before the singularity are a few times the resolution of time, or of 1/x
    assert run.stopped_at == pytest.approx(time, abs=1e-5)
    assert "one at t = " in run.message
    if run.status == NOT_FINITE:
        assert run.component == 0
        assert "level" in run.message
    assert len(run.time) == (2 if time > 0.25 else 1)
    assert np.isfinite(run.states).all()


def test_no_states_or_times_out_of_order() -> None:
    recorder = Recorder("static", "no states")
    w = recorder.input(Variable("w", "1", "input", start=3.0))
    recorder.output(Variable("y", "1", "output"), 2 * w + recorder.time)
    run = Engine(recorder.program()).simulate([0.0, 0.5, 1.0])
    np.testing.assert_array_equal(run.outputs[:, 0], [6.0, 6.5, 7.0])
    for times in ([1.0, 0.0], [], [0.0, np.nan]):
        with pytest.raises(InputError, match="ascending"):
            Engine(chain(1)).simulate(times)
    with pytest.raises(InputError, match="method"):
        Engine(chain(1)).simulate([0.0, 1.0], control=Control("euler"))
