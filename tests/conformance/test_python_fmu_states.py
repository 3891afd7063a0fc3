"""Python FMUs: saved states, and errors that stop a component."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.fmu_answers import discarded
from support.fmu_instance import Instance
from support.python_programs import PYTHON_PROGRAMS as PROGRAMS

from m4e_fmi.fmu import build_fmu

Load = Callable[..., Instance]


class TestState:
    STEP = 0.05

    def run(self, instance: Instance, first: int, last: int) -> list[dict[str, float]]:
        """Steps with changing inputs; everything there is to read after each."""
        rows = []
        inputs = instance.reals("input")
        for k in range(first, last):
            instance.set({name: math.sin(k + j) for j, name in enumerate(inputs)})
            instance.step(k * self.STEP, self.STEP)
            rows.append(instance.get(instance.reals()))
        return rows

    @pytest.mark.parametrize("name", ["double_pendulum", "floating_body", "tunable", "algebraic"])
    def test_replay_is_exact_to_the_bit(self, load_python: Load, name: str) -> None:
        instance = load_python(name).initialise()
        self.run(instance, 0, 5)
        state = instance.fmu.getFMUstate()
        saved = instance.fmu.serializeFMUstate(state)
        expected = self.run(instance, 5, 10)
        instance.fmu.setFMUstate(state)
        assert self.run(instance, 5, 10) == expected
        instance.fmu.setFMUstate(state)  # a state can be used again
        assert self.run(instance, 5, 10) == expected
        restored = instance.fmu.deSerializeFMUstate(saved)
        instance.fmu.setFMUstate(restored)
        assert self.run(instance, 5, 10) == expected
        instance.fmu.freeFMUstate(state)
        instance.fmu.freeFMUstate(restored)

    @pytest.mark.parametrize("name", ["double_pendulum", "tunable"])
    def test_replay_in_another_instance(self, load_python: Load, name: str) -> None:
        """Also if the other was given other parameters and another tolerance."""
        first = load_python(name).initialise(tolerance=1e-5)
        self.run(first, 0, 5)
        saved = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
        expected = self.run(first, 5, 10)
        parameter = first.reals("parameter")[0]
        second = load_python(name).initialise({parameter: 5.0})
        self.run(second, 0, 2)
        second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(saved))
        assert self.run(second, 5, 10) == expected

    def test_a_state_taken_before_the_outputs_were_read(self, load_python: Load) -> None:
        instance = load_python("tunable").initialise()
        instance.step(0.0, 0.5)
        state = instance.fmu.getFMUstate()
        expected = instance["y"]
        instance.step(0.5, 0.5)
        instance.fmu.setFMUstate(state)
        assert instance["y"] == expected

    def test_a_state_from_before_an_error_mends_it(self, load_python: Load) -> None:
        instance = load_python("fragile").initialise({"b": 1.0})
        state = instance.fmu.getFMUstate()
        instance.set({"a": -1.0})
        discarded(lambda: instance.step(0.0, 0.1))
        instance.fmu.setFMUstate(state)
        assert instance.last_error == ""
        instance.step(0.0, 0.1)
        assert instance["x"] == pytest.approx(0.1, abs=1e-9)

    def refuses(self, instance: Instance, state: Any) -> None:
        """Whether setting the state is an error, which the FMU's own state mends."""
        own = instance.fmu.getFMUstate()
        instance.fmu.setFMUstate(state)
        assert "a state was set that is damaged or not of this FMU" in instance.last_error
        discarded(lambda: instance.step(0.0, 0.1))
        assert all(map(math.isnan, instance.get(instance.reals()).values()))
        instance.fmu.setFMUstate(own)
        assert instance.last_error == ""

    def test_damaged_states_are_refused(self, load_python: Load) -> None:
        """Every change of one bit, and JSON of another form."""
        instance = load_python("tunable").initialise()
        content = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        damaged = [bytearray(content) for _ in content]
        for place, text in enumerate(damaged):
            text[place] ^= 1
        others = [b"", b"[]", b"{}", b"not a state", b'{"values": 3}', content[:-1], content + b" "]
        for text in (*damaged, *others):
            self.refuses(instance, instance.fmu.deSerializeFMUstate(bytes(text)))
        instance.step(0.0, 0.1)
        assert not math.isnan(instance["y"])

    def test_states_of_other_fmus_are_refused(self, load_python: Load, tmp_path: Path) -> None:
        """Also of one that has the same variables and another default tolerance."""
        other = build_fmu(PROGRAMS["tunable"](), tmp_path / "other.fmu", tolerance=1e-5)
        instance = load_python("tunable").initialise()
        for donor in (load_python("autonomous").initialise(), load_python(other).initialise()):
            state = donor.fmu.getFMUstate()
            self.refuses(instance, state)
            saved = donor.fmu.serializeFMUstate(state)
            self.refuses(instance, instance.fmu.deSerializeFMUstate(saved))
        instance.step(0.0, 0.1)
        assert not math.isnan(instance["y"])


class TestErrors:
    """A failure is discard, a log message and a text; never fatal, never a crash."""

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_an_input_that_is_no_number(self, load_python: Load, value: float) -> None:
        instance = load_python("tunable").initialise()
        instance.set({"u": value})
        discarded(lambda: instance.step(0.0, 0.1))
        assert instance.last_error == f"u was set to {value} (t = 0 s)"
        assert math.isnan(instance["y"])

    def test_a_step_that_fails(self, load_python: Load) -> None:
        instance = load_python("fragile").initialise({"b": 1.0})
        instance.step(0.0, 0.5)
        instance.set({"a": -4.0})
        for _ in range(3):
            discarded(lambda: instance.step(0.5, 0.5))
            assert "not finite at t = 0.5 s: x (t = 0.5 s)" in instance.last_error
            assert math.isnan(instance["x"])
        instance.set({"a": 1.0})
        instance.fmu.getFMUstate()
        errors = [text for status, text in instance.messages if status == 3]
        assert len(errors) == 1
        assert "Traceback" not in errors[0]
        assert any("Traceback" in text for status, text in instance.messages if status == 0)

    def test_overflow(self, load_python: Load) -> None:
        instance = load_python("fragile").initialise({"b": 1.0, "x": 1600.0})
        discarded(lambda: instance.step(0.0, 0.1))
        assert "der(x) is inf (t = 0 s)" in instance.last_error

    def test_a_solution_that_ends(self, load_python: Load) -> None:
        """ẋ ≈ exp(x − 800) has a pole."""
        instance = load_python("fragile").initialise({"b": 1.0, "x": 790.0})
        discarded(lambda: instance.step(0.0, 1e5))
        assert "too small to go on" in instance.last_error

    def test_outputs_that_fail(self, load_python: Load) -> None:
        """1/b for b = 0 is nan at once, and stops the next step."""
        instance = load_python("fragile").initialise({"b": 1.0})
        instance.step(0.0, 0.5)
        instance.set({"b": 0.0})
        assert math.isnan(instance["y"])
        assert instance.last_error == "ArithmeticError: y is inf (t = 0.5 s)"
        discarded(lambda: instance.step(0.5, 0.5))

    def test_the_first_error_is_kept(self, load_python: Load) -> None:
        """The nan that an error makes comes back through other components."""
        instance = load_python("fragile").initialise({"b": 1.0, "a": -1.0})
        discarded(lambda: instance.step(0.0, 0.5))
        first = instance.last_error
        instance.set({"b": math.nan})
        assert instance.last_error == first

    def test_outputs_read_too_early_are_no_error(self, load_python: Load) -> None:
        """In initialization mode the inputs that make them possible may follow."""
        instance = load_python("fragile")
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        assert math.isnan(instance["y"])
        assert "y is nan" in instance.last_error
        instance.set({"b": 2.0, "x": 3.0})
        assert instance["y"] == 1.5
        instance.fmu.exitInitializationMode()
        instance.step(0.0, 0.1)
        assert instance.last_error == ""

    def test_an_error_that_stays_during_initialization_stays(self, load_python: Load) -> None:
        instance = load_python("fragile").initialise()  # b = 0
        assert "y is nan" in instance.last_error
        instance.set({"b": 1.0})
        discarded(lambda: instance.step(0.0, 0.1))

    def test_reset_after_an_error(self, load_python: Load) -> None:
        instance = load_python("fragile").initialise()
        assert instance.last_error
        instance.fmu.reset()
        instance.initialise({"b": 1.0}).step(0.0, 1.0)
        assert instance["y"] == pytest.approx(1.0, abs=1e-9)

    @pytest.mark.parametrize(
        "call",
        [
            lambda fmu: fmu.getReal([0, 99]),
            lambda fmu: fmu.setReal([99], [1.0]),
            lambda fmu: fmu.getString([99]),
            lambda fmu: fmu.setString([99], ["x"]),
            lambda fmu: fmu.getInteger([0]),
            lambda fmu: fmu.setInteger([0], [1]),
            lambda fmu: fmu.getBoolean([0]),
            lambda fmu: fmu.setBoolean([0], [True]),
        ],
    )
    def test_wrong_value_references_are_an_error_and_no_crash(
        self, load_python: Load, call: Callable[[Any], Any]
    ) -> None:
        instance = load_python("tunable").initialise()
        call(instance.fmu)
        assert "value reference" in instance.last_error
        discarded(lambda: instance.step(0.0, 0.1))
