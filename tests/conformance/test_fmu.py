"""FMUs built from programs and Python slaves, as an importer meets them."""

from __future__ import annotations

import gc
import hashlib
import json
import math
import os
import shutil
import stat
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from support.fmu_instance import DISCARD, Instance

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import FmuVariable, ModelDescription, PythonSource, build_fmu, describe
from m4e_fmi.fmu.export.from_program import python_slave
from m4e_fmi.model import Body, Joint, Model, Parameter, Point
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Variable, exp, sin, sqrt
from m4e_fmi.program.python_form import load_python
from m4e_fmi.runtime import DormandPrince, RungeKutta
from m4e_fmi.runtime.engine import Engine
from m4e_fmi.runtime.integrator import Integrator

EXAMPLES = Path(__file__).parents[2] / "examples"
ODD = "odd % %s %n < > & \" ' é 水 {x} \\ \t end"


def double_pendulum() -> Program:
    return model_program(EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml")


def floating_body() -> Program:
    model = Model(
        name="floating_body",
        gravity=9.81,
        bodies={"hull": Body(5.0, 2.0, added_mass=True)},
        joints={"sea": Joint("floating", "hull", initial={"x": 1.0, "z": -0.5, "omega": 0.1})},
        points={"eye": Point("hull", (1.0, 0.3))},
    )
    added = ((4.0, 0.3, 0.2), (0.3, 6.0, 0.5), (0.2, 0.5, 1.0))
    start = {f"added_mass[{i + 1},{j + 1}]": added[i][j] for i in range(3) for j in range(3)}
    return model_program(model).with_start(start)


def algebraic() -> Program:
    """No states."""
    r = Recorder("algebraic", "a function of its inputs")
    a, b = r.input(Variable("a", "m", "one", start=3.0)), r.input(Variable("b", "m", "other"))
    gain = r.parameter(Variable("gain", "1", "factor", start=2.0))
    r.output(Variable("norm", "m", "length"), gain * sqrt(a * a + b * b))
    r.output(Variable("clock", "s", "time"), r.time + 0.0)
    return r.program()


def autonomous() -> Program:
    """No inputs and no parameters."""
    r = Recorder("autonomous", "a forced oscillator")
    x = r.state(Variable("x", "m", "place", start=1.0))
    v = r.state(Variable("v", "m/s", "speed", derivative_of="x"))
    r.rate("x", v)
    r.rate("v", -4.0 * x + sin(3.0 * r.time))
    r.output(Variable("energy", "J", "per kilogram"), (v * v + 4.0 * x * x) / 2)
    return r.program()


def tunable(name: str = "tunable", rate: float = 2.0) -> Program:
    """A leaky integrator with a tunable and a fixed parameter, and odd texts."""
    r = Recorder(name, ODD)
    k = r.parameter(Variable("k", "1/s", ODD, start=rate, tunable=True))
    scale = r.parameter(Variable("scale", "kN", ODD, start=1.0))
    u = r.input(Variable("u", "1", ODD, start=1.0))
    x = r.state(Variable("x", "1", ODD))
    hidden = r.state(Variable("hidden", "1", ODD, local=True))
    r.rate("x", k * (u - x))
    r.rate("hidden", x)
    r.output(Variable("y", "kN", ODD, display_unit="N"), scale * x + hidden)
    r.calculate(Variable("time_constant", "s", ODD), 1.0 / k)
    return r.program()


def fragile() -> Program:
    """Steps fail for a < 0, outputs for b = 0."""
    r = Recorder("fragile", "breaks on demand")
    a, b = r.input(Variable("a", "1", "≥ 0", start=1.0)), r.input(Variable("b", "1", "≠ 0"))
    x = r.state(Variable("x", "1", "state"))
    r.rate("x", sqrt(a) + exp(x - 800.0))
    r.output(Variable("y", "1", "quotient"), x / b)
    return r.program()


PROGRAMS: dict[str, Callable[[], Program]] = {
    make.__name__: make
    for make in (double_pendulum, floating_body, algebraic, autonomous, tunable, fragile)
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fmus")


@pytest.fixture(scope="module")
def fmus(folder: Path) -> dict[str, Path]:
    return {name: build_fmu(make(), folder / f"{name}.fmu") for name, make in PROGRAMS.items()}


Load = Callable[..., Instance]


@pytest.fixture
def load(tmp_path: Path, fmus: dict[str, Path]) -> Iterator[Load]:
    """`load(name or path)` is a fresh instance; all are freed after the test."""
    with ExitStack() as stack:
        count = iter(range(1000))

        def loaded(fmu: str | Path) -> Instance:
            path = fmus[fmu] if isinstance(fmu, str) else fmu
            return stack.enter_context(Instance(path, tmp_path / f"unpacked_{next(count)}"))

        yield loaded


def discarded(call: Callable[[], Any]) -> None:
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == DISCARD


class TestArchive:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_no_findings(self, fmus: dict[str, Path], name: str) -> None:
        assert validate_fmu(str(fmus[name])) == []

    @pytest.mark.parametrize("name", PROGRAMS)
    def test_built_twice_the_bytes_are_the_same(
        self, fmus: dict[str, Path], tmp_path: Path, name: str
    ) -> None:
        again = build_fmu(PROGRAMS[name](), tmp_path / "elsewhere" / "again.fmu")
        assert again.read_bytes() == fmus[name].read_bytes()
        with zipfile.ZipFile(again) as archive:  # not in the order of some file system
            assert archive.namelist() == sorted(archive.namelist())

    def test_built_in_another_process_the_bytes_are_the_same(self, fmus: dict[str, Path]) -> None:
        """Whatever the hash seed: nothing depends on the order of a set."""
        script = (
            "import sys, hashlib, pathlib\n"
            "from m4e_fmi.fmu import build_fmu\n"
            "from m4e_fmi.multibody import model_program\n"
            "path = build_fmu(model_program(sys.argv[1]), sys.argv[2])\n"
            "print(hashlib.sha256(path.read_bytes()).hexdigest())\n"
        )
        model = EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"
        target = fmus["double_pendulum"].with_name("other_process.fmu")
        digest = subprocess.run(
            [sys.executable, "-c", script, str(model), str(target)],
            env={**os.environ, "PYTHONHASHSEED": "17"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        expected = hashlib.sha256(fmus["double_pendulum"].read_bytes()).hexdigest()
        assert digest == expected

    def test_another_program_has_another_guid(self, tmp_path: Path) -> None:
        guids = set()
        for rate in (2.0, 3.0):
            path = build_fmu(tunable(rate=rate), tmp_path / "one.fmu")
            description: Any = fmpy.read_model_description(str(path))
            guids.add(description.guid)
        assert len(guids) == 2

    def test_the_file_is_replaced_as_a_whole_and_readable_by_others(self, tmp_path: Path) -> None:
        path = tmp_path / "a.fmu"
        path.write_bytes(b"old")
        mask = os.umask(0o022)
        try:
            build_fmu(algebraic(), path)
        finally:
            os.umask(mask)
        assert {file.name for file in tmp_path.iterdir()} == {"a.fmu", "a.build.json"}
        assert stat.S_IMODE(path.stat().st_mode) == 0o644

    @pytest.mark.parametrize(
        "name", ["lambda", "ProgramSlave", "M4eSlave", "None", "a b-c", "json"]
    )
    def test_any_name_that_starts_with_a_letter(
        self, load: Load, tmp_path: Path, name: str
    ) -> None:
        path = build_fmu(tunable(name), tmp_path / "named.fmu")
        assert validate_fmu(str(path)) == []
        instance = load(path).initialise()
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(1 - math.exp(-2.0), abs=1e-7)

    @pytest.mark.parametrize("name", ["", "2d", "été", "_a"])
    def test_other_names_are_refused(self, tmp_path: Path, name: str) -> None:
        with pytest.raises(InputError, match="cannot name an FMU"):
            build_fmu(tunable(name), tmp_path / "named.fmu")
        assert not list(tmp_path.iterdir())

    def test_a_variable_called_last_error_is_refused(self, tmp_path: Path) -> None:
        r = Recorder("taken", "")
        r.parameter(Variable("last_error", "1", ""))
        with pytest.raises(InputError, match="every FMU has a variable 'last_error'"):
            build_fmu(r.program(), tmp_path / "taken.fmu")

    def test_an_unknown_unit_is_refused(self, tmp_path: Path) -> None:
        r = Recorder("unit", "")
        r.output(Variable("y", "furlong", ""), 1.0)
        with pytest.raises(ValueError, match="'furlong' is not a unit"):
            build_fmu(r.program(), tmp_path / "unit.fmu")


class TestDescription:
    def test_variables(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["tunable"]))
        found = {
            v.name: (v.causality, v.variability, v.initial, v.start, v.unit)
            for v in description.modelVariables
        }
        assert found == {
            "k": ("parameter", "tunable", "exact", "2.0", "1/s"),
            "scale": ("parameter", "fixed", "exact", "1.0", "kN"),
            "time_constant": ("calculatedParameter", "tunable", "calculated", None, "s"),
            "u": ("input", "continuous", "exact", "1.0", "1"),  # FMI's default for an input
            "x": ("output", "continuous", "exact", "0.0", "1"),
            "hidden": ("local", "continuous", "exact", "0.0", "1"),
            "y": ("output", "continuous", "calculated", None, "kN"),
            "der(x)": ("local", "continuous", "calculated", None, "1/s"),
            "der(hidden)": ("local", "continuous", "calculated", None, "1/s"),
            "last_error": ("local", "discrete", "calculated", None, None),
        }

    def test_texts_arrive_as_they_were_written(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["tunable"]))
        written = [v for v in description.modelVariables if v.causality != "local"]
        texts = {v.description for v in written}
        assert texts == {ODD}
        assert description.description == ODD

    def test_characters_that_xml_cannot_hold_are_replaced(self, tmp_path: Path) -> None:
        program = replace(tunable(), description="a\x07b\x01c\ufffe")
        path = build_fmu(program, tmp_path / "bell.fmu")
        description: Any = fmpy.read_model_description(str(path))
        assert description.description == "a\ufffdb\ufffdc\ufffd"

    def test_units(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["tunable"]))
        units = {unit.name: unit for unit in description.unitDefinitions}
        assert set(units) == {"1", "1/s", "kN", "s"}
        force = units["kN"].baseUnit
        assert (force.kg, force.m, force.s, force.factor) == (1, 1, -2, 1000.0)
        (display,) = units["kN"].displayUnits
        # value in the display unit = factor · value in the unit
        assert (display.name, display.factor) == ("N", 1000.0)

    def test_display_unit_of_a_model_parameter(self, tmp_path: Path) -> None:
        model = Model(
            name="heavy",
            parameters={"m": Parameter(148, "t")},
            bodies={"body": Body("m", 1.0)},
            joints={"sea": Joint("floating", "body")},
        )
        path = build_fmu(model_program(model), tmp_path / "heavy.fmu")
        description: Any = fmpy.read_model_description(str(path))
        mass = next(v for v in description.modelVariables if v.name == "m")
        assert (mass.start, mass.unit, mass.displayUnit) == ("148000.0", "kg", "t")
        kilogram = next(unit for unit in description.unitDefinitions if unit.name == "kg")
        assert [(d.name, d.factor) for d in kilogram.displayUnits] == [("t", 0.001)]

    def test_derivatives(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["double_pendulum"]))
        found = {v.name: v.derivative.name for v in description.modelVariables if v.derivative}
        assert found["joint.elbow.u"] == "joint.elbow.q"
        assert found["body.upper.alpha"] == "body.upper.omega"
        assert found["point.tip.vx"] == "point.tip.x"
        assert found["der(joint.elbow.u)"] == "joint.elbow.u"
        rates = [name for name in found if name.endswith("_rate")]
        assert len(found) == 2 + 2 * 6 + 4 + 4 + len(rates)

    def test_default_experiment(self, fmus: dict[str, Path], tmp_path: Path) -> None:
        program = autonomous()
        source = python_slave(program, describe(program, stop_time=3.5, step_size=0.25), "rk4")
        paths = (fmus["autonomous"], build_fmu(source, tmp_path / "long.fmu"))
        found = []
        for path in paths:
            description: Any = fmpy.read_model_description(str(path))
            experiment = description.defaultExperiment
            found.append((experiment.startTime, experiment.stopTime, experiment.stepSize))
        assert found == [("0.0", "10.0", "0.01"), ("0.0", "3.5", "0.25")]

    def test_capabilities(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["autonomous"]))
        cosimulation = description.coSimulation
        assert cosimulation.canGetAndSetFMUstate
        assert cosimulation.canSerializeFMUstate
        assert cosimulation.canHandleVariableCommunicationStepSize
        assert cosimulation.needsExecutionTool
        assert not cosimulation.canBeInstantiatedOnlyOncePerProcess

    @pytest.mark.parametrize("name", ["double_pendulum", "floating_body", "algebraic", "tunable"])
    def test_declared_dependencies_are_those_measured(self, load: Load, name: str) -> None:
        """At a general state, an output moves with an input exactly if it says so."""
        instance = load(name)
        states = {v: 0.3 + 0.1 * k for k, v in enumerate(instance.reals("output", "local"))}
        inputs = {v: 0.7 + 0.2 * k for k, v in enumerate(instance.reals("input"))}
        instance.initialise({**states, **inputs})
        outputs = instance.reals("output")
        declared = {
            unknown.variable.name: {v.name for v in unknown.dependencies}
            for unknown in instance.description.outputs
        }
        assert set(declared) == set(outputs)
        before = instance.get(outputs)
        measured: dict[str, set[str]] = {output: set() for output in outputs}
        for moved, value in inputs.items():
            instance.set({moved: value + 1.0})
            after = instance.get(outputs)
            instance.set({moved: value})
            for output in outputs:
                if after[output] != before[output]:
                    measured[output].add(moved)
        assert measured == declared
        assert instance.get(outputs) == before

    @pytest.mark.parametrize("name", ["double_pendulum", "floating_body", "algebraic", "tunable"])
    def test_declared_initial_dependencies_are_those_measured(self, load: Load, name: str) -> None:
        instance = load(name)
        known = {
            v.name: float(v.start) + 0.05 * (k + 1)
            for k, v in enumerate(instance.description.modelVariables)
            if v.start is not None
        }
        declared = {
            unknown.variable.name: {v.name for v in unknown.dependencies}
            for unknown in instance.description.initialUnknowns
        }
        exact = {v.name for v in instance.description.modelVariables if v.initial == "exact"}
        assert set(declared) == set(instance.reals("output", "calculatedParameter")) - exact
        instance.set(known)
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        before = instance.get(declared)
        measured: dict[str, set[str]] = {unknown: set() for unknown in declared}
        for moved, value in known.items():
            instance.set({moved: value + 0.25})
            after = instance.get(declared)
            instance.set({moved: value})
            for unknown in declared:
                if after[unknown] != before[unknown]:
                    measured[unknown].add(moved)
        instance.fmu.exitInitializationMode()
        assert measured == declared


class TestRuns:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_bits_are_those_of_the_integration_in_process(self, load: Load, name: str) -> None:
        """Held inputs, one call per communication step, outputs and feed-through included."""
        program = PROGRAMS[name]().with_start({"b": 2.0} if name == "fragile" else {})
        engine = Engine(program)
        integrator = Integrator(engine)

        def advance(t: float, x: list[float], t_end: float) -> list[float]:
            integrator.start(t, x, step=integrator.report.step)
            return integrator.advance([t_end], bound=t_end)[0].tolist()

        def outputs(t: float, x: list[float], u: list[float]) -> list[float]:
            engine.set_inputs(u)
            return engine.outputs(t, x).tolist()

        instance = load(name)
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

    def test_simulate_fmu(self, fmus: dict[str, Path]) -> None:
        result: Any = fmpy.simulate_fmu(
            str(fmus["autonomous"]), stop_time=2.0, output_interval=0.1, output=["x", "v", "energy"]
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

    def test_start_time_is_honoured(self, load: Load) -> None:
        instance = load("algebraic").initialise(startTime=5.0)
        assert instance["clock"] == 5.0
        instance.step(5.0, 0.5)
        assert instance["clock"] == 5.5

    def test_tolerance_is_honoured(self, load: Load) -> None:
        errors = []
        for tolerance in (1e-4, 1e-12):
            instance = load("autonomous").initialise(tolerance=tolerance)
            instance.step(0.0, 2.0)
            x = math.cos(4) + 0.3 * math.sin(4) - 0.2 * math.sin(6)
            errors.append(abs(instance["x"] - x))
        assert errors[0] > 1e-8
        assert errors[1] < 1e-10

    def test_start_values_of_states_and_parameters(self, load: Load) -> None:
        instance = load("tunable").initialise({"x": 0.25, "k": 0.5, "scale": 3.0, "u": 0.0})
        assert instance["x"] == 0.25
        assert instance["y"] == 0.75
        assert instance["time_constant"] == 2.0
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(0.25 * math.exp(-0.5), abs=1e-7)

    def test_start_values_may_be_set_after_outputs_were_read(self, load: Load) -> None:
        """Initialization mode: read, set, read again, in any order."""
        instance = load("tunable")
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        assert instance["time_constant"] == 0.5
        instance.set({"k": 4.0, "x": 2.0})
        assert instance["time_constant"] == 0.25
        assert instance["y"] == 2.0
        instance.fmu.exitInitializationMode()
        assert instance["y"] == 2.0

    def test_added_mass_set_at_initialisation_counts(self, load: Load) -> None:
        accelerations = []
        for added in (0.0, 5.0):
            uncoupled = {f"added_mass[{k}]": 0.0 for k in ("1,2", "2,1", "2,3", "3,2")}
            instance = load("floating_body").initialise({**uncoupled, "added_mass[2,2]": added})
            accelerations.append(instance["body.hull.az"])
        assert accelerations == pytest.approx([-9.81, -9.81 * 5 / (5 + 5)], rel=1e-14)

    def test_a_tunable_parameter_may_change_between_steps(self, load: Load) -> None:
        instance = load("tunable").initialise()
        instance.step(0.0, 0.5)
        x = instance["x"]
        instance.set({"k": 10.0})
        assert instance["time_constant"] == 0.1
        instance.step(0.5, 0.1)
        assert instance["x"] == pytest.approx(1 - (1 - x) * math.exp(-1.0), abs=1e-7)

    def test_inputs_set_after_a_step_change_outputs_with_feedthrough_only(self, load: Load) -> None:
        instance = load("double_pendulum").initialise()
        instance.step(0.0, 0.01)
        names = ["body.lower.ax", "body.lower.x", "body.lower.vx"]
        before = instance.get(names)
        instance.set({"body.lower.force_x": 100.0})
        after = instance.get(names)
        assert before.pop("body.lower.ax") != after.pop("body.lower.ax")
        assert before == after

    def test_reset(self, load: Load) -> None:
        instance = load("tunable").initialise({"k": 1.0})
        instance.step(0.0, 1.0)
        instance.fmu.reset()
        assert instance["k"] == 2.0
        instance.initialise()
        assert instance["x"] == 0.0
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(1 - math.exp(-2.0), abs=1e-7)

    def test_unpacked_into_a_path_with_a_space(self, fmus: dict[str, Path], tmp_path: Path) -> None:
        with Instance(fmus["algebraic"], tmp_path / "my fmus" / "of today") as instance:
            assert instance.initialise()["norm"] == 6.0

    def test_in_a_fresh_process(self, fmus: dict[str, Path]) -> None:
        script = (
            "import sys, json, fmpy\n"
            "r = fmpy.simulate_fmu(sys.argv[1], stop_time=1.0, output=['x'])\n"
            "end = [float(r[name][-1]) for name in ('time', 'x')]\n"
            "print(json.dumps([*end, 'm4e_fmi' in sys.modules]))\n"
        )
        answer = subprocess.run(
            [sys.executable, "-c", script, str(fmus["tunable"])],
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
        self, fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        results = []
        for k in range(2):
            with Instance(fmus["tunable"], tmp_path / f"run_{k}") as instance:
                instance.initialise().step(0.0, 1.0)
                results.append(instance["x"])
            assert not (tmp_path / f"run_{k}").exists()
        assert results[0] == results[1]

    def test_two_instances_at_a_time_do_not_share_state(self, load: Load) -> None:
        one = load("tunable").initialise({"k": 1.0})
        other = load("tunable").initialise({"k": 3.0})
        one.step(0.0, 1.0)
        other.step(0.0, 1.0)
        assert one["x"] == pytest.approx(1 - math.exp(-1.0), abs=1e-7)
        assert other["x"] == pytest.approx(1 - math.exp(-3.0), abs=1e-7)

    def test_different_fmus(self, load: Load) -> None:
        instances = [load(name) for name in ("autonomous", "algebraic", "tunable", "autonomous")]
        for instance in instances:
            instance.initialise()
        assert instances[0]["energy"] == instances[3]["energy"] == 2.0
        assert instances[1]["norm"] == 6.0
        assert instances[2]["time_constant"] == 0.5

    def test_two_versions_of_an_fmu_of_the_same_name(self, load: Load, tmp_path: Path) -> None:
        r = Recorder("tunable", "another program under the same name")
        r.output(Variable("x", "1", "constant"), 42.0)
        r.parameter(Variable("k", "1", "first", start=7.0))
        old, new = load("tunable"), load(build_fmu(r.program(), tmp_path / "tunable.fmu"))
        assert new.initialise()["x"] == 42.0
        assert old.initialise()["x"] == 0.0
        assert (old["k"], new["k"]) == (2.0, 7.0)

    def test_versions_that_differ_in_a_start_value_only(self, load: Load, tmp_path: Path) -> None:
        paths = [build_fmu(tunable(rate=k), tmp_path / f"{k}.fmu") for k in (1.0, 3.0)]
        instances = [load(path).initialise() for path in paths]
        assert [instance["time_constant"] for instance in instances] == [1.0, 1 / 3]

    def test_fifty_instantiations_leave_nothing_behind(
        self, fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        def run(k: int) -> None:
            with Instance(fmus["tunable"], tmp_path / f"run_{k}") as instance:
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
    def test_replay_is_exact_to_the_bit(self, load: Load, name: str) -> None:
        instance = load(name).initialise()
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
    def test_replay_in_another_instance(self, load: Load, name: str) -> None:
        """Also if the other was given other parameters and another tolerance."""
        first = load(name).initialise(tolerance=1e-5)
        self.run(first, 0, 5)
        saved = first.fmu.serializeFMUstate(first.fmu.getFMUstate())
        expected = self.run(first, 5, 10)
        parameter = first.reals("parameter")[0]
        second = load(name).initialise({parameter: 5.0})
        self.run(second, 0, 2)
        second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(saved))
        assert self.run(second, 5, 10) == expected

    def test_a_state_taken_before_the_outputs_were_read(self, load: Load) -> None:
        instance = load("tunable").initialise()
        instance.step(0.0, 0.5)
        state = instance.fmu.getFMUstate()
        expected = instance["y"]
        instance.step(0.5, 0.5)
        instance.fmu.setFMUstate(state)
        assert instance["y"] == expected

    def test_a_state_from_before_an_error_mends_it(self, load: Load) -> None:
        instance = load("fragile").initialise({"b": 1.0})
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

    def test_damaged_states_are_refused(self, load: Load) -> None:
        """Every change of one bit, and JSON of another form."""
        instance = load("tunable").initialise()
        content = instance.fmu.serializeFMUstate(instance.fmu.getFMUstate())
        damaged = [bytearray(content) for _ in content]
        for place, text in enumerate(damaged):
            text[place] ^= 1
        others = [b"", b"[]", b"{}", b"not a state", b'{"values": 3}', content[:-1], content + b" "]
        for text in (*damaged, *others):
            self.refuses(instance, instance.fmu.deSerializeFMUstate(bytes(text)))
        instance.step(0.0, 0.1)
        assert not math.isnan(instance["y"])

    def test_states_of_other_fmus_are_refused(self, load: Load, tmp_path: Path) -> None:
        """Also of one that has the same variables and another default tolerance."""
        other = build_fmu(PROGRAMS["tunable"](), tmp_path / "other.fmu", tolerance=1e-5)
        instance = load("tunable").initialise()
        for donor in (load("autonomous").initialise(), load(other).initialise()):
            state = donor.fmu.getFMUstate()
            self.refuses(instance, state)
            saved = donor.fmu.serializeFMUstate(state)
            self.refuses(instance, instance.fmu.deSerializeFMUstate(saved))
        instance.step(0.0, 0.1)
        assert not math.isnan(instance["y"])


class TestErrors:
    """A failure is discard, a log message and a text; never fatal, never a crash."""

    @pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
    def test_an_input_that_is_no_number(self, load: Load, value: float) -> None:
        instance = load("tunable").initialise()
        instance.set({"u": value})
        discarded(lambda: instance.step(0.0, 0.1))
        assert instance.last_error == f"u was set to {value} (t = 0 s)"
        assert math.isnan(instance["y"])

    def test_a_step_that_fails(self, load: Load) -> None:
        instance = load("fragile").initialise({"b": 1.0})
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

    def test_overflow(self, load: Load) -> None:
        instance = load("fragile").initialise({"b": 1.0, "x": 1600.0})
        discarded(lambda: instance.step(0.0, 0.1))
        assert "der(x) is inf (t = 0 s)" in instance.last_error

    def test_a_solution_that_ends(self, load: Load) -> None:
        """ẋ ≈ exp(x − 800) has a pole."""
        instance = load("fragile").initialise({"b": 1.0, "x": 790.0})
        discarded(lambda: instance.step(0.0, 1e5))
        assert "too small to go on" in instance.last_error

    def test_outputs_that_fail(self, load: Load) -> None:
        """1/b for b = 0 is nan at once, and stops the next step."""
        instance = load("fragile").initialise({"b": 1.0})
        instance.step(0.0, 0.5)
        instance.set({"b": 0.0})
        assert math.isnan(instance["y"])
        assert instance.last_error == "ArithmeticError: y is inf (t = 0.5 s)"
        discarded(lambda: instance.step(0.5, 0.5))

    def test_the_first_error_is_kept(self, load: Load) -> None:
        """The nan that an error makes comes back through other components."""
        instance = load("fragile").initialise({"b": 1.0, "a": -1.0})
        discarded(lambda: instance.step(0.0, 0.5))
        first = instance.last_error
        instance.set({"b": math.nan})
        assert instance.last_error == first

    def test_outputs_read_too_early_are_no_error(self, load: Load) -> None:
        """In initialization mode the inputs that make them possible may follow."""
        instance = load("fragile")
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        assert math.isnan(instance["y"])
        assert "y is nan" in instance.last_error
        instance.set({"b": 2.0, "x": 3.0})
        assert instance["y"] == 1.5
        instance.fmu.exitInitializationMode()
        instance.step(0.0, 0.1)
        assert instance.last_error == ""

    def test_an_error_that_stays_during_initialization_stays(self, load: Load) -> None:
        instance = load("fragile").initialise()  # b = 0
        assert "y is nan" in instance.last_error
        instance.set({"b": 1.0})
        discarded(lambda: instance.step(0.0, 0.1))

    def test_reset_after_an_error(self, load: Load) -> None:
        instance = load("fragile").initialise()
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
        self, load: Load, call: Callable[[Any], Any]
    ) -> None:
        instance = load("tunable").initialise()
        call(instance.fmu)
        assert "value reference" in instance.last_error
        discarded(lambda: instance.step(0.0, 0.1))


SLAVE = '''\
"""A slave for tests: counts steps, remembers in odd ways, fails on demand."""
import sys

from .helper import TEXT
from .slave_base import M4eSlave

class Counter(M4eSlave):
    def initialise(self):
        self.steps = [0]
        self.blob = bytes([0, 255, 37])
        self.extra = None

    def step(self, t, h):
        u = self.values[self.index["u"]]
        if u == 1.0:
            raise ValueError("100 % wrong: %s %n " + TEXT)
        if u == 2.0:
            sys.exit(3)
        if u == 3.0:
            raise ValueError("lone \\ud800 surrogate")
        if u == 4.0:
            self.extra = object()
        if u == 5.0:
            self.log("percent %s %n %d")
        self.steps[0] += 1
        self.blob += b"\\x00"

    def update(self):
        self.values[self.index["count"]] = float(self.steps[0])
        self.values[self.index["size"]] = float(len(self.blob))
        note = (self.resources / "note.txt").read_text(encoding="utf-8")
        self.values[self.index["note"]] = float(len(note)) + len(self.text["label"])
        if self.values[self.index["u"]] == 7.0:
            self.values[self.index["count"]] = (-1.0) ** 0.5

    def save(self):
        if self.values[self.index["u"]] == 6.0:
            raise RuntimeError("nothing to save")
        return {"steps": self.steps, "blob": self.blob, "extra": self.extra}

    def restore(self, saved):
        self.steps, self.blob, self.extra = saved["steps"], saved["blob"], saved["extra"]

    def finish(self):
        self.steps = None
        diary = self.text["label"]
        if diary.startswith("/"):
            with open(diary, "a") as stream:
                stream.write("finished\\n")
        raise RuntimeError("finish fails, 100 % sure")
'''


def output(name: str) -> FmuVariable:
    return FmuVariable(name, "1", f"the {name}", "output", initial="calculated")


class TestPythonSlave:
    @pytest.fixture
    def source(self, tmp_path: Path) -> PythonSource:
        here = tmp_path / "source"
        here.mkdir()
        (here / "counter.py").write_text(SLAVE)
        (here / "helper.py").write_text('TEXT = "é"\n')
        variables = (
            FmuVariable("u", "1", "what goes wrong", "input", start=0.0),
            FmuVariable(
                "label", "", "a text", "parameter", "fixed", "exact", "start %s é", type="String"
            ),
            output("count"),
            output("size"),
            output("note"),
        )
        return PythonSource(
            ModelDescription("counter", "counts steps", variables),
            "counter:Counter",
            {name: here / name for name in ("counter.py", "helper.py")},
            {"note.txt": b"12345"},
        )

    @pytest.fixture
    def counter(self, source: PythonSource, tmp_path: Path) -> Path:
        return build_fmu(source, tmp_path / "counter.fmu")

    def test_no_findings(self, counter: Path) -> None:
        assert validate_fmu(str(counter)) == []

    def test_it_runs(self, counter: Path, load: Load) -> None:
        instance = load(counter).initialise()
        assert instance["note"] == 5 + len("start %s é")
        for k in range(3):
            instance.step(0.1 * k, 0.1)
        assert instance.get(["count", "size"]) == {"count": 3.0, "size": 6.0}

    def test_texts_can_be_set_and_read(self, counter: Path, load: Load) -> None:
        instance = load(counter)
        reference = instance.references["label"]
        assert instance.fmu.getString([reference])[0].decode() == "start %s é"
        instance.fmu.setString([reference], ["ünï"])
        assert instance.initialise()["note"] == 8.0
        assert instance.fmu.getString([reference])[0].decode() == "ünï"

    @pytest.mark.parametrize(
        ("u", "text"),
        [
            (1.0, "ValueError: 100 % wrong: %s %n é (t = 0.5 s)"),
            (2.0, "SystemExit: 3 (t = 0.5 s)"),
            (3.0, "ValueError: lone \\ud800 surrogate (t = 0.5 s)"),
        ],
    )
    def test_a_step_that_raises(self, counter: Path, load: Load, u: float, text: str) -> None:
        instance = load(counter).initialise()
        instance.step(0.0, 0.5)
        instance.set({"u": u})
        discarded(lambda: instance.step(0.5, 0.5))
        assert instance.last_error == text
        ((status, message),) = [m for m in instance.messages if m[0] != 0]
        assert status == 3
        assert message == f"instance: {text}"
        details = [m for s, m in instance.messages if s == 0]
        assert any(detail.startswith("Traceback") for detail in details)

    def test_outputs_can_be_read_after_terminate(self, counter: Path, load: Load) -> None:
        """Although the slave has released what it computes them from."""
        instance = load(counter).initialise()
        instance.step(0.0, 0.1)
        instance.fmu.terminate()
        assert instance["count"] == 1.0

    def test_an_output_that_is_no_number(self, counter: Path, load: Load) -> None:
        instance = load(counter).initialise({"u": 7.0})
        assert math.isnan(instance["count"])
        assert "an output is no number" in instance.last_error
        assert "complex" in instance.last_error
        discarded(lambda: instance.step(0.0, 0.1))

    def test_percent_signs_in_log_messages(self, counter: Path, load: Load) -> None:
        instance = load(counter).initialise({"u": 5.0})
        instance.step(0.0, 0.1)
        assert (0, "percent %s %n %d") in instance.messages

    def test_state_with_bytes_replays(self, counter: Path, load: Load) -> None:
        first = load(counter).initialise()
        first.step(0.0, 0.1)
        state = first.fmu.getFMUstate()
        saved = first.fmu.serializeFMUstate(state)
        first.step(0.1, 0.1)
        expected = first.get(["count", "size"])
        for _ in range(2):  # what was saved is not what the slave goes on changing
            first.fmu.setFMUstate(state)
            assert first.get(["count", "size"]) == {"count": 1.0, "size": 4.0}
            first.step(0.1, 0.1)
            assert first.get(["count", "size"]) == expected
        second = load(counter).initialise()
        second.fmu.setFMUstate(second.fmu.deSerializeFMUstate(saved))
        second.step(0.1, 0.1)
        assert second.get(["count", "size"]) == expected

    def test_a_state_that_cannot_be_saved(self, counter: Path, load: Load) -> None:
        instance = load(counter).initialise({"u": 6.0})
        instance.fmu.getFMUstate()
        assert instance.last_error == "RuntimeError: nothing to save (t = 0 s)"
        discarded(lambda: instance.step(0.0, 0.1))

    def test_a_state_that_is_no_json(self, counter: Path, load: Load) -> None:
        instance = load(counter).initialise({"u": 4.0})
        instance.step(0.0, 0.1)
        state = instance.fmu.getFMUstate()
        saved = instance.fmu.serializeFMUstate(state)
        instance.step(0.1, 0.1)  # the instance itself goes on
        instance.fmu.setFMUstate(instance.fmu.deSerializeFMUstate(saved))
        assert "object cannot be saved" in instance.last_error

    @pytest.mark.parametrize("how", ["terminate", "free", "both", "reset"])
    def test_finish_is_called_once_and_may_fail(
        self, counter: Path, tmp_path: Path, how: str
    ) -> None:
        diary = tmp_path / "diary.txt"
        instance = Instance(counter, tmp_path / "unpacked")
        instance.fmu.setString([instance.references["label"]], [str(diary)])
        instance.initialise()
        assert not diary.exists()
        if how in ("terminate", "both"):
            instance.fmu.terminate()
            instance.fmu.terminate()
            assert diary.read_text() == "finished\n"
        if how == "reset":
            instance.fmu.reset()
            assert diary.read_text() == "finished\n"
        instance.fmu.freeInstance()
        shutil.rmtree(instance.folder)
        assert diary.read_text() == "finished\n"

    def test_a_class_with_do_step_only(self, source: PythonSource, load: Load) -> None:
        source.modules["counter.py"].write_text(
            "from .slave_base import M4eSlave\n\n\n"
            "class Counter(M4eSlave):\n"
            "    def do_step(self, current_time, step_size):\n"
            "        self.values[self.index['count']] += 1.0\n"
            "        return True\n"
        )
        path = build_fmu(source, source.modules["counter.py"].with_name("only.fmu"))
        assert validate_fmu(str(path)) == []
        instance = load(path).initialise()
        instance.step(0.0, 0.1)
        instance.step(0.1, 0.1)
        assert instance["count"] == 2.0

    def test_an_empty_class(self, source: PythonSource, load: Load) -> None:
        """Twice: PythonFMU's binary crashes on the second instance of a class without methods."""
        source.modules["counter.py"].write_text(
            "from .slave_base import M4eSlave\n\n\nclass Counter(M4eSlave):\n    pass\n"
        )
        path = build_fmu(source, source.modules["counter.py"].with_name("empty.fmu"))
        for _ in range(3):
            instance = load(path).initialise()
            instance.step(0.0, 0.1)
            assert instance["count"] == 0.0

    def test_a_syntax_error_is_found_when_building(
        self, source: PythonSource, tmp_path: Path
    ) -> None:
        source.modules["helper.py"].write_text("TEXT = (\n")
        with pytest.raises(InputError, match=r"helper\.py:1:8: not valid Python"):
            build_fmu(source, tmp_path / "broken.fmu")

    @pytest.mark.parametrize("slave", ["other:Counter", "counter", "counter:"])
    def test_a_slave_that_is_not_there_is_found_when_building(
        self, source: PythonSource, tmp_path: Path, slave: str
    ) -> None:
        with pytest.raises(ValueError, match="is not 'module:Class'"):
            build_fmu(replace(source, slave=slave), tmp_path / "broken.fmu")

    def test_two_variables_of_one_name(self, source: PythonSource, tmp_path: Path) -> None:
        variables = (*source.description.variables, output("count"))
        description = replace(source.description, variables=variables)
        with pytest.raises(ValueError, match=r"variables named twice: \['count'\]"):
            build_fmu(replace(source, description=description), tmp_path / "twice.fmu")
