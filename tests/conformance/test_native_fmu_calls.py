"""Native FMUs of FMI 2.0: saved states, calls that are refused, odd surroundings."""

from __future__ import annotations

import ctypes
import gc
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from support.fmu_answers import ERROR, answers
from support.fmu_instance import DISCARD, Instance
from support.model_exchange import exchange

Load = Callable[..., Instance]


CONTINUED = """
import sys
from pathlib import Path
sys.path[:0] = {path!r}
from support.fmu_instance import Instance
with Instance(Path({fmu!r}), Path({folder!r})) as instance:
    fmu = instance.fmu
    state = fmu.deSerializeFMUstate(Path({bytes!r}).read_bytes())
    fmu.setFMUstate(state)
    fmu.freeFMUstate(state)
    for k in range(5, 10):
        instance.step(0.1 * k, 0.1)
    print(instance["x"].hex(), instance["v"].hex())
"""


class TestStates:
    def test_rollback(self, load_native: Load) -> None:
        instance = load_native().initialise()
        instance.step(0.0, 0.1)
        state = instance.fmu.getFMUstate()
        runs = []
        for _ in range(3):
            instance.fmu.setFMUstate(state)
            for k in range(1, 6):
                instance.set({"force": float(k)})
                instance.step(0.1 * k, 0.1)
            runs.append((instance["x"], instance["v"]))
        instance.fmu.freeFMUstate(state)
        assert runs[0] == runs[1] == runs[2]

    def test_over_a_change_of_a_parameter(self, load_native: Load) -> None:
        """What follows from parameters is that of the restored ones, in values and derivatives."""
        instance = load_native().initialise()
        instance.step(0.0, 0.1)

        def found() -> tuple[float, float, list[float]]:
            names = ("a", "x")
            unknown, known = ([instance.references[name]] for name in names)
            slope = instance.fmu.getDirectionalDerivative(unknown, known, [1.0])
            return instance["frequency"], instance["a"], slope

        states, seen = [], []
        for stiffness in (30.0, 47.0):
            instance.set({"stiffness": stiffness})
            states.append(instance.fmu.getFMUstate())
            seen.append(found())
        for k in (0, 1, 1, 0):
            instance.fmu.setFMUstate(states[k])
            assert found() == seen[k]
        assert seen[0][0] != seen[1][0]
        for state in states:
            instance.fmu.freeFMUstate(state)

    def test_into_another_instance_and_process(
        self, load_native: Load, native_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        first, second = load_native().initialise({"stiffness": 41.0}), load_native()
        for k in range(5):
            first.step(0.1 * k, 0.1)
        r = first.references["force"]
        first.fmu.setRealInputDerivatives([r], [1], [2.0])
        state = first.fmu.getFMUstate()
        content = first.fmu.serializeFMUstate(state)
        (tmp_path / "state").write_bytes(content)
        restored = second.fmu.deSerializeFMUstate(content)
        second.fmu.setFMUstate(restored)
        for k in range(5, 10):
            first.step(0.1 * k, 0.1)
            second.step(0.1 * k, 0.1)
        assert (first["x"], first["v"]) == (second["x"], second["v"])
        script = CONTINUED.format(
            path=sys.path,
            fmu=str(native_fmus["driven"]),
            folder=str(tmp_path / "other"),
            bytes=str(tmp_path / "state"),
        )
        run = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        )
        assert run.stdout.split()[-2:] == [first["x"].hex(), first["v"].hex()]

    def test_foreign_and_damaged_states_are_refused(self, load_native: Load) -> None:
        instance, other = load_native().initialise(), load_native("fragile").initialise()
        instance.step(0.0, 0.1)
        state, before = instance.fmu.getFMUstate(), (instance["x"], instance["v"])
        answers(ERROR, lambda: other.fmu.setFMUstate(state))
        content = bytearray(instance.fmu.serializeFMUstate(state))
        for place in range(0, len(content), 7):
            damaged = bytearray(content)
            damaged[place] ^= 1
            answers(ERROR, lambda d=damaged: instance.fmu.deSerializeFMUstate(bytes(d)))
        answers(ERROR, lambda: instance.fmu.deSerializeFMUstate(bytes(content[:-1])))
        instance.fmu.freeFMUstate(state)
        assert (instance["x"], instance["v"]) == before


class TestRefusals:
    def test_a_call_in_the_wrong_state(self, load_native: Load) -> None:
        """In each phase every call that the standard does not allow there is an error."""
        phases = "instantiated", "initializing", "stepping", "terminated"
        allowed = {
            "setupExperiment": phases[:1],
            "enterInitializationMode": phases[:1],
            "exitInitializationMode": phases[1:2],
            "terminate": phases[2:3],
            "setReal": phases[:3],
            "getReal": phases[1:],
            "doStep": phases[2:3],
            "setRealInputDerivatives": phases[:3],
            "getRealOutputDerivatives": phases[2:],
            "getDirectionalDerivative": phases[1:],
            "cancelStep": (),
            "enterEventMode": (),
            "newDiscreteStates": (),
            "enterContinuousTimeMode": (),
            "completedIntegratorStep": (),
            "setTime": (),
        }
        instance = load_native()
        fmu, r = instance.fmu, instance.references

        def calls() -> dict[str, Callable[[], Any]]:
            component: Any = fmu.component
            dll, c = fmu.dll, ctypes.c_void_p(component)

            def checked(status: int) -> None:
                if status > 1:
                    raise FMICallException("call", status=status)

            return {
                "setupExperiment": lambda: fmu.setupExperiment(startTime=0.0),
                "enterInitializationMode": fmu.enterInitializationMode,
                "exitInitializationMode": fmu.exitInitializationMode,
                "terminate": fmu.terminate,
                "setReal": lambda: fmu.setReal([r["force"]], [1.0]),
                "getReal": lambda: fmu.getReal([r["x"]]),
                "doStep": lambda: fmu.doStep(0.0, 0.1),
                "setRealInputDerivatives": lambda: fmu.setRealInputDerivatives(
                    [r["force"]], [1], [0.0]
                ),
                "getRealOutputDerivatives": lambda: fmu.getRealOutputDerivatives([r["x"]], [1]),
                "getDirectionalDerivative": lambda: fmu.getDirectionalDerivative(
                    [r["a"]], [r["x"]], [1.0]
                ),
                "cancelStep": lambda: checked(dll.fmi2CancelStep(c)),
                "enterEventMode": lambda: checked(dll.fmi2EnterEventMode(c)),
                "newDiscreteStates": lambda: checked(
                    dll.fmi2NewDiscreteStates(c, ctypes.byref(fmi2.fmi2EventInfo()))
                ),
                "enterContinuousTimeMode": lambda: checked(dll.fmi2EnterContinuousTimeMode(c)),
                "completedIntegratorStep": lambda: checked(
                    dll.fmi2CompletedIntegratorStep(
                        c, 0, ctypes.byref(ctypes.c_int()), ctypes.byref(ctypes.c_int())
                    )
                ),
                "setTime": lambda: checked(dll.fmi2SetTime(c, ctypes.c_double(0.0))),
            }

        enter = {
            "instantiated": lambda: None,
            "initializing": fmu.enterInitializationMode,
            "stepping": fmu.exitInitializationMode,
            "terminated": fmu.terminate,
        }
        for phase in phases:
            enter[phase]()
            state = fmu.getFMUstate()
            for name, call in calls().items():
                instance.messages.clear()
                if phase in allowed[name]:
                    call()
                else:
                    answers(ERROR, call)
                    assert (
                        f"fmi2{name[0].upper()}{name[1:]} cannot be called"
                        in (instance.messages[-1][1])
                    )
                fmu.setFMUstate(state)
            fmu.freeFMUstate(state)

    def test_model_exchange_has_states_of_its_own(
        self, native_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        model, r = exchange(native_fmus["driven"], tmp_path / "driven")
        two = (ctypes.c_double * 2)(0.0, 0.0)
        answers(ERROR, lambda: model.setContinuousStates(two, 2))
        answers(ERROR, lambda: model.completedIntegratorStep())
        model.setReal([r["stiffness"]], [31.0])
        assert model.newDiscreteStates()[:5] == (False,) * 5
        model.enterContinuousTimeMode()
        answers(ERROR, lambda: model.setReal([r["stiffness"]], [30.0]))
        answers(ERROR, lambda: model.enterContinuousTimeMode())
        answers(ERROR, lambda: model.setContinuousStates(two, 1))
        answers(DISCARD, lambda: model.setContinuousStates((ctypes.c_double * 2)(math.nan), 2))
        component: Any = model.component
        step = model.dll.fmi2DoStep
        arguments = (ctypes.c_double(0.0), ctypes.c_double(0.1), 1)
        assert step(ctypes.c_void_p(component), *arguments) == ERROR
        model.setContinuousStates((ctypes.c_double * 2)(0.5, 2.0), 2)
        model.getDerivatives(two, 2)
        assert list(two) == [2.0, (1.0 - 31.0 * 0.5 - 0.4 * 2.0) / 2.0]
        model.setReal([r["x"]], [0.6])  # not in the standard; CasADi does it
        model.getDerivatives(two, 2)
        assert two[1] == (1.0 - 31.0 * 0.6 - 0.4 * 2.0) / 2.0
        assert model.completedIntegratorStep() == (False, False)
        model.enterEventMode()
        model.terminate()
        model.freeInstance()

    def test_nan_and_infinity(self, load_native: Load) -> None:
        instance = load_native().initialise()
        for value in (math.nan, math.inf, -math.inf):
            for name in ("force", "stiffness"):
                answers(ERROR, lambda n=name, v=value: instance.set({n: v}))
                assert f"{name} was set to" in instance.last_error
            answers(ERROR, lambda v=value: instance.step(v, 0.1))
            answers(ERROR, lambda v=value: instance.step(0.0, v))
        instance.step(0.0, 0.1)  # nothing was changed
        assert instance["force"] == 1.0

    def test_steps_that_do_not_follow(self, load_native: Load) -> None:
        instance = load_native()
        instance.initialise(stopTime=1.0)
        for t, h in ((0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (0.0, 1.1)):
            answers(ERROR, lambda t=t, h=h: instance.step(t, h))
            assert instance["x"] == 0.1  # its start value
        instance.step(0.0, 1.0)
        assert instance["x"] != 0.1

    def test_what_is_no_variable(self, load_native: Load) -> None:
        instance = load_native().initialise()
        fmu = instance.fmu
        for call in (
            lambda: fmu.getReal([999]),
            lambda: fmu.setReal([999], [1.0]),
            lambda: fmu.getInteger([0]),
            lambda: fmu.setInteger([0], [1]),
            lambda: fmu.getBoolean([0]),
            lambda: fmu.setBoolean([0], [True]),
            lambda: fmu.setString([0], ["x"]),
            lambda: fmu.getString([1]),
            lambda: instance.set({"a": 1.0}),
            lambda: instance.set({"x": 1.0}),
            lambda: instance.set({"frequency": 1.0}),
        ):
            answers(ERROR, call)

    def test_a_step_that_cannot_be_finished(self, load_native: Load) -> None:
        """x = 1/(1 − t): the solver comes close to t = 1 and says how close."""
        instance = load_native("fragile").initialise()
        instance.step(0.0, 0.5)
        kept = instance.fmu.getFMUstate()
        answers(DISCARD, lambda: instance.step(0.5, 1.0))
        reached, ended = ctypes.c_double(), ctypes.c_int()
        instance.fmu.fmi2GetRealStatus(instance.fmu.component, 2, ctypes.byref(reached))
        instance.fmu.fmi2GetBooleanStatus(instance.fmu.component, 3, ctypes.byref(ended))
        assert reached.value == pytest.approx(1.0, abs=1e-6)
        assert instance["x"] > 1e5
        assert not ended.value
        assert "too small to go on" in instance.last_error or "not finite" in instance.last_error
        answers(ERROR, lambda: instance.step(reached.value, 0.1))
        instance.fmu.setFMUstate(kept)
        instance.set({"rate": 0.0})
        instance.step(0.5, 1.0)
        assert instance["x"] == pytest.approx(2.0, rel=1e-7)

    def test_rates_and_outputs_that_are_not_finite(self, load_native: Load) -> None:
        instance = load_native("fragile").initialise({"rate": -1.0})
        answers(DISCARD, lambda: instance["inverse"])
        assert "inverse is inf at t = 0 s" in instance.last_error
        answers(DISCARD, lambda: instance.step(0.0, 0.1))
        assert instance.last_error == "a state or its rate is not finite at t = 0 s: x"

    def test_log_categories(self, load_native: Load) -> None:
        instance = load_native()
        fmu = instance.fmu
        answers(ERROR, lambda: fmu.setDebugLogging(True, ["nonsense"]))
        for categories, heard in ((["logStatusDiscard"], 0), (["logStatusError"], 1), ([], 1)):
            fmu.setDebugLogging(True, categories)
            instance.messages.clear()
            answers(ERROR, fmu.terminate)
            assert len(instance.messages) == heard
        fmu.setDebugLogging(False, [])
        instance.messages.clear()
        answers(ERROR, fmu.terminate)
        assert instance.messages == []


def test_fmpy_logs_when_other_instances_are_gone(
    native_fmus: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """FMPy has one logger for the whole process: that of tests/support outlives its instances."""
    with Instance(native_fmus["driven"], tmp_path / "gone") as instance:
        instance.initialise()
    del instance
    gc.collect()
    model, _ = exchange(native_fmus["driven"], tmp_path / "driven")
    model.setDebugLogging(True, [])
    answers(ERROR, lambda: model.setContinuousStates((ctypes.c_double * 2)(), 2))
    assert "in event mode" in capsys.readouterr().out


def test_folders_of_any_name(native_fmus: dict[str, Path], tmp_path: Path) -> None:
    folder = tmp_path / "a b é # % [x] &+,;=' 100%25"
    with Instance(native_fmus["driven"], folder) as instance:
        instance.initialise().step(0.0, 0.1)
        assert instance.last_error == ""


def test_missing_files_are_named(native_fmus: dict[str, Path], tmp_path: Path) -> None:
    with Instance(native_fmus["driven"], tmp_path / "x") as instance:
        (instance.folder / "resources" / "tangent.m4e").unlink()
        instance.initialise()
        r = instance.references
        answers(ERROR, lambda: instance.fmu.getDirectionalDerivative([r["a"]], [r["x"]], [1.0]))
        assert "tangent.m4e cannot be read" in instance.last_error
