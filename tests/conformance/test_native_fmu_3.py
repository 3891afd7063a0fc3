"""Native FMUs of FMI 3.0, as far as these differ: time, what happens within steps."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from ctypes import byref, c_size_t, c_uint
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from support.fmu_instances import DISCARD, ERROR, Instance, answers
from support.fmu_programs import PROGRAMS
from support.plane import plane

from m4e_fmi.simulate import simulate

MOVING = {"body.ball.vx": 0.5, "body.ball.vz": -0.7}
Load = Callable[..., Instance]
Fmu = Callable[..., Path]


@pytest.fixture
def ball(load: Load) -> Callable[..., Instance]:
    """`ball(start, …)`: an instance of `plane` that is initialised."""

    def made(start: dict[str, Any] | None = None, **arguments: Any) -> Instance:
        return load("native 3", "plane", **arguments).initialise(start or {})

    return made


class TestVariables:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_they_are_those_of_fmi_2_after_time(self, fmu: Fmu, name: str) -> None:
        before: Any = fmpy.read_model_description(str(fmu("native 2", name))).modelVariables
        time, *variables = fmpy.read_model_description(str(fmu("native 3", name))).modelVariables
        assert (time.name, time.causality, time.unit) == ("time", "independent", "s")
        for old, new in zip(before, variables, strict=True):
            for fact in ("name", "causality", "variability", "unit", "start", "description"):
                assert getattr(new, fact) == getattr(old, fact)
        assert [v.valueReference for v in (time, *variables)] == list(range(len(before) + 1))

    @pytest.mark.parametrize(("way", "error"), [("CoSimulation", 1e-8), ("ModelExchange", 1e-6)])
    def test_from_outside(self, fmu: Fmu, way: str, error: float) -> None:
        """FMPy sets parameters and input signals; tolerances of some tens of steps.

        CVODE is of lower order.
        """
        columns = [("time", float), ("body.ball.force_x", float), ("body.ball.force_z", float)]
        signal = np.array([(t, 0.7, -1.0) for t in (0.0, 2.0)], dtype=columns)
        gain = {"gain[1,1]": 1.0, "gain[1,2]": 0.5, "gain[2,1]": -0.25, "gain[2,2]": 2.0}
        places = ["body.ball.x", "body.ball.z"]
        how: dict[str, Any] = {"stop_time": 2.0, "output_interval": 0.1}
        found = fmpy.simulate_fmu(
            str(fmu("native 3", "plane")),
            fmi_type=way,
            relative_tolerance=1e-10,
            input=signal,
            start_values=gain,
            output=places,
            **how,
        )
        start = {**gain, "body.ball.force_x": 0.7, "body.ball.force_z": -1.0}
        expected = simulate(plane(), tolerance=1e-10, start_values=start, **how)
        for name in places:
            np.testing.assert_allclose(found[name], expected[name], atol=error, rtol=0)

    def test_states_of_model_exchange(self, load: Load) -> None:
        instance = load("native 3, exchange", "plane")
        model = instance.initialise({"body.ball.vx": 5.0, "body.ball.vz": 7.0}).fmu
        assert model.getNumberOfContinuousStates() == 4
        assert model.getNumberOfEventIndicators() == 0
        order = [one.variable.derivative.name for one in instance.description.derivatives]
        values = {"body.ball.x": 0.3, "body.ball.z": 1.3, "body.ball.vx": 5.0, "body.ball.vz": 7.0}
        assert instance.states().tolist() == [values[name] for name in order]
        assert sorted(order) == sorted(values)
        model.setTime(0.25)
        instance.put_states((0.1, 0.2, 0.3, 0.4))
        assert instance["time"] == 0.25
        assert instance.nominals().min() > 0
        for count in (3, 5):
            room = (ctypes.c_double * 5)()
            answers(ERROR, lambda n=count, r=room: model.getContinuousStates(r, n))

    def test_numbers_that_do_not_fit(self, ball: Load) -> None:
        instance = ball()
        f, r = instance.fmu, instance.references["body.ball.force_x"]
        for call in (
            lambda: f.getFloat64([r], nValues=2),
            lambda: f.setFloat64([r], [1.0, 2.0]),
            lambda: f.setFloat64([r], [math.nan]),
            lambda: f.getFloat64([instance.references["last_error"]]),
            lambda: f.getFloat32([r]),
            lambda: instance.set({"time": 1.0}),
            lambda: instance.set({"body.ball.ax": 0.0}),
        ):
            answers(ERROR, call)
        assert instance.get(["body.ball.force_x"]) == [0.0]

    def test_dependencies_are_in_the_description(self, ball: Load) -> None:
        instance = ball()
        arguments = c_uint(instance.references["power"]), byref(c_size_t())
        assert instance.call("GetNumberOfVariableDependencies", *arguments) == ERROR
        assert "they are in the model description" in instance.messages[-1][1]


class TestDerivatives:
    def test_adjoint_is_the_transpose(self, ball: Load) -> None:
        """w·(J s) = (Jᵀ w)·s to rounding, over all unknowns and knowns."""
        instance = ball(MOVING)
        r = instance.references
        unknowns = ["body.ball.ax", "body.ball.az", "power", "joint.post.reaction_x", "weight"]
        knowns = ["body.ball.force_z", "body.ball.vx", "body.ball.vz", "mass", "gain[1,2]", "time"]
        rows, columns = (sum(map(instance.size, names)) for names in (unknowns, knowns))
        random = np.random.default_rng(1)
        w, s = random.normal(size=rows), random.normal(size=columns)
        forward = np.array(instance.slopes(unknowns, knowns, list(s)))
        lists = [r[name] for name in unknowns], [r[name] for name in knowns]
        backward = np.array(instance.fmu.getAdjointDerivative(*lists, list(w), columns))
        assert w @ forward == pytest.approx(backward @ s, rel=1e-13)


class Watch:
    """An intermediate update callback that notes what it is told, and acts as `act` says."""

    def __init__(self, act: Callable[[float], float | None] = lambda _: None) -> None:
        self.seen: list[tuple[float, bool, bool, bool, bool]] = []
        self.act = act

    def __call__(self, _: Any, time: float, *flags: Any) -> None:
        """Flags: may be set, may be read, finished, may return early; where to ask for that."""
        *told, early, early_time = flags
        self.seen.append((time, *told))
        wanted = self.act(time)
        if wanted is not None:
            early[0] = True
            early_time[0] = wanted


class TestWithinSteps:
    def test_each_step_of_the_integrator_is_shown(self, load: Load) -> None:
        """x = 1/(1 − t): intermediate values are on the solution, as near as those at the end."""
        watch, found = Watch(), []
        instance = load("native 3", "fragile", intermediateUpdate=watch).initialise()
        watch.act = lambda t: found.append((t, instance["x"], instance["time"]))
        assert instance.step(0.0, 0.9) == (False, False, False, 0.9)
        times = [t for t, *_ in watch.seen]
        assert len(times) > 3
        assert times == sorted(set(times))
        assert times[-1] == 0.9
        assert {tuple(flags) for _, *flags in watch.seen} == {(True, True, True, False)}
        for t, x, time in found:
            assert t == time
            # 1e-8 a step, grown by x²/x0² since
            assert x == pytest.approx(1.0 / (1.0 - t), rel=1e-8 * len(times) / (1.0 - t))

    def test_looking_changes_no_bit(self, ball: Load) -> None:
        instances = ball(), ball(intermediateUpdate=Watch())
        for instance in instances:
            instance.step(0.0, 1.0)
        assert instances[0].get(instances[0].reals()) == instances[1].get(instances[1].reals())

    @pytest.mark.parametrize("beyond", [0.0, 0.01, 5.0])
    def test_early_return(self, ball: Load, beyond: float) -> None:
        """At once, or at a time still to come: the state is that of a step to there."""
        watch = Watch(lambda t: t + beyond if t > 0.2 else None)
        instance = ball(earlyReturnAllowed=True, intermediateUpdate=watch)
        *_, early, reached = instance.step(0.0, 3.0)
        assert early == (beyond < 3.0)
        assert reached == instance["time"]
        first = next(t for t, *_ in watch.seen if t > 0.2)
        assert reached == pytest.approx(min(first + beyond, 3.0), abs=1e-12)
        plain, names = ball(), ["body.ball.x", "body.ball.z", "body.ball.vx", "body.ball.vz"]
        plain.step(0.0, reached)
        # other steps, of a local error of 1e-8 each, on a motion that does not amplify them
        assert instance.get(names) == pytest.approx(plain.get(names), abs=1e-6)
        watch.act = lambda _: None
        assert instance.step(reached, 3.5 - reached)[2:] == (False, 3.5)

    def test_inputs_set_within_a_step(self, ball: Load) -> None:
        """As a step that ends where the input is set."""
        watch = Watch()
        instance, plain = ball(intermediateUpdate=watch), ball()
        force = {"body.ball.force_x": 4.0, "body.ball.force_z": -1.0}
        watch.act = lambda _: instance.set(force) if len(watch.seen) == 2 else None
        instance.step(0.0, 2.0)
        turn = watch.seen[1][0]
        plain.step(0.0, turn)
        plain.set(force)
        plain.step(turn, 2.0 - turn)
        names = ["body.ball.x", "body.ball.z", "body.ball.force_x"]
        assert instance.get(names) == pytest.approx(plain.get(names), abs=1e-6)

    def test_what_is_refused_within_a_step(self, ball: Load) -> None:
        watch, statuses = Watch(), {}
        instance = ball(intermediateUpdate=watch)
        state, n = instance.save(), c_size_t(1)

        def act(_: float) -> None:
            r = (c_uint * 1)(instance.references["mass"])
            statuses["mass"] = instance.call("SetFloat64", r, n, (ctypes.c_double * 1)(3.0), n)
            for name, arguments in (("Reset", ()), ("SetFMUState", (state,)), ("Terminate", ())):
                statuses[name] = instance.call(name, *arguments)
            instance.call("FreeInstance")

        watch.act = act
        instance.step(0.0, 0.5)
        assert set(statuses.values()) == {ERROR}
        assert instance["mass"] == 2.0
        assert any("within a step" in text for _, text in instance.messages)

    def test_a_step_that_cannot_be_finished(self, load: Load) -> None:
        """All is as before, also where it was looked at."""
        instance = load("native 3", "fragile", intermediateUpdate=Watch()).initialise()
        instance.step(0.0, 0.5)
        x = instance["x"]
        answers(DISCARD, lambda: instance.step(0.5, 1.0))
        assert (instance["x"], instance["time"]) == (x, 0.5)
        assert instance.step(0.5, 0.25)[3] == 0.75


class TestRefusals:
    def test_instances_that_cannot_be(self, load: Load) -> None:
        """No event mode, no scheduled execution, no variable that is none."""
        for arguments in ({"eventModeUsed": True}, {"requiredIntermediateVariables": [99]}):
            with pytest.raises(Exception, match="instantiate"):
                load("native 3", **arguments)
        instance = load("native 3")
        scheduled = instance.fmu.dll.fmi3InstantiateScheduledExecution
        arguments = b"one", b"token", b"/", False, False, None, instance.fmu.logMessage
        clocks = fmi3.fmi3ClockUpdateCallback(), fmi3.fmi3LockPreemptionCallback()
        assert not scheduled(*arguments, *clocks, fmi3.fmi3UnlockPreemptionCallback())
        assert "no scheduled execution" in instance.messages[-1][1]
