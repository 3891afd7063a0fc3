"""Native FMUs: valid, exact, the same as the Python FMU and `simulate`; no call breaks them."""

from __future__ import annotations

import ctypes
import gc
import math
import subprocess
import sys
import threading
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from support.driven import driven, fragile
from support.fmu_instance import DISCARD, Instance

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.cosim import load as load_results
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.model import load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Program, Recorder, Variable
from m4e_fmi.simulate import simulate

ERROR = 3
PENDULUM = Path(__file__).parents[2] / "examples/double_pendulum/double_pendulum.model.yaml"
LARGEST = 300_000


def pendulum() -> Program:
    return model_program(load_model(PENDULUM))


def algebraic() -> Program:
    r = Recorder("algebraic", "no states")
    u = r.input(Variable("u", "1", "input", start=2.0))
    r.output(Variable("y", "1", "output"), 3.0 * u)
    return r.program()


def autonomous() -> Program:
    r = Recorder("autonomous", "no inputs, no parameters, no outputs")
    x = r.state(Variable("x", "1", "state", start=1.0))
    r.rate("x", -x)
    return r.program()


PROGRAMS: dict[str, Callable[[], Program]] = {
    make.__name__: make for make in (driven, fragile, pendulum, algebraic, autonomous)
}
Load = Callable[..., Instance]


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("native")
    made = {n: build_fmu(f(), folder / f"{n}.fmu", native=True) for n, f in PROGRAMS.items()}
    made["python"] = build_fmu(driven(), folder / "python.fmu")
    return made


@pytest.fixture
def load(fmus: dict[str, Path], tmp_path: Path) -> Iterator[Load]:
    opened: list[Instance] = []

    def loaded(name: str = "driven") -> Instance:
        opened.append(Instance(fmus[name], tmp_path / f"unpacked_{len(opened)}"))
        return opened[-1]

    yield loaded
    for instance in opened:
        instance.fmu.freeInstance()


def answers(status: int, action: Callable[[], Any]) -> None:
    """Assert that a call answers `status`."""
    with pytest.raises(FMICallException) as caught:
        action()
    assert caught.value.status == status


def exchange(path: Path, folder: Path) -> tuple[fmi2.FMU2Model, dict[str, int]]:
    """An instance for model exchange in event mode, and its value references."""
    description: Any = fmpy.read_model_description(str(path))
    fmpy.extract(str(path), str(folder))
    model = fmi2.FMU2Model(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="model",
    )
    model.instantiate()
    model.setupExperiment()
    model.enterInitializationMode()
    model.exitInitializationMode()
    return model, {v.name: v.valueReference for v in description.modelVariables}


class TestDescription:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_no_finding(self, fmus: dict[str, Path], name: str) -> None:
        assert validate_fmu(str(fmus[name])) == []
        assert fmus[name].stat().st_size < LARGEST

    def test_same_variables_as_the_python_fmu(self, fmus: dict[str, Path]) -> None:
        def listed(name: str) -> list[str]:
            with zipfile.ZipFile(fmus[name]) as archive:
                root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            tags = ("ModelVariables", "UnitDefinitions")
            return [ElementTree.tostring(root.find(tag) or root).decode() for tag in tags]

        assert listed("driven") == listed("python")

    def test_same_bytes_every_time(self, fmus: dict[str, Path], tmp_path: Path) -> None:
        again = build_fmu(driven(), tmp_path / "again.fmu", native=True)
        assert again.read_bytes() == fmus["driven"].read_bytes()

    def test_dependencies_and_their_kinds(self, fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(fmus["driven"]))

        def kinds(unknowns: list[Any]) -> dict[str, dict[str, str]]:
            return {
                u.variable.name: dict(
                    zip([v.name for v in u.dependencies], u.dependenciesKind, strict=True)
                )
                for u in unknowns
            }

        outputs = kinds(description.outputs)
        assert outputs["x"] == {"x": "constant"}
        assert outputs["a"] == {"force": "fixed", "x": "tunable", "v": "fixed"}
        assert outputs["height"] == {"x": "constant", "lift": "constant"}
        assert outputs["pull"] == {"x": "tunable"}
        assert outputs["energy"] == {"x": "dependent"}
        assert outputs["swing"] == {"x": "constant", "lift": "dependent"}
        assert "momentum" not in outputs
        rates = kinds(description.derivatives)
        assert list(rates) == ["der(x)", "a"]
        assert rates["der(x)"] == {"v": "constant"}
        first = kinds(description.initialUnknowns)
        both = {"stiffness": "dependent", "mass": "dependent"}
        assert first["frequency"] == both
        assert first["height"] == {"x": "constant", "lift": "constant"}
        assert first["pull"] == {"x": "dependent", "stiffness": "dependent"}

    @pytest.mark.parametrize("appended", [" ", " 1"])
    def test_a_longer_guid_is_refused(self, load: Load, appended: str) -> None:
        """Also by what follows the GUID in the FMU's own file."""
        fmu = load().fmu
        fmu.guid += appended
        with pytest.raises(Exception, match="nstantiate"):
            fmu.instantiate()

    def test_another_guid_is_refused(self, load: Load) -> None:
        fmu = load().fmu
        fmu.guid = "{00000000-0000-0000-0000-000000000000}"
        with pytest.raises(Exception, match="nstantiate"):
            fmu.instantiate()

    def test_bad_integrations(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="did you mean 'dop853'"):
            build_fmu(driven(), tmp_path / "p.fmu", method="dop854")
        for step in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(InputError, match="the step size must be positive"):
                build_fmu(driven(), tmp_path / "p.fmu", method="rk4", step_size=step)

    def test_python_code_cannot_be_native(self, tmp_path: Path) -> None:
        from m4e_fmi.fmu import ModelDescription, PythonSource

        source = PythonSource(ModelDescription("p", "p", ()), "slave:Slave", {}, {})
        with pytest.raises(InputError, match="cannot be a native FMU"):
            build_fmu(source, tmp_path / "p.fmu", native=True)
        with pytest.raises(InputError, match="no method 'euler'"):
            build_fmu(driven(), tmp_path / "p.fmu", native=True, method="euler")

    def test_without_a_compiler(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("M4E_FMI_CACHE", str(tmp_path))
        monkeypatch.setattr("m4e_fmi.runtime.compiler.compiler", lambda: None)
        monkeypatch.setattr("m4e_fmi.runtime.platforms.FOLDER", tmp_path / "none")
        with pytest.raises(RunError, match="no library for native FMUs"):
            build_fmu(driven(), tmp_path / "p.fmu", native=True)


class TestResults:
    def test_as_simulate(self, fmus: dict[str, Path]) -> None:
        """Co-simulation and CVODE, to the tolerances of both over 2 s of a regular motion."""
        names = ["body.lower.theta", "energy.total"]
        expected = simulate(pendulum(), stop_time=2.0, output_interval=0.1, tolerance=1e-10)
        for kind, tolerance, error in (
            ("CoSimulation", 1e-10, 1e-8),
            ("ModelExchange", 1e-10, 1e-6),
        ):
            found = fmpy.simulate_fmu(
                str(fmus["pendulum"]),
                fmi_type=kind,
                stop_time=2.0,
                output_interval=0.1,
                relative_tolerance=tolerance,
                output=names,
            )
            for name in names:
                scale = np.abs(expected[name]).max()
                np.testing.assert_allclose(found[name], expected[name], atol=error * scale, rtol=0)

    def test_as_the_python_fmu(self, load: Load) -> None:
        """The same library runs both: the same bits, also with a tolerance and after a restart."""
        both = [load("driven"), load("python")]
        for instance in both:
            instance.initialise({"stiffness": 80.0}, tolerance=1e-6)
        names = both[0].reals()
        assert names == both[1].reals()
        states = []
        for k in range(40):
            if k == 20:
                states = [instance.fmu.getFMUstate() for instance in both]
            for instance in both:
                instance.set({"force": math.sin(k), "lift": 0.01 * k, "stiffness": 80.0 + k})
                instance.step(0.05 * k, 0.05 if k % 3 else 0.02)
                if k % 3 == 0:
                    instance.step(0.05 * k + 0.02, 0.03)
            assert both[0].get(names) == both[1].get(names)
        for instance, state in zip(both, states, strict=True):
            instance.fmu.setFMUstate(state)
            instance.step(1.0, 0.4)
        assert both[0].get(names) == both[1].get(names)

    def test_parts_of_a_step(self, load: Load) -> None:
        """x' = v, v' = −15 x − 0.2 v + 1/2 has an exact solution; steps of any size follow it."""
        instance = load().initialise()
        t = 0.0
        for h in (0.3, 0.001, 0.7, 1e-6, 0.998999):
            instance.step(t, h)
            t += h
        decay, speed = 0.1, math.sqrt(15.0 - 0.01)
        rest = 1.0 / 30.0
        c, s = 0.1 - rest, decay * (0.1 - rest) / speed
        x = rest + math.exp(-decay * t) * (c * math.cos(speed * t) + s * math.sin(speed * t))
        assert instance["x"] == pytest.approx(x, abs=1e-7)

    def test_tunable_parameters(self, load: Load) -> None:
        instance = load().initialise()
        instance.step(0.0, 0.1)
        instance.set({"stiffness": 60.0})
        assert instance["frequency"] == math.sqrt(30.0)
        assert instance["pull"] == 60.0 * instance["x"]
        answers(ERROR, lambda: instance.set({"mass": 3.0}))
        assert "mass is fixed after initialization" in instance.last_error

    @pytest.mark.parametrize("native", [True, False])
    @pytest.mark.parametrize("method", ["rk45", "dop853", "rodas", "rk4"])
    def test_methods(self, tmp_path: Path, method: str, native: bool) -> None:
        """Each is `simulate` by the same method to the bit, where no step is cut."""
        path = build_fmu(pendulum(), tmp_path / "p.fmu", native=native, method=method)
        name = "body.lower.theta"
        step = 0.01 if method == "rk4" else None  # as it is built by default
        motion = with_outputs(pendulum(), ["body.*"])  # no powers: FMUs integrate no works
        expected = simulate(
            motion, stop_time=1.0, output_interval=1.0, method=method, step_size=step
        )
        with Instance(path, tmp_path / "p") as instance:
            instance.initialise(tolerance=1e-8)
            instance.step(0.0, 1.0)
            assert instance[name] == expected[name][-1]

    @pytest.mark.parametrize("native", [True, False])
    def test_fixed_steps(self, tmp_path: Path, native: bool) -> None:
        """Each communication step in equal parts, as `simulate` between its output times."""
        expected = simulate(
            driven(), stop_time=1.0, output_interval=0.1, method="rk4", step_size=0.03
        )
        path = build_fmu(driven(), tmp_path / "p.fmu", native=native, method="rk4", step_size=0.03)
        with Instance(path, tmp_path / "p") as instance:
            assert float(instance.description.defaultExperiment.stepSize) == 0.03
            instance.initialise()
            for k in range(10):
                instance.step(0.1 * k, 0.1 * (k + 1) - 0.1 * k)
            assert instance["x"] == expected["x"][-1]

    def test_in_the_master(self, fmus: dict[str, Path], tmp_path: Path) -> None:
        """Two coupled oscillators with held inputs, native or in Python: the same bits."""
        found = []
        for name in ("driven", "python"):
            parts = tuple(Component(c, FmuFile(fmus[name]), {}) for c in ("first", "second"))
            links = ("first.x -> second.lift", "second.swing -> first.lift")
            results = tmp_path / f"{name}.nc"
            run(
                System(name, parts, links, Simulation(2.0, 0.05, algorithm="gauss_seidel")),
                results=results,
            )
            found.append(load_results(results))
        first, second = found
        for component, variables in first.components.items():
            assert set(variables) == set(second.components[component])
            for name, series in variables.items():
                np.testing.assert_array_equal(
                    series.values, second.components[component][name].values
                )

    def test_reset(self, load: Load) -> None:
        instance = load().initialise({"stiffness": 50.0})
        instance.step(0.0, 0.5)
        instance.fmu.reset()
        instance.initialise()
        instance.step(0.0, 0.5)
        again = load().initialise()
        again.step(0.0, 0.5)
        assert instance["x"] == again["x"]

    def test_a_hundred_instances_in_threads(self, fmus: dict[str, Path], tmp_path: Path) -> None:
        with Instance(fmus["pendulum"], tmp_path / "one") as alone:
            library, guid = alone.fmu.dll, alone.description.guid.encode()
            resources = (alone.folder / "resources").as_uri().encode()
            reference = (ctypes.c_uint * 1)(alone.references["body.lower.theta"])
            found: list[float] = []

            def run(k: int) -> None:
                make = library.fmi2Instantiate
                callbacks = ctypes.byref(alone.callbacks)
                c = ctypes.c_void_p(make(b"%d" % k, 1, guid, resources, callbacks, 0, 0))
                library.fmi2EnterInitializationMode(c)
                library.fmi2ExitInitializationMode(c)
                for i in range(50):
                    library.fmi2DoStep(c, ctypes.c_double(0.01 * i), ctypes.c_double(0.01), 1)
                value = (ctypes.c_double * 1)()
                library.fmi2GetReal(c, reference, ctypes.c_size_t(1), value)
                library.fmi2FreeInstance(c)
                found.append(value[0])

            threads = [threading.Thread(target=run, args=(k,)) for k in range(100)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            alone.initialise()
            for i in range(50):
                alone.step(0.01 * i, 0.01)
            assert found == [alone["body.lower.theta"]] * 100


class TestDerivatives:
    def test_directional_derivatives_are_exact(self, load: Load) -> None:
        instance = load().initialise({"x": 0.2, "v": -0.3, "lift": 0.5})
        r = instance.references

        def slope(unknown: str, known: str, seed: float = 1.0) -> float:
            get = instance.fmu.getDirectionalDerivative
            return get([r[unknown]], [r[known]], [seed])[0]

        assert slope("a", "force", 3.0) == 1.5
        assert slope("a", "x") == -15.0
        assert slope("energy", "x") == pytest.approx(6.0, rel=1e-15)
        assert slope("der(x)", "v") == 1.0
        assert slope("x", "x", 7.0) == 7.0
        assert slope("pull", "stiffness") == pytest.approx(0.2, rel=1e-15)
        assert slope("frequency", "mass") == pytest.approx(-math.sqrt(15.0) / 4.0, rel=1e-15)
        instance.set({"stiffness": 60.0})
        assert slope("a", "x") == -30.0
        for unknown, known in (("force", "x"), ("x", "energy"), ("mass", "x")):
            answers(ERROR, lambda u=unknown, k=known: slope(u, k))

    def test_derivatives_of_a_pendulum_as_differences(
        self, fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        model, r = exchange(fmus["pendulum"], tmp_path / "pendulum")
        model.enterContinuousTimeMode()
        description: Any = fmpy.read_model_description(str(fmus["pendulum"]))
        states = [r[d.variable.derivative.name] for d in description.derivatives]
        rates = [d.variable.valueReference for d in description.derivatives]
        n = len(states)
        x, dx = (ctypes.c_double * n)(0.4, -0.7, 0.9, 0.2), (ctypes.c_double * n)()

        def evaluated(moved: np.ndarray) -> np.ndarray:
            model.setContinuousStates((ctypes.c_double * n)(*moved), n)
            model.getDerivatives(dx, n)
            return np.array(dx)

        at = np.array(x)
        for k in range(n):
            step = 1e-5 * np.eye(n)[k]  # error of central differences here: about 1e-9
            expected = (evaluated(at + step) - evaluated(at - step)) / 2e-5
            evaluated(at)
            found = model.getDirectionalDerivative(rates, [states[k]], [1.0])
            np.testing.assert_allclose(found, expected, atol=1e-7)
            values = model.getReal(rates)
            np.testing.assert_array_equal(values, evaluated(at))
        model.terminate()
        model.freeInstance()

    def test_stiff_method_with_inputs_that_move(self, tmp_path: Path) -> None:
        """As above by RODAS: error per step below 1e-8, so below 1e-5 in some hundred steps."""
        path = build_fmu(driven(), tmp_path / "p.fmu", native=True, method="rodas")
        with Instance(path, tmp_path / "p") as instance:
            instance.initialise({"stiffness": 0.0, "damping": 0.0, "x": 0.0})
            r = instance.references["force"]
            instance.fmu.setRealInputDerivatives([r, r], [1, 2], [2.0, 6.0])
            instance.step(0.0, 2.0)
            assert instance["x"] == pytest.approx((2.0 + 8.0 / 3.0 + 4.0) / 2.0, abs=1e-5)

    def test_fixed_steps_with_inputs_that_move(self, tmp_path: Path) -> None:
        """One step is exact: x is a polynomial of degree four in time, the method's order."""
        path = build_fmu(driven(), tmp_path / "p.fmu", native=True, method="rk4", step_size=2.0)
        with Instance(path, tmp_path / "p") as instance:
            instance.initialise({"stiffness": 0.0, "damping": 0.0, "x": 0.0})
            r = instance.references["force"]
            instance.fmu.setRealInputDerivatives([r, r], [1, 2], [2.0, 6.0])
            instance.step(0.0, 2.0)
            assert instance["x"] == pytest.approx((2.0 + 8.0 / 3.0 + 4.0) / 2.0, rel=1e-14)

    def test_inputs_follow_their_derivatives(self, load: Load) -> None:
        """Without spring and damper x'' = force/2: a force of 1 + 2 t + 3 t² gives a polynomial."""
        instance = load().initialise({"stiffness": 0.0, "damping": 0.0, "x": 0.0})
        r = instance.references["force"]
        instance.set({"force": 1.0})
        instance.fmu.setRealInputDerivatives([r, r], [1, 2], [2.0, 6.0])
        instance.step(0.0, 2.0)
        assert instance["x"] == pytest.approx((2.0 + 8.0 / 3.0 + 4.0) / 2.0, rel=1e-9)
        assert instance["force"] == 17.0
        derivative = instance.fmu.getRealOutputDerivatives([instance.references["a"]], [1])
        assert derivative == [7.0]  # (2 + 3·4)/2: the force still rises at the end of its curve
        v = instance["v"]
        instance.step(2.0, 1.0)  # held: derivatives are those of one step
        assert instance["v"] == pytest.approx(v + 8.5, rel=1e-9)
        for order, value in ((3, 1.0), (1, math.nan)):
            answers(
                ERROR,
                lambda o=order, v=value: instance.fmu.setRealInputDerivatives([r], [o], [v]),
            )

    def test_output_derivatives(self, load: Load) -> None:
        instance = load().initialise({"lift": 0.5, "x": 0.2, "v": 0.3})
        names = ["x", "v", "energy", "swing"]
        references = [instance.references[name] for name in names]
        found = instance.fmu.getRealOutputDerivatives(references, [1] * len(names))
        swing = 0.3 + 0.5 * 3.0
        assert found == pytest.approx([0.3, instance["a"], 30.0 * 0.2 * 0.3, swing], rel=1e-14)
        answers(ERROR, lambda: instance.fmu.getRealOutputDerivatives(references, [2] * len(names)))


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
    def test_rollback(self, load: Load) -> None:
        instance = load().initialise()
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

    def test_into_another_instance_and_process(
        self, load: Load, fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        first, second = load().initialise({"stiffness": 41.0}), load()
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
            fmu=str(fmus["driven"]),
            folder=str(tmp_path / "other"),
            bytes=str(tmp_path / "state"),
        )
        run = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        )
        assert run.stdout.split()[-2:] == [first["x"].hex(), first["v"].hex()]

    def test_foreign_and_damaged_states_are_refused(self, load: Load) -> None:
        instance, other = load().initialise(), load("fragile").initialise()
        state = instance.fmu.getFMUstate()
        answers(ERROR, lambda: other.fmu.setFMUstate(state))
        content = bytearray(instance.fmu.serializeFMUstate(state))
        for place in range(0, len(content), 7):
            damaged = bytearray(content)
            damaged[place] ^= 1
            answers(ERROR, lambda d=damaged: instance.fmu.deSerializeFMUstate(bytes(d)))
        answers(ERROR, lambda: instance.fmu.deSerializeFMUstate(bytes(content[:-1])))
        instance.fmu.freeFMUstate(state)


class TestRefusals:
    def test_a_call_in_the_wrong_state(self, load: Load) -> None:
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
        instance = load()
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
        self, fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        model, r = exchange(fmus["driven"], tmp_path / "driven")
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

    def test_nan_and_infinity(self, load: Load) -> None:
        instance = load().initialise()
        for value in (math.nan, math.inf, -math.inf):
            for name in ("force", "stiffness"):
                answers(ERROR, lambda n=name, v=value: instance.set({n: v}))
                assert f"{name} was set to" in instance.last_error
            answers(ERROR, lambda v=value: instance.step(v, 0.1))
            answers(ERROR, lambda v=value: instance.step(0.0, v))
        instance.step(0.0, 0.1)  # nothing was changed
        assert instance["force"] == 1.0

    def test_steps_that_do_not_follow(self, load: Load) -> None:
        instance = load()
        instance.initialise(stopTime=1.0)
        for t, h in ((0.5, 0.1), (0.0, 0.0), (0.0, -0.1), (0.0, 1.1)):
            answers(ERROR, lambda t=t, h=h: instance.step(t, h))
        instance.step(0.0, 1.0)

    def test_what_is_no_variable(self, load: Load) -> None:
        instance = load().initialise()
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

    def test_a_step_that_cannot_be_finished(self, load: Load) -> None:
        """x = 1/(1 − t): the solver comes close to t = 1 and says how close."""
        instance = load("fragile").initialise()
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

    def test_rates_and_outputs_that_are_not_finite(self, load: Load) -> None:
        instance = load("fragile").initialise({"rate": -1.0})
        answers(DISCARD, lambda: instance["inverse"])
        assert "inverse is inf at t = 0 s" in instance.last_error
        answers(DISCARD, lambda: instance.step(0.0, 0.1))
        assert instance.last_error == "a state or its rate is not finite at t = 0 s: x"

    def test_log_categories(self, load: Load) -> None:
        instance = load()
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
    fmus: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """FMPy has one logger for the whole process: that of tests/support outlives its instances."""
    with Instance(fmus["driven"], tmp_path / "gone") as instance:
        instance.initialise()
    del instance
    gc.collect()
    model, _ = exchange(fmus["driven"], tmp_path / "driven")
    model.setDebugLogging(True, [])
    answers(ERROR, lambda: model.setContinuousStates((ctypes.c_double * 2)(), 2))
    assert "in event mode" in capsys.readouterr().out


def test_folders_of_any_name(fmus: dict[str, Path], tmp_path: Path) -> None:
    folder = tmp_path / "a b é # % [x] &+,;=' 100%25"
    with Instance(fmus["driven"], folder) as instance:
        instance.initialise().step(0.0, 0.1)
        assert instance.last_error == ""


def test_missing_files_are_named(fmus: dict[str, Path], tmp_path: Path) -> None:
    with Instance(fmus["driven"], tmp_path / "x") as instance:
        (instance.folder / "resources" / "tangent.m4e").unlink()
        instance.initialise()
        r = instance.references
        answers(ERROR, lambda: instance.fmu.getDirectionalDerivative([r["a"]], [r["x"]], [1.0]))
        assert "tangent.m4e cannot be read" in instance.last_error
