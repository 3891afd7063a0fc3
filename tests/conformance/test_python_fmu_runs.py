"""Runs of Python FMUs against integrators of ours, and many instances in one process."""

from __future__ import annotations

import gc
import json
import math
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import fmpy
import pytest
from support.fmu_instance import Instance
from support.python_programs import PYTHON_PROGRAMS as PROGRAMS
from support.python_programs import (
    tunable,
)

from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, RungeKutta
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.runtime.integrator import Integrator

Load = Callable[..., Instance]


class TestRuns:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_bits_are_those_of_the_integration_in_process(
        self, load_python: Load, name: str
    ) -> None:
        """Held inputs, one call per communication step, outputs and feed-through included.

        Between the steps of a program without inputs nothing is set: none but the first is cut.
        """
        program = PROGRAMS[name]().with_start({"b": 2.0} if name == "fragile" else {})
        engine = Engine(program)
        integrator = Integrator(engine)

        def advance(t: float, x: list[float], t_end: float) -> list[float]:
            held = not program.inputs and t > 0.0
            if not held or t == 0.1:
                integrator.start(t, x, step=integrator.report.step)
            bound = t_end + 100.0 * (t_end - t) if held else t_end
            return integrator.advance([t_end], bound=bound)[0].tolist()

        def outputs(t: float, x: list[float], u: list[float]) -> list[float]:
            engine.set_inputs(u)
            return engine.outputs(t, x).tolist()

        instance = load_python(name)
        self.compare(instance, program, advance, outputs)
        calculated = [v.name for v in program.calculated]
        assert list(instance.get(calculated).values()) == engine.calculated().tolist()

    @pytest.mark.parametrize("method", ["dop853", "rk4"])
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_bits_without_the_library(
        self, name: str, method: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """As above, where the FMU has to do with Python alone."""
        monkeypatch.setattr("m4e_fmi.fmu.export.from_program.library_path", lambda: None)
        program = PROGRAMS[name]().with_start({"b": 2.0} if name == "fragile" else {})
        form = load_python(program)
        p = [v.start for v in program.parameters]
        c = form.constants(p)
        now = [v.start for v in program.inputs]

        def rates(t: float, y: Sequence[float]) -> list[float]:
            return form.rates(t, y, now, p, c)

        fixed = RungeKutta(rates, step=0.03, tolerance=1.0)
        integrator = fixed if method == "rk4" else DormandPrince(rates)

        def outputs(t: float, x: list[float], u: list[float]) -> list[float]:
            now[:] = u
            return form.outputs(t, x, u, p, c)

        path = build_fmu(program, tmp_path / "python.fmu", method=method, step_size=0.03)
        with Instance(path, tmp_path / "unpacked") as instance:
            self.compare(instance, program, integrator.advance, outputs)
            calculated = [v.name for v in program.calculated]
            assert list(instance.get(calculated).values()) == form.calculated(p, c)

    @staticmethod
    def compare(
        instance: Instance,
        program: Program,
        advance: Callable[[float, list[float], float], list[float]],
        outputs: Callable[[float, list[float], list[float]], list[float]],
    ) -> None:
        """Assert that five steps give the bits of `advance` and `outputs`."""
        x, u = ([v.start for v in group] for group in (program.states, program.inputs))
        instance.initialise({v.name: v.start for v in program.inputs})
        named = [[v.name for v in group] for group in (program.states, program.outputs)]
        assert list(instance.get(named[1]).values()) == outputs(0.0, x, u)
        for t, h in ((0.0, 0.1), (0.1, 0.1), (0.2, 0.02), (0.22, 0.3), (0.52, 0.05)):
            for j in range(len(u)):
                u[j] += 0.25
            instance.set({v.name: value for v, value in zip(program.inputs, u, strict=True)})
            outputs(t, x, u)  # hands the inputs on
            x = advance(t, x, t + h)
            instance.step(t, h)
            assert list(instance.get(named[0]).values()) == x
            assert list(instance.get(named[1]).values()) == outputs(t + h, x, u)

    def test_simulate_fmu(self, python_fmus: dict[str, Path]) -> None:
        result: Any = fmpy.simulate_fmu(
            str(python_fmus["autonomous"]),
            stop_time=2.0,
            output_interval=0.1,
            output=["x", "v", "energy"],
        )
        t = result["time"]
        assert list(t) == pytest.approx([0.1 * k for k in range(21)])
        # ẍ = −4x + sin 3t, x(0) = 1, ẋ(0) = 0
        for k in (7, 20):
            s = t[k]
            x = math.cos(2 * s) + 0.3 * math.sin(2 * s) - 0.2 * math.sin(3 * s)
            assert result["x"][k] == pytest.approx(x, abs=1e-6)  # a hundred times the tolerance
            energy = (result["v"][k] ** 2 + 4 * result["x"][k] ** 2) / 2
            assert result["energy"][k] == pytest.approx(energy, rel=1e-14)

    def test_start_time_is_honoured(self, load_python: Load) -> None:
        instance = load_python("algebraic").initialise(startTime=5.0)
        assert instance["clock"] == 5.0
        instance.step(5.0, 0.5)
        assert instance["clock"] == 5.5

    def test_tolerance_is_honoured(self, load_python: Load) -> None:
        errors = []
        for tolerance in (1e-4, 1e-12):
            instance = load_python("autonomous").initialise(tolerance=tolerance)
            instance.step(0.0, 2.0)
            x = math.cos(4) + 0.3 * math.sin(4) - 0.2 * math.sin(6)
            errors.append(abs(instance["x"] - x))
        assert errors[0] > 1e-8
        assert errors[1] < 1e-10

    def test_start_values_of_states_and_parameters(self, load_python: Load) -> None:
        instance = load_python("tunable").initialise({"x": 0.25, "k": 0.5, "scale": 3.0, "u": 0.0})
        assert instance["x"] == 0.25
        assert instance["y"] == 0.75
        assert instance["time_constant"] == 2.0
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(0.25 * math.exp(-0.5), abs=1e-7)

    def test_start_values_may_be_set_after_outputs_were_read(self, load_python: Load) -> None:
        """Initialization mode: read, set, read again, in any order."""
        instance = load_python("tunable")
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        assert instance["time_constant"] == 0.5
        instance.set({"k": 4.0, "x": 2.0})
        assert instance["time_constant"] == 0.25
        assert instance["y"] == 2.0
        instance.fmu.exitInitializationMode()
        assert instance["y"] == 2.0

    def test_added_mass_set_at_initialisation_counts(self, load_python: Load) -> None:
        accelerations = []
        for added in (0.0, 5.0):
            uncoupled = {f"added_mass[{k}]": 0.0 for k in ("1,2", "2,1", "2,3", "3,2")}
            instance = load_python("floating_body").initialise(
                {**uncoupled, "added_mass[2,2]": added}
            )
            accelerations.append(instance["body.hull.az"])
        assert accelerations == pytest.approx([-9.81, -9.81 * 5 / (5 + 5)], rel=1e-14)

    def test_a_tunable_parameter_may_change_between_steps(self, load_python: Load) -> None:
        instance = load_python("tunable").initialise()
        instance.step(0.0, 0.5)
        x = instance["x"]
        instance.set({"k": 10.0})
        assert instance["time_constant"] == 0.1
        instance.step(0.5, 0.1)
        assert instance["x"] == pytest.approx(1 - (1 - x) * math.exp(-1.0), abs=1e-7)

    def test_inputs_set_after_a_step_change_outputs_with_feedthrough_only(
        self, load_python: Load
    ) -> None:
        instance = load_python("double_pendulum").initialise()
        instance.step(0.0, 0.01)
        names = ["body.lower.ax", "body.lower.x", "body.lower.vx"]
        before = instance.get(names)
        instance.set({"body.lower.force_x": 100.0})
        after = instance.get(names)
        assert before.pop("body.lower.ax") != after.pop("body.lower.ax")
        assert before == after

    def test_reset(self, load_python: Load) -> None:
        instance = load_python("tunable").initialise({"k": 1.0})
        instance.step(0.0, 1.0)
        instance.fmu.reset()
        assert instance["k"] == 2.0
        instance.initialise()
        assert instance["x"] == 0.0
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(1 - math.exp(-2.0), abs=1e-7)

    def test_unpacked_into_a_path_with_a_space(
        self, python_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        with Instance(python_fmus["algebraic"], tmp_path / "my fmus" / "of today") as instance:
            assert instance.initialise()["norm"] == 6.0

    def test_in_a_fresh_process(self, python_fmus: dict[str, Path]) -> None:
        script = (
            "import sys, json, fmpy\n"
            "r = fmpy.simulate_fmu(sys.argv[1], stop_time=1.0, output=['x'])\n"
            "end = [float(r[name][-1]) for name in ('time', 'x')]\n"
            "print(json.dumps([*end, 'm4e_fmi' in sys.modules]))\n"
        )
        answer = subprocess.run(
            [sys.executable, "-c", script, str(python_fmus["tunable"])],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        t, x, ours = json.loads(answer)
        assert t == 1.0
        assert x == pytest.approx(1 - math.exp(-2.0), abs=1e-7)
        assert not ours


class TestOneProcess:
    def test_twice_with_the_folder_deleted_in_between(
        self, python_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        results = []
        for k in range(2):
            with Instance(python_fmus["tunable"], tmp_path / f"run_{k}") as instance:
                instance.initialise().step(0.0, 1.0)
                results.append(instance["x"])
            assert not (tmp_path / f"run_{k}").exists()
        assert results[0] == results[1]

    def test_two_instances_at_a_time_do_not_share_state(self, load_python: Load) -> None:
        one = load_python("tunable").initialise({"k": 1.0})
        other = load_python("tunable").initialise({"k": 3.0})
        one.step(0.0, 1.0)
        other.step(0.0, 1.0)
        assert one["x"] == pytest.approx(1 - math.exp(-1.0), abs=1e-7)
        assert other["x"] == pytest.approx(1 - math.exp(-3.0), abs=1e-7)

    def test_different_fmus(self, load_python: Load) -> None:
        instances = [
            load_python(name) for name in ("autonomous", "algebraic", "tunable", "autonomous")
        ]
        for instance in instances:
            instance.initialise()
        assert instances[0]["energy"] == instances[3]["energy"] == 2.0
        assert instances[1]["norm"] == 6.0
        assert instances[2]["time_constant"] == 0.5

    def test_two_versions_of_an_fmu_of_the_same_name(
        self, load_python: Load, tmp_path: Path
    ) -> None:
        r = Recorder("tunable", "another program under the same name")
        r.output(Variable("x", "1", "constant"), 42.0)
        r.parameter(Variable("k", "1", "first", start=7.0))
        old, new = (
            load_python("tunable"),
            load_python(build_fmu(r.program(), tmp_path / "tunable.fmu")),
        )
        assert new.initialise()["x"] == 42.0
        assert old.initialise()["x"] == 0.0
        assert (old["k"], new["k"]) == (2.0, 7.0)

    def test_versions_that_differ_in_a_start_value_only(
        self, load_python: Load, tmp_path: Path
    ) -> None:
        paths = [build_fmu(tunable(rate=k), tmp_path / f"{k}.fmu") for k in (1.0, 3.0)]
        instances = [load_python(path).initialise() for path in paths]
        assert [instance["time_constant"] for instance in instances] == [1.0, 1 / 3]

    def test_fifty_instantiations_leave_nothing_behind(
        self, python_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        def run(k: int) -> None:
            with Instance(python_fmus["tunable"], tmp_path / f"run_{k}") as instance:
                instance.initialise().step(0.0, 0.1)

        run(0)
        gc.collect()
        modules, memory = set(sys.modules), _resident_megabytes()
        for k in range(1, 51):
            run(k)
        gc.collect()
        assert set(sys.modules) == modules
        slaves = [x for x in gc.get_objects() if type(x).__name__ == "Slave"]
        assert slaves == []
        # the binary leaks 5 to 8 kB per instantiation; a kept slave or package would be 100 kB
        assert _resident_megabytes() - memory < 3.0


def _resident_megabytes() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
