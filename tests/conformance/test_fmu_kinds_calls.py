"""The same questions of FMUs of every kind: saved states, derivatives, errors, refusals.

Native FMUs answer at once with an error. Python FMUs, whose binary has no other way, say it in
`last_error` and discard the next step.
"""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmu_instances import DISCARD, ERROR, FILES, KINDS, Instance, answers, discarded

Load = Callable[..., Instance]
Fmu = Callable[..., Path]
files = pytest.mark.parametrize("kind", FILES)
kinds = pytest.mark.parametrize("kind", KINDS)
natives = pytest.mark.parametrize("kind", [name for name in KINDS if name != "python"])
H = 0.05


def rows(instance: Instance, first: int, last: int) -> list[list[float]]:
    """Steps with changing inputs; everything there is to read after each."""
    found, inputs = [], instance.reals("input")
    for k in range(first, last):
        instance.set({n: [math.sin(k + j)] * instance.size(n) for j, n in enumerate(inputs)})
        instance.step(k * H, H)
        found.append(instance.get(instance.reals()))
    return found


class TestStates:
    @kinds
    @pytest.mark.parametrize(
        "name", ["driven", "plane", "pendulum", "brick", "tunable", "algebraic"]
    )
    def test_replay_is_exact_to_the_bit(self, load: Load, kind: str, name: str) -> None:
        """In the same instance as often as wanted, in another one, as bytes."""
        instance = load(kind, name).initialise()
        rows(instance, 0, 3)
        state = instance.save()
        saved, before = instance.pack(state), instance.get(instance.reals())
        expected = rows(instance, 3, 6)
        for _ in range(2):
            instance.restore(state)
            assert instance.get(instance.reals()) == before
            assert rows(instance, 3, 6) == expected
        other = load(kind, name)
        other.set({n: [7.0] * other.size(n) for n in other.reals("parameter")[:1]})
        other.initialise()
        rows(other, 0, 2)
        for one in (instance, other):
            one.restore(one.unpack(saved))
            assert rows(one, 3, 6) == expected

    @kinds
    def test_in_another_process(self, load: Load, fmu: Fmu, kind: str, tmp_path: Path) -> None:
        script = (
            "import sys; from pathlib import Path\n"
            "from conformance.test_fmu_kinds_calls import rows\n"
            "from support.fmu_instances import KINDS, opened\n"
            "fmu, folder, state, kind = sys.argv[1:]\n"
            "with opened(Path(fmu), Path(folder), KINDS[kind]) as instance:\n"
            "    instance.initialise()\n"
            "    instance.restore(instance.unpack(Path(state).read_bytes()))\n"
            "    print([[x.hex() for x in row] for row in rows(instance, 3, 6)])\n"
        )
        instance = load(kind).initialise({"stiffness": 41.0}, tolerance=1e-5)
        rows(instance, 0, 3)
        (tmp_path / "state").write_bytes(instance.pack(instance.save()))
        words = [str(fmu(kind)), str(tmp_path / "other"), str(tmp_path / "state"), kind]
        done = subprocess.run(
            [sys.executable, "-c", script, *words],
            cwd=Path(__file__).parents[1],
            capture_output=True,
            text=True,
            check=True,
        )
        expected = [[x.hex() for x in row] for row in rows(instance, 3, 6)]
        assert done.stdout.splitlines()[-1] == str(expected)

    @kinds
    def test_a_state_taken_before_the_outputs_were_read(self, load: Load, kind: str) -> None:
        instance = load(kind, "tunable").initialise()
        instance.step(0.0, 0.5)
        state = instance.save()
        expected = instance["y"]
        instance.step(0.5, 0.5)
        instance.restore(state)
        assert instance["y"] == expected

    @kinds
    def test_over_a_change_of_a_parameter(self, load: Load, kind: str) -> None:
        """What follows from parameters is that of the restored ones, in values and derivatives."""
        instance = load(kind).initialise()
        instance.step(0.0, 0.1)

        def found() -> list[float]:
            values = instance.get(["frequency", "a"])
            return [*values, *(instance.slopes(["a"], ["x"], [1.0]) if kind != "python" else ())]

        states, seen = [], []
        for stiffness in (30.0, 47.0):
            instance.change({"stiffness": stiffness})
            states.append(instance.save())
            seen.append(found())
        for k in (0, 1, 1, 0):
            instance.restore(states[k])
            assert found() == seen[k]
        assert seen[0][0] != seen[1][0]

    @kinds
    def test_damaged_and_foreign_states_are_refused(self, load: Load, kind: str) -> None:
        """Every seventh byte with a bit changed, or cut off; of another FMU or version."""
        instance = load(kind, "tunable").initialise()
        if not KINDS[kind].exchange:
            instance.step(0.0, H)
        own, before = instance.save(), instance.get(instance.reals())
        content = instance.pack(own)
        damaged = [bytearray(content) for _ in content[::7]]
        for k, one in enumerate(damaged):
            one[7 * k] ^= 1
        for one in (*map(bytes, damaged), content[:-1], b""):
            self.refuses(instance, own, lambda i=instance, c=one: i.restore(i.unpack(c)))
        others = load(kind, "autonomous"), load(kind, "tunable", built={"method": "rk45"})
        for donor in others:
            state = donor.initialise().save()
            saved = donor.pack(state)
            self.refuses(instance, own, lambda i=instance, c=saved: i.restore(i.unpack(c)))
        self.refuses(instance, own, lambda: instance.restore(others[0].save()))
        assert instance.get(instance.reals()) == before

    def refuses(self, instance: Instance, own: Any, action: Callable[[], None]) -> None:
        """An error at once, or one that the FMU's own state mends."""
        if instance.description.modelExchange is not None:
            answers(ERROR, action)
            return
        action()
        assert "a state was set that is damaged or not of this FMU" in instance.last_error
        discarded(lambda: instance.step(H, H))
        assert all(map(math.isnan, instance.get(instance.reals())))
        instance.restore(own)
        assert instance.last_error == ""


class TestDerivatives:
    @natives
    def test_directional_derivatives_are_exact(self, load: Load, kind: str) -> None:
        instance = load(kind).initialise({"x": 0.2, "v": -0.3, "lift": 0.5})

        def slope(unknown: str, known: str, seed: float = 1.0) -> float:
            return instance.slopes([unknown], [known], [seed])[0]

        assert slope("a", "force", 3.0) == 1.5
        assert slope("a", "x") == -15.0
        assert slope("energy", "x") == pytest.approx(6.0, rel=1e-15)
        assert slope("der(x)", "v") == 1.0
        assert slope("x", "x", 7.0) == 7.0
        assert slope("pull", "stiffness") == pytest.approx(0.2, rel=1e-15)
        assert slope("frequency", "mass") == pytest.approx(-math.sqrt(15.0) / 4.0, rel=1e-15)
        instance.change({"stiffness": 60.0})
        assert slope("a", "x") == -30.0
        for unknown, known in (("force", "x"), ("x", "energy"), ("mass", "x")):
            answers(ERROR, lambda u=unknown, k=known: slope(u, k))

    @pytest.mark.parametrize("kind", [k for k, kind in KINDS.items() if kind.exchange])
    def test_directional_derivatives_of_a_pendulum_as_differences(
        self, load: Load, kind: str
    ) -> None:
        instance = load(kind, "pendulum").initialise()
        rates = [d.variable.name for d in instance.description.derivatives]
        at = np.array([0.4, -0.7, 0.9, 0.2])

        def evaluated(x: np.ndarray) -> np.ndarray:
            instance.put_states(x)
            return instance.rates()

        for k, state in enumerate(instance.state_names):
            step = 1e-5 * np.eye(4)[k]  # error of central differences here: about 1e-9
            expected = (evaluated(at + step) - evaluated(at - step)) / 2e-5
            now = evaluated(at)
            found = instance.slopes(rates, [state], [1.0])
            np.testing.assert_allclose(found, expected, atol=1e-7)
            np.testing.assert_array_equal(instance.get(rates), now)

    @pytest.mark.parametrize("kind", ["native 2", "native 3"])
    def test_derivatives_of_outputs_by_time(self, load: Load, kind: str) -> None:
        instance = load(kind).initialise({"lift": 0.5, "x": 0.2, "v": 0.3})
        names = ["x", "v", "energy", "swing"]
        swing = 0.3 + 0.5 * 3.0
        expected = [0.3, instance["a"], 30.0 * 0.2 * 0.3, swing]
        assert instance.output_rates(names) == pytest.approx(expected, rel=1e-14)
        answers(ERROR, lambda: instance.output_rates(names, order=2))


class TestErrors:
    def refuses(
        self, instance: Instance, action: Callable[[], object], words: str, status: int = ERROR
    ) -> None:
        """At once or, in Python, at the next step, which has to fail; `words` are told."""
        if instance.description.modelExchange is not None:
            answers(status, action)
        else:
            action()
            discarded(lambda: instance.step(0.0, 0.1))
        assert words in instance.last_error
        assert instance.heard()[-1][1].endswith(instance.last_error)

    @kinds
    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_what_is_no_number(self, load: Load, kind: str, value: float) -> None:
        for name in ("force",) if KINDS[kind].exchange else ("force", "stiffness"):
            instance = load(kind).initialise()
            self.refuses(instance, lambda i=instance, n=name: i.set({n: value}), f"{name} was set")
            assert f"was set to {value}" in instance.last_error
            if kind == "python":
                assert math.isnan(instance["x"])
                continue
            instance.step(0.0, 0.1)  # nothing was changed
            assert instance.get(["force", "stiffness"]) == [1.0, 30.0]

    @kinds
    def test_what_cannot_be_set_or_is_no_variable(self, load: Load, kind: str) -> None:
        """Each function is called with a value reference that is not one of its variables."""
        real, x = "Float64" if "3" in kind else "Real", load(kind).references["x"]
        calls: list[tuple[str, Any]] = [
            *((f"get{real}", ([x, 999],)), (f"set{real}", ([999], [1.0]))),
            *(("getString", ([999],)), ("setString", ([999], ["x"]))),
            *(("getBoolean", ([x],)), ("setBoolean", ([x], [True]))),
        ]
        if "3" not in kind:
            calls += [("getInteger", ([x],)), ("setInteger", ([x], [1]))]
        if kind != "python":
            r = load(kind).references
            calls += [("setString", ([r["last_error"]], ["x"])), ("getString", ([x],))]
            names = ("a", "frequency", "mass", *(() if KINDS[kind].exchange else ("x",)))
            calls += [(f"set{real}", ([r[name]], [1.0])) for name in names]
        instance = load(kind).initialise()
        for name, arguments in calls:
            if kind == "python":
                instance = load(kind).initialise()
            call = partial(getattr(instance.fmu, name), *arguments)
            self.refuses(instance, call, "value reference" if kind == "python" else "")
        if kind != "python":
            assert instance.get(["x", "mass"]) == [0.1, 2.0]

    @pytest.mark.parametrize("kind", ["native 2", "native 3"])
    def test_steps_that_do_not_follow(self, load: Load, kind: str) -> None:
        instance = load(kind).initialise(stopTime=1.0)
        steps = (0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (0.0, 1.1), (math.nan, 0.1), (0.0, math.inf)
        for t, h in steps:
            answers(ERROR, lambda t=t, h=h: instance.step(t, h))
            assert instance["x"] == 0.1  # its start value
        instance.step(0.0, 1.0)
        assert instance["x"] != 0.1

    @kinds
    def test_outputs_that_are_not_finite(self, load: Load, kind: str) -> None:
        """1/(x − 1) at x = 1 s: no error before the end of initialization, where x may be set."""
        instance = load(kind, "fragile")
        instance.enter()
        if kind == "python":
            assert math.isnan(instance["inverse"])
        else:
            answers(DISCARD, lambda: instance["inverse"])
        assert "inverse is inf" in instance.last_error
        instance.set({"x": 3.0})
        assert instance["inverse"] == 0.5
        instance.fmu.exitInitializationMode()
        if KINDS[kind].exchange:
            instance.settle()
            instance.fmu.enterContinuousTimeMode()
        instance.step(0.0, 0.1)
        assert instance["x"] == pytest.approx(3.0 / 0.7, rel=1e-7)
        assert instance.last_error == "" or kind != "python"

    @files
    def test_a_step_that_cannot_be_made(self, load: Load, kind: str) -> None:
        """Without a rate; a state from before mends it, and so does a reset."""
        instance = load(kind, "fragile").initialise({"x": 2.0})
        instance.step(0.0, 0.125)
        before = instance.save()
        instance.set({"rate": -1.0})
        discarded(lambda: instance.step(0.125, 0.1))
        assert "not finite at t = 0.125 s: x" in instance.last_error
        heard = instance.heard()
        assert "Traceback" not in "".join(text for status, text in heard if status)
        instance.restore(before)
        instance.step(0.125, 0.125)
        assert instance["x"] == pytest.approx(4.0, rel=1e-7)
        instance.fmu.reset()
        instance.initialise({"x": 2.0}).step(0.0, 0.25)
        assert instance["x"] == pytest.approx(4.0, rel=1e-7)

    @files
    def test_a_solution_that_ends(self, load: Load, kind: str) -> None:
        """x = 2/(1 − 2 t): a step over t = 1/2 s ends near it, which is told.

        In FMI 3.0 all is as before then, in FMI 2.0 the FMU is near the pole.
        """
        instance = load(kind, "fragile").initialise({"x": 2.0})
        instance.step(0.0, 0.25)
        before = instance.save()
        discarded(lambda: instance.step(0.25, 1.0))
        told = instance.last_error
        assert "too small to go on" in told or "not finite" in told
        assert abs(float(told.split("t = ")[1].split(" s")[0]) - 0.5) < 1e-6
        x = instance["x"]
        assert x == pytest.approx(4.0, rel=1e-7) if "3" in kind else not 4.0 <= x < 1e5
        instance.restore(before)
        instance.step(0.25, 0.125)
        assert instance["x"] == pytest.approx(8.0, rel=1e-6)

    @pytest.mark.parametrize("kind", ["native 2", "native 3"])
    def test_logging(self, load: Load, kind: str) -> None:
        """What is in the categories asked for; FMI 2.0 has errors until then."""
        instance = load(kind, loggingOn=False)
        exit_too_early = instance.fmu.exitInitializationMode
        answers(ERROR, exit_too_early)
        assert len(instance.heard()) == (kind == "native 2")
        answers(ERROR, lambda: instance.fmu.setDebugLogging(True, ["nonsense"]))
        for on, categories, count in (
            (True, ["logStatusDiscard"], 0),
            (True, ["logStatusError"], 1),
            (True, [], 1),
            (False, [], 0),
        ):
            instance.fmu.setDebugLogging(on, categories)
            instance.heard().clear()
            answers(ERROR, exit_too_early)
            assert len(instance.heard()) == count

    @natives
    def test_missing_files_are_named(self, load: Load, kind: str) -> None:
        instance = load(kind)
        (instance.folder / "resources" / "tangent.m4e").unlink()
        instance.initialise()
        answers(ERROR, lambda: instance.slopes(["a"], ["x"], [1.0]))
        assert "tangent.m4e cannot be read" in instance.last_error
