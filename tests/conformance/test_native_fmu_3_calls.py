"""Native FMUs of FMI 3.0: within steps, saved states, calls that are refused."""

from __future__ import annotations

import ctypes
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fmpy import fmi3
from support.fmu3_instance import Instance3
from support.fmu_answers import ERROR, answers
from support.fmu_instance import DISCARD

Load = Callable[..., Instance3]


class Watch:
    """An intermediate update callback that notes what it is told, and acts as `act` says."""

    def __init__(self, act: Callable[[float], float | None] = lambda _: None) -> None:
        self.seen: list[tuple[float, bool, bool, bool, bool]] = []
        self.act = act

    def __call__(
        self,
        _environment: Any,
        time: float,
        settable: bool,
        readable: bool,
        finished: bool,
        may_return: bool,
        early: Any,
        early_time: Any,
    ) -> None:
        self.seen.append((time, settable, readable, finished, may_return))
        wanted = self.act(time)
        if wanted is not None:
            early[0] = True
            early_time[0] = wanted


class TestWithinSteps:
    def test_each_step_of_the_integrator_is_shown(self, load_native_3: Load) -> None:
        """x = 1/(1 − t): intermediate values are on the solution, as near as those at the end."""
        watch, found = Watch(), []
        instance = load_native_3("fragile", intermediateUpdate=watch).initialise()
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

    @pytest.mark.parametrize("beyond", [0.0, 0.01, 5.0])
    def test_early_return(self, load_native_3: Load, beyond: float) -> None:
        """At once, or at a time still to come: the state is that of a step to there."""
        watch = Watch(lambda t: t + beyond if t > 0.2 else None)
        instance = load_native_3(earlyReturnAllowed=True, intermediateUpdate=watch).initialise()
        *_, early, reached = instance.step(0.0, 3.0)
        assert early == (beyond < 3.0)
        assert reached == instance["time"]
        first = next(t for t, *_ in watch.seen if t > 0.2)
        assert reached == pytest.approx(min(first + beyond, 3.0), abs=1e-12)
        plain = load_native_3().initialise()
        plain.step(0.0, reached)
        for name in ("body.ball.position", "body.ball.velocity"):
            # other steps, of a local error of 1e-8 each, on a motion that does not amplify them
            assert instance.all(name) == pytest.approx(plain.all(name), abs=1e-6)
        watch.act = lambda _: None
        assert instance.step(reached, 3.5 - reached)[2:] == (False, 3.5)

    def test_no_early_return_where_it_is_not_allowed(self, load_native_3: Load) -> None:
        watch = Watch(lambda t: t)
        instance = load_native_3(intermediateUpdate=watch).initialise()
        assert instance.step(0.0, 3.0) == (False, False, False, 3.0)
        assert not any(may_return for *_, may_return in watch.seen)

    def test_inputs_set_within_a_step(self, load_native_3: Load) -> None:
        """As a step that ends where the input is set."""
        watch = Watch()
        instance = load_native_3(intermediateUpdate=watch).initialise()

        def act(_: float) -> None:
            if len(watch.seen) == 2:
                instance.set({"body.ball.force": (4.0, -1.0)})

        watch.act = act
        instance.step(0.0, 2.0)
        turn = watch.seen[1][0]
        plain = load_native_3().initialise()
        plain.step(0.0, turn)
        plain.set({"body.ball.force": (4.0, -1.0)})
        plain.step(turn, 2.0 - turn)
        assert instance.all("body.ball.position") == pytest.approx(
            plain.all("body.ball.position"), abs=1e-6
        )
        assert instance.all("body.ball.force") == [4.0, -1.0]
        answers(ERROR, lambda: instance.set({"mass": 3.0}))

    def test_what_is_refused_within_a_step(self, load_native_3: Load) -> None:
        watch, statuses = Watch(), {}
        instance = load_native_3(intermediateUpdate=watch).initialise()
        state = instance.fmu.getFMUState()

        def act(_: float) -> None:
            r = (ctypes.c_uint * 1)(instance.references["mass"])
            one = (ctypes.c_double * 1)(3.0)
            n = ctypes.c_size_t(1)
            statuses["mass"] = instance.call("SetFloat64", r, n, one, n)
            statuses["reset"] = instance.call("Reset")
            statuses["restore"] = instance.call("SetFMUState", state)
            statuses["terminate"] = instance.call("Terminate")
            instance.call("FreeInstance")

        watch.act = act
        instance.step(0.0, 0.5)
        assert set(statuses.values()) == {ERROR}
        assert instance["mass"] == 2.0
        assert any("within a step" in text for _, text in instance.messages)
        instance.fmu.freeFMUState(state)

    def test_a_step_that_cannot_be_finished(self, load_native_3: Load) -> None:
        """fmi3Discard: all is as before, and a shorter step from there is a step like others."""
        for update in (None, Watch()):
            instance = load_native_3("fragile", intermediateUpdate=update).initialise()
            instance.step(0.0, 0.5)
            x = instance["x"]
            answers(DISCARD, lambda i=instance: i.step(0.5, 1.0))
            assert (instance["x"], instance["time"]) == (x, 0.5)
            assert "t = 1" in instance.last_error or "t = 0.99999" in instance.last_error
            assert instance.messages[-1] == (DISCARD, instance.last_error)
            assert instance.step(0.5, 0.25)[3] == 0.75
            assert instance["x"] == pytest.approx(4.0, rel=1e-6)


CONTINUED = """
import sys
from pathlib import Path
sys.path[:0] = {path!r}
from support.fmu3_instance import Instance3
with Instance3(Path({fmu!r}), Path({folder!r})) as instance:
    fmu = instance.fmu
    state = fmu.deserializeFMUState(Path({bytes!r}).read_bytes())
    fmu.setFMUState(state)
    fmu.freeFMUState(state)
    for k in range(5, 10):
        instance.step(0.1 * k, 0.1)
    print(*(x.hex() for x in instance.all("body.ball.position")))
"""


class TestStates:
    def test_rollback(self, load_native_3: Load) -> None:
        instance = load_native_3().initialise()
        instance.step(0.0, 0.1)
        state = instance.fmu.getFMUState()
        runs = []
        for _ in range(3):
            instance.fmu.setFMUState(state)
            for k in range(1, 6):
                instance.set({"body.ball.force": (float(k), -k)})
                instance.step(0.1 * k, 0.1)
            runs.append((instance.all("body.ball.position"), instance.all("body.ball.velocity")))
        instance.fmu.freeFMUState(state)
        assert runs[0] == runs[1] == runs[2]

    def test_into_another_instance_and_process(
        self, load_native_3: Load, native_fmus_3: dict[str, Path], tmp_path: Path
    ) -> None:
        first, second = load_native_3().initialise({"gain": (1.0, 2.0, 3.0, 4.0)}), load_native_3()
        first.set({"body.ball.force": (0.5, 0.25)})
        for k in range(5):
            first.step(0.1 * k, 0.1)
        content = first.fmu.serializeFMUState(first.fmu.getFMUState())
        (tmp_path / "state").write_bytes(content)
        second.fmu.setFMUState(second.fmu.deserializeFMUState(content))
        for k in range(5, 10):
            first.step(0.1 * k, 0.1)
            second.step(0.1 * k, 0.1)
        expected = first.all("body.ball.position")
        assert second.all("body.ball.position") == expected
        script = CONTINUED.format(
            path=sys.path,
            fmu=str(native_fmus_3["plane"]),
            folder=str(tmp_path / "other"),
            bytes=str(tmp_path / "state"),
        )
        run = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        )
        assert run.stdout.split()[-2:] == [x.hex() for x in expected]

    def test_foreign_and_damaged_states_are_refused(self, load_native_3: Load) -> None:
        instance, other = load_native_3().initialise(), load_native_3("fragile").initialise()
        instance.step(0.0, 0.1)
        state, before = instance.fmu.getFMUState(), instance.all("body.ball.position")
        answers(ERROR, lambda: other.fmu.setFMUState(state))
        content = bytearray(instance.fmu.serializeFMUState(state))
        for place in range(0, len(content), 7):
            damaged = bytearray(content)
            damaged[place] ^= 1
            answers(ERROR, lambda d=damaged: instance.fmu.deserializeFMUState(bytes(d)))
        instance.fmu.freeFMUState(state)
        assert instance.all("body.ball.position") == before


class TestRefusals:
    def test_instances_that_cannot_be(self, native_fmus_3: dict[str, Path], tmp_path: Path) -> None:
        """No event mode, no scheduled execution, no other token, no variable that is none."""
        impossible: tuple[dict[str, Any], ...] = (
            {"eventModeUsed": True},
            {"requiredIntermediateVariables": [99]},
        )
        for number, arguments in enumerate(impossible):
            with pytest.raises(Exception, match="instantiate"):
                Instance3(native_fmus_3["plane"], tmp_path / str(number), **arguments)
        with Instance3(native_fmus_3["plane"], tmp_path / "plane") as instance:
            instance.fmu.guid = "{00000000-0000-0000-0000-000000000000}"
            component = instance.fmu.component
            with pytest.raises(Exception, match="instantiate"):
                instance.fmu.instantiate(logMessage=instance._log)
            assert "is not that of this FMU" in instance.messages[-1][1]
            scheduled = instance.fmu.dll.fmi3InstantiateScheduledExecution
            arguments = b"one", b"token", b"/", False, False, None, instance.fmu.logMessage
            clocks = fmi3.fmi3ClockUpdateCallback(), fmi3.fmi3LockPreemptionCallback()
            assert not scheduled(*arguments, *clocks, fmi3.fmi3UnlockPreemptionCallback())
            assert "no scheduled execution" in instance.messages[-1][1]
            instance.fmu.component = component

    def test_numbers_that_do_not_fit(self, load_native_3: Load) -> None:
        instance = load_native_3().initialise()
        r = instance.references["body.ball.force"]
        for call in (
            lambda: instance.fmu.getFloat64([r], nValues=1),
            lambda: instance.fmu.getFloat64([r], nValues=3),
            lambda: instance.fmu.setFloat64([r], [1.0]),
            lambda: instance.fmu.setFloat64([r], [1.0, math.nan]),
            lambda: instance.fmu.getFloat64([instance.references["last_error"]]),
            lambda: instance.fmu.getFloat64([999]),
            lambda: instance.fmu.getFloat32([r]),
            lambda: instance.fmu.setBoolean([r], [True]),
            lambda: instance.fmu.getString([r]),
            lambda: instance.fmu.setString([instance.references["last_error"]], ["x"]),
            lambda: instance.set({"time": 1.0}),
            lambda: instance.set({"body.ball.acceleration": (0.0, 0.0)}),
        ):
            answers(ERROR, call)
        assert instance.all("body.ball.force") == [0.0, 0.0]

    def test_silence(self, load_native_3: Load) -> None:
        """Without logging nothing is logged, until it is asked for."""
        instance = load_native_3(loggingOn=False)
        answers(ERROR, instance.fmu.exitInitializationMode)
        assert instance.messages == []
        instance.fmu.setDebugLogging(True, ["logStatusError"])
        answers(ERROR, instance.fmu.exitInitializationMode)
        assert len(instance.messages) == 1
        answers(ERROR, lambda: instance.fmu.setDebugLogging(True, ["nonsense"]))

    def test_files_that_are_not_of_the_fmu(
        self, native_fmus_3: dict[str, Path], tmp_path: Path
    ) -> None:
        """Damaged lists of variables and dependencies: an error, never a crash."""
        with Instance3(native_fmus_3["plane"], tmp_path / "x") as instance:
            resources = instance.folder / "resources"
            variables = (resources / "variables.txt").read_text()
            component = instance.fmu.component
            for text in ("", "0\n", variables + "x", variables[:-1], variables + "999\n", "7\n7\n"):
                (resources / "variables.txt").write_text(text)
                with pytest.raises(Exception, match="instantiate"):
                    instance.fmu.instantiate(logMessage=instance._log)
                assert instance.messages[-1][1] == "variables.txt is not of this FMU"
            instance.fmu.component = component
            count = ctypes.c_size_t()
            for text in ("1 1 1\n", "1 9 1 1 1\n", "2 1 1 1 1\n1 1 1 1 1\n", "1 1 1 1 7\n", "x\n"):
                (resources / "dependencies.txt").write_text(text)
                arguments = ctypes.c_uint(1), ctypes.byref(count)
                assert instance.call("GetNumberOfVariableDependencies", *arguments) == ERROR
                assert instance.messages[-1][1] == "dependencies.txt is not of this FMU"
            (resources / "dependencies.txt").write_text("")
            assert instance.call("GetNumberOfVariableDependencies", *arguments) == 0
