"""Native FMUs of FMI 2.0: description, results and derivatives."""

from __future__ import annotations

import ctypes
import math
import threading
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from support.driven import driven
from support.fmu_answers import ERROR, answers
from support.fmu_instance import Instance, dependency_kinds
from support.model_exchange import exchange
from support.native_programs import NATIVE_PROGRAMS as PROGRAMS
from support.native_programs import pendulum

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.cosim import load as load_results
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.simulate import simulate

LARGEST = 300_000
Load = Callable[..., Instance]


class TestDescription:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_no_finding(self, native_fmus: dict[str, Path], name: str) -> None:
        assert validate_fmu(str(native_fmus[name])) == []
        assert native_fmus[name].stat().st_size < LARGEST

    def test_same_variables_as_the_python_fmu(self, native_fmus: dict[str, Path]) -> None:
        def listed(name: str) -> list[str]:
            with zipfile.ZipFile(native_fmus[name]) as archive:
                root = ElementTree.fromstring(archive.read("modelDescription.xml"))
            tags = ("ModelVariables", "UnitDefinitions")
            return [ElementTree.tostring(root.find(tag) or root).decode() for tag in tags]

        assert listed("driven") == listed("python")

    def test_same_bytes_every_time(self, native_fmus: dict[str, Path], tmp_path: Path) -> None:
        again = build_fmu(driven(), tmp_path / "again.fmu", native=True)
        assert again.read_bytes() == native_fmus["driven"].read_bytes()

    def test_dependencies_and_their_kinds(self, native_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(native_fmus["driven"]))

        outputs = dependency_kinds(description.outputs)
        assert outputs["x"] == {"x": "constant"}
        assert outputs["a"] == {"force": "fixed", "x": "tunable", "v": "fixed"}
        assert outputs["height"] == {"x": "constant", "lift": "constant"}
        assert outputs["pull"] == {"x": "tunable"}
        assert outputs["energy"] == {"x": "dependent"}
        assert outputs["swing"] == {"x": "constant", "lift": "dependent"}
        assert "momentum" not in outputs
        rates = dependency_kinds(description.derivatives)
        assert list(rates) == ["der(x)", "a"]
        assert rates["der(x)"] == {"v": "constant"}
        first = dependency_kinds(description.initialUnknowns)
        both = {"stiffness": "dependent", "mass": "dependent"}
        assert first["frequency"] == both
        assert first["height"] == {"x": "constant", "lift": "constant"}
        assert first["pull"] == {"x": "dependent", "stiffness": "dependent"}

    @pytest.mark.parametrize("appended", [" ", " 1"])
    def test_a_longer_guid_is_refused(self, load_native: Load, appended: str) -> None:
        """Also by what follows the GUID in the FMU's own file."""
        fmu = load_native().fmu
        fmu.guid += appended
        with pytest.raises(Exception, match="nstantiate"):
            fmu.instantiate()

    def test_another_guid_is_refused(self, load_native: Load) -> None:
        fmu = load_native().fmu
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
    def test_as_simulate(self, native_fmus: dict[str, Path]) -> None:
        """Co-simulation and CVODE, to the tolerances of both over 2 s of a regular motion."""
        names = ["body.lower.theta", "energy.total"]
        expected = simulate(pendulum(), stop_time=2.0, output_interval=0.1, tolerance=1e-10)
        for kind, tolerance, error in (
            ("CoSimulation", 1e-10, 1e-8),
            ("ModelExchange", 1e-10, 1e-6),
        ):
            found = fmpy.simulate_fmu(
                str(native_fmus["pendulum"]),
                fmi_type=kind,
                stop_time=2.0,
                output_interval=0.1,
                relative_tolerance=tolerance,
                output=names,
            )
            for name in names:
                scale = np.abs(expected[name]).max()
                np.testing.assert_allclose(found[name], expected[name], atol=error * scale, rtol=0)

    def test_as_the_python_fmu(self, load_native: Load) -> None:
        """The same library runs both: the same bits, also with a tolerance and after a restart."""
        both = [load_native("driven"), load_native("python")]
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

    def test_parts_of_a_step(self, load_native: Load) -> None:
        """x' = v, v' = −15 x − 0.2 v + 1/2 has an exact solution; steps of any size follow it."""
        instance = load_native().initialise()
        t = 0.0
        for h in (0.3, 0.001, 0.7, 1e-6, 0.998999):
            instance.step(t, h)
            t += h
        decay, speed = 0.1, math.sqrt(15.0 - 0.01)
        rest = 1.0 / 30.0
        c, s = 0.1 - rest, decay * (0.1 - rest) / speed
        x = rest + math.exp(-decay * t) * (c * math.cos(speed * t) + s * math.sin(speed * t))
        assert instance["x"] == pytest.approx(x, abs=1e-7)

    def test_tunable_parameters(self, load_native: Load) -> None:
        instance = load_native().initialise()
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

    def test_in_the_master(self, native_fmus: dict[str, Path], tmp_path: Path) -> None:
        """Two coupled oscillators with held inputs, native or in Python: the same bits."""
        found = []
        for name in ("driven", "python"):
            parts = tuple(Component(c, FmuFile(native_fmus[name]), {}) for c in ("first", "second"))
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

    def test_reset(self, load_native: Load) -> None:
        instance = load_native().initialise({"stiffness": 50.0})
        instance.step(0.0, 0.5)
        instance.fmu.reset()
        instance.initialise()
        instance.step(0.0, 0.5)
        again = load_native().initialise()
        again.step(0.0, 0.5)
        assert instance["x"] == again["x"]

    def test_a_hundred_instances_in_threads(
        self, native_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        with Instance(native_fmus["pendulum"], tmp_path / "one") as alone:
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
    def test_directional_derivatives_are_exact(self, load_native: Load) -> None:
        instance = load_native().initialise({"x": 0.2, "v": -0.3, "lift": 0.5})
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
        self, native_fmus: dict[str, Path], tmp_path: Path
    ) -> None:
        model, r = exchange(native_fmus["pendulum"], tmp_path / "pendulum")
        model.enterContinuousTimeMode()
        description: Any = fmpy.read_model_description(str(native_fmus["pendulum"]))
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

    def test_inputs_follow_their_derivatives(self, load_native: Load) -> None:
        """Without spring and damper x'' = force/2: a force of 1 + 2 t + 3 t² gives a polynomial."""
        instance = load_native().initialise({"stiffness": 0.0, "damping": 0.0, "x": 0.0})
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

    def test_output_derivatives(self, load_native: Load) -> None:
        instance = load_native().initialise({"lift": 0.5, "x": 0.2, "v": 0.3})
        names = ["x", "v", "energy", "swing"]
        references = [instance.references[name] for name in names]
        found = instance.fmu.getRealOutputDerivatives(references, [1] * len(names))
        swing = 0.3 + 0.5 * 3.0
        assert found == pytest.approx([0.3, instance["a"], 30.0 * 0.2 * 0.3, swing], rel=1e-14)
        answers(ERROR, lambda: instance.fmu.getRealOutputDerivatives(references, [2] * len(names)))
