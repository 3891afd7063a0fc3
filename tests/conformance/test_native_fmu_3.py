"""Native FMUs of FMI 3.0: description, results, model exchange, derivatives."""

from __future__ import annotations

import ctypes
import math
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]
from support.fmu3_instance import Instance3
from support.fmu_answers import ERROR, answers
from support.fmu_instance import Instance, dependency_kinds
from support.native_programs import NATIVE_PROGRAMS_3 as PROGRAMS
from support.native_programs import pendulum
from support.plane import plane

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.description.terminals import TERMINALS
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.simulate import simulate

LARGEST = 300_000
ELEMENTS = {
    "body.ball.force": ("body.ball.force_x", "body.ball.force_z"),
    "body.ball.position": ("body.ball.x", "body.ball.z"),
    "body.ball.velocity": ("body.ball.vx", "body.ball.vz"),
    "body.ball.acceleration": ("body.ball.ax", "body.ball.az"),
    "der(body.ball.position)": ("der(body.ball.x)", "der(body.ball.z)"),
    "joint.post.reaction": ("joint.post.reaction_x", "joint.post.reaction_z"),
    "gain": ("gain[1,1]", "gain[1,2]", "gain[2,1]", "gain[2,2]"),
}
"""Of `plane`: array → the scalars of FMI 2.0."""
Load = Callable[..., Instance3]


class TestDescription:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_no_finding(self, native_fmus_3: dict[str, Path], name: str) -> None:
        assert validate_fmu(str(native_fmus_3[name])) == []
        assert native_fmus_3[name].stat().st_size < LARGEST

    def test_arrays(self, load_native_3: Load) -> None:
        variables = load_native_3().variables
        shapes = {name: v.shape for name, v in variables.items() if v.shape}
        assert shapes == {name: (2, 2) if name == "gain" else (2,) for name in ELEMENTS}
        assert variables["body.ball.position"].unit == "m"
        assert variables["body.ball.position"].start == "0.3 1.3"
        assert variables["gain"].start == "1.0 0.1 0.2 1.0"
        assert variables["gain"].unit is None
        assert "units of the elements: 1, rad, rad, 1" in variables["gain"].description
        derivative = variables["body.ball.acceleration"].derivative
        assert derivative.name == "body.ball.velocity"
        assert variables["time"].causality == "independent"
        assert variables["time"].unit == "s"

    def test_every_scalar_is_an_element_of_one_variable(
        self, native_fmus_3: dict[str, Path], tmp_path: Path
    ) -> None:
        for name, make in PROGRAMS.items():
            path = build_fmu(make(), tmp_path / f"{name}.fmu", native=True)
            scalars: Any = fmpy.read_model_description(str(path)).modelVariables
            variables: Any = fmpy.read_model_description(str(native_fmus_3[name])).modelVariables
            sizes = [math.prod(v.shape) for v in variables]
            assert sum(sizes) == len(scalars) + 1  # time
            assert len({v.valueReference for v in variables}) == len(variables)

    def test_structure(self, load_native_3: Load) -> None:
        description = load_native_3().description

        outputs = dependency_kinds(description.outputs)
        assert outputs["body.ball.position"] == {"body.ball.position": "constant"}
        assert outputs["body.ball.acceleration"] == {
            "body.ball.force": "tunable",
            "body.ball.position": "fixed",
            "time": "dependent",
        }
        assert outputs["turn"] == {"body.ball.moment_y": "constant"}
        rates = dependency_kinds(description.derivatives)
        assert list(rates) == ["der(body.ball.position)", "body.ball.acceleration"]
        first = dependency_kinds(description.initialUnknowns)
        assert first["weight"] == {"mass": "constant"}
        assert set(first["body.ball.acceleration"]) == {
            *("time", "mass", "stiffness", "gain", "body.ball.force", "body.ball.position")
        }

    def test_terminals(self, native_fmus_3: dict[str, Path]) -> None:
        """Bodies, points and joints with what goes in and out; valid by the standard's schema."""
        schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
        found = {}
        for name, path in native_fmus_3.items():
            with zipfile.ZipFile(path) as archive:
                if TERMINALS not in archive.namelist():
                    continue
                root = etree.fromstring(archive.read(TERMINALS))
            etree.XMLSchema(etree.parse(schema)).assertValid(root)
            found[name] = {
                t.get("name"): [m.get("memberName") for m in t] for t in root.iter("Terminal")
            }
        ball = ["force", "moment_y", "position", "velocity", "acceleration"]
        assert found["plane"] == {"body.ball": ball}
        assert set(found["pendulum"]) == {
            *("body.upper", "body.lower", "point.tip", "joint.shoulder", "joint.elbow")
        }
        assert set(found) == {"plane", "pendulum", "buoy"}

    def test_same_bytes_every_time(self, native_fmus_3: dict[str, Path], tmp_path: Path) -> None:
        again = build_fmu(plane(), tmp_path / "again.fmu", native=True, fmi="3")
        assert again.read_bytes() == native_fmus_3["plane"].read_bytes()

    def test_native_only(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="native"):
            build_fmu(plane(), tmp_path / "p.fmu", fmi="3")
        with pytest.raises(InputError, match="no FMI version '4'"):
            build_fmu(plane(), tmp_path / "p.fmu", native=True, fmi="4")


class TestResults:
    @pytest.mark.parametrize(
        ("kind", "error"),
        # co-simulation: tolerance 1e-10 in some tens of steps; CVODE: the same, of lower order
        [("CoSimulation", 1e-8), ("ModelExchange", 1e-6)],
    )
    def test_as_simulate(self, native_fmus_3: dict[str, Path], kind: str, error: float) -> None:
        expected = simulate(pendulum(), stop_time=2.0, output_interval=0.1, tolerance=1e-10)
        found = fmpy.simulate_fmu(
            str(native_fmus_3["pendulum"]),
            fmi_type=kind,
            stop_time=2.0,
            output_interval=0.1,
            relative_tolerance=1e-10,
            output=["body.lower.theta", "point.tip.position"],
        )
        pairs = {
            "body.lower.theta": found["body.lower.theta"],
            "point.tip.x": found["point.tip.position"][:, 0],
            "point.tip.z": found["point.tip.position"][:, 1],
        }
        for name, values in pairs.items():
            scale = np.abs(expected[name]).max()
            np.testing.assert_allclose(values, expected[name], atol=error * scale, rtol=0)

    @pytest.mark.parametrize(("kind", "error"), [("CoSimulation", 1e-8), ("ModelExchange", 1e-6)])
    def test_arrays_from_outside(
        self, native_fmus_3: dict[str, Path], kind: str, error: float
    ) -> None:
        """FMPy sets a matrix and an input signal of two columns; limits as above."""
        columns = [("time", float), *((n, float, (2,)) for n in ["body.ball.force"])]
        signal = np.array([(t, (0.7, -1.0)) for t in (0.0, 2.0)], dtype=columns)
        gain = dict(zip(ELEMENTS["gain"], (1.0, 0.5, -0.25, 2.0), strict=True))
        found = fmpy.simulate_fmu(
            str(native_fmus_3["plane"]),
            fmi_type=kind,
            stop_time=2.0,
            output_interval=0.1,
            relative_tolerance=1e-10,
            input=signal,
            start_values={"gain": list(gain.values())},
            output=["body.ball.position"],
        )
        force = {"body.ball.force_x": 0.7, "body.ball.force_z": -1.0}
        expected = simulate(
            plane(),
            stop_time=2.0,
            output_interval=0.1,
            tolerance=1e-10,
            start_values={**gain, **force},
        )
        for k, name in enumerate(ELEMENTS["body.ball.position"]):
            values = found["body.ball.position"][:, k]
            np.testing.assert_allclose(values, expected[name], atol=error, rtol=0)

    def test_the_bits_of_fmi_2(self, load_native_3: Load, older: Instance) -> None:
        newer = load_native_3().initialise({"stiffness": 8.0}, tolerance=1e-6)
        older.initialise({"stiffness": 8.0}, tolerance=1e-6)
        for k in range(20):
            force = (math.sin(k), 0.1 * k)
            newer.set({"body.ball.force": force, "gain": (1.0, 0.2, 0.1 * k, 1.0)})
            older.set(dict(zip(ELEMENTS["body.ball.force"], force, strict=True)))
            older.set(dict(zip(ELEMENTS["gain"], (1.0, 0.2, 0.1 * k, 1.0), strict=True)))
            assert newer.step(0.1 * k, 0.1) == (False, False, False, 0.1 * k + 0.1)
            older.step(0.1 * k, 0.1)
            for name in newer.numbers():
                scalars = ELEMENTS.get(name, (name,))
                if name != "time":
                    assert newer.all(name) == list(older.get(scalars).values())
        assert newer["time"] == 0.1 * 19 + 0.1

    @pytest.mark.parametrize("method", ["rk4", "rk45", "dop853", "rodas"])
    def test_the_bits_of_simulate(self, tmp_path: Path, method: str) -> None:
        """Where no step is cut; looked at after each step of the integrator, or not."""
        how: dict[str, Any] = {"method": method}
        if method == "rk4":
            how["step_size"] = 0.03
        path = build_fmu(pendulum(), tmp_path / "p.fmu", native=True, fmi="3", **how)
        motion = with_outputs(pendulum(), ["body.*"])  # no powers: FMUs integrate no works
        expected = simulate(motion, stop_time=1.0, output_interval=1.0, **how)
        for update in (None, lambda *_: None):
            with Instance3(path, tmp_path / "p", intermediateUpdate=update) as instance:
                instance.initialise(tolerance=1e-8)
                instance.step(0.0, 1.0)
                assert instance["body.lower.theta"] == expected["body.lower.theta"][-1]

    def test_reset(self, load_native_3: Load) -> None:
        instance = load_native_3().initialise({"body.ball.position": (2.0, 1.0)})
        instance.step(0.0, 0.5)
        instance.fmu.reset()
        instance.initialise()
        instance.step(0.0, 0.5)
        again = load_native_3().initialise()
        again.step(0.0, 0.5)
        assert instance.all("body.ball.position") == again.all("body.ball.position")


class TestModelExchange:
    def test_states_are_those_of_the_arrays(self, load_native_3: Load) -> None:
        """Order: position x, z, then velocity x, z; not the program's x, vx, z, vz."""
        instance = load_native_3(kind="ModelExchange").initialise(
            {"body.ball.velocity": (5.0, 7.0)}
        )
        model = instance.fmu
        model.updateDiscreteStates()
        model.enterContinuousTimeMode()
        assert model.getNumberOfContinuousStates() == 4
        assert model.getNumberOfEventIndicators() == 0
        four = (ctypes.c_double * 4)()
        model.getContinuousStates(four, 4)
        assert list(four) == [0.3, 1.3, 5.0, 7.0]
        model.setTime(0.25)
        model.setContinuousStates((ctypes.c_double * 4)(0.1, 0.2, 0.3, 0.4), 4)
        model.getContinuousStateDerivatives(four, 4)
        assert list(four[:2]) == [0.3, 0.4]
        assert list(four[2:]) == instance.all("body.ball.acceleration")
        assert four[2] == pytest.approx(-0.9, rel=1e-15)
        assert four[3] == pytest.approx(math.sin(0.5) / 2.0 - 3.6, rel=1e-15)
        assert instance["time"] == 0.25
        model.getNominalsOfContinuousStates(four, 4)
        assert min(four) > 0
        for count in (3, 5):
            answers(ERROR, lambda n=count: model.getContinuousStates((ctypes.c_double * 5)(), n))
        assert model.completedIntegratorStep() == (False, False)
        model.terminate()

    def test_without_states(self, load_native_3: Load) -> None:
        instance = load_native_3("algebraic", kind="ModelExchange").initialise()
        instance.fmu.enterContinuousTimeMode()
        instance.set({"u": 5.0})
        assert instance["y"] == 15.0


class TestDerivatives:
    def test_directional_as_in_fmi_2(self, load_native_3: Load, older: Instance) -> None:
        newer = load_native_3().initialise({"body.ball.velocity": (0.5, -0.7)})
        older.initialise({"body.ball.vx": 0.5, "body.ball.vz": -0.7})
        unknown, known = "body.ball.acceleration", ("body.ball.position", "body.ball.force")
        seed = [0.3, -0.2, 1.0, 2.0]
        found = newer.fmu.getDirectionalDerivative(
            [newer.references[unknown]], [newer.references[k] for k in known], seed, 2
        )
        r = older.references
        expected = older.fmu.getDirectionalDerivative(
            [r[name] for name in ELEMENTS[unknown]],
            [r[name] for k in known for name in ELEMENTS[k]],
            seed,
        )
        assert found == expected

    def test_by_time(self, load_native_3: Load) -> None:
        instance = load_native_3().initialise()
        r = instance.references
        get = instance.fmu.getDirectionalDerivative
        assert get([r["body.ball.acceleration"]], [r["time"]], [3.0], 2) == [0.0, 3.0]

    def test_adjoint_is_the_transpose(self, load_native_3: Load) -> None:
        """w·(J s) = (Jᵀ w)·s to rounding, over all unknowns and knowns."""
        instance = load_native_3().initialise({"body.ball.velocity": (0.5, -0.7)})
        r = instance.references
        unknowns = ["body.ball.acceleration", "power", "joint.post.reaction", "weight"]
        knowns = ["body.ball.force", "body.ball.velocity", "mass", "gain", "time"]
        rows = sum(instance.size(name) for name in unknowns)
        columns = sum(instance.size(name) for name in knowns)
        random = np.random.default_rng(1)
        w, s = random.normal(size=rows), random.normal(size=columns)
        lists = [r[name] for name in unknowns], [r[name] for name in knowns]
        forward = np.array(instance.fmu.getDirectionalDerivative(*lists, list(s), rows))
        backward = np.array(instance.fmu.getAdjointDerivative(*lists, list(w), columns))
        assert w @ forward == pytest.approx(backward @ s, rel=1e-13)

    def test_as_differences(self, load_native_3: Load) -> None:
        instance = load_native_3("pendulum", kind="ModelExchange").initialise()
        model, r = instance.fmu, instance.references
        model.enterContinuousTimeMode()
        rates = [d.variable.valueReference for d in instance.description.derivatives]
        states = [r[d.variable.derivative.name] for d in instance.description.derivatives]
        n = len(states)
        at, dx = np.array([0.4, -0.7, 0.9, 0.2]), (ctypes.c_double * n)()

        def evaluated(x: np.ndarray) -> np.ndarray:
            model.setContinuousStates((ctypes.c_double * n)(*x), n)
            model.getContinuousStateDerivatives(dx, n)
            return np.array(dx)

        for k in range(n):
            step = 1e-5 * np.eye(n)[k]  # error of central differences here: about 1e-9
            expected = (evaluated(at + step) - evaluated(at - step)) / 2e-5
            evaluated(at)
            found = model.getDirectionalDerivative(rates, [states[k]], [1.0])
            np.testing.assert_allclose(found, expected, atol=1e-7)

    def test_of_outputs_by_time(self, load_native_3: Load) -> None:
        instance = load_native_3().initialise({"body.ball.velocity": (0.5, -0.7)})
        names = ["body.ball.position", "body.ball.velocity", "power"]
        instance.set({"body.ball.force": (1.0, 2.0)})
        r = [instance.references[name] for name in names]
        values = (ctypes.c_double * 5)()
        orders = (ctypes.c_int32 * 3)(1, 1, 1)
        arguments = (ctypes.c_uint * 3)(*r), ctypes.c_size_t(3), orders, values
        assert instance.call("GetOutputDerivatives", *arguments, ctypes.c_size_t(5)) == 0
        a = instance.all("body.ball.acceleration")
        assert list(values) == pytest.approx([0.5, -0.7, *a, a[0] + 2.0 * a[1]], rel=1e-14)
        assert instance.call("GetOutputDerivatives", *arguments, ctypes.c_size_t(4)) == ERROR
        orders[0] = 2
        assert instance.call("GetOutputDerivatives", *arguments, ctypes.c_size_t(5)) == ERROR

    def test_dependencies_of_elements(self, load_native_3: Load) -> None:
        """Each is declared, and no derivative is without: by all knowns, of all unknowns."""
        instance = load_native_3().initialise({"body.ball.velocity": (0.5, -0.7)})
        instance.set({"body.ball.force": (1.0, 2.0)})
        instance.step(0.0, 0.1)
        r = instance.references
        knowns = [
            *("time", "body.ball.force", "body.ball.moment_y"),
            *("body.ball.position", "body.ball.velocity"),
        ]
        for unknown in instance.description.outputs:
            name = unknown.variable.name
            found = dependencies(instance, name)
            declared = {v.name for v in unknown.dependencies}
            assert {known for _, known, _ in found} == declared
            for known in knowns:
                for k in range(instance.size(known)):
                    seed = [float(i == k) for i in range(instance.size(known))]
                    slopes = instance.fmu.getDirectionalDerivative(
                        [r[name]], [r[known]], seed, instance.size(name)
                    )
                    for i, slope in enumerate(slopes):
                        assert ((i + 1, known, k + 1) in found) == (slope != 0.0)
        assert found_kinds(instance, "body.ball.acceleration")[2, "time", 1] == 5
        assert found_kinds(instance, "body.ball.acceleration")[1, "body.ball.force", 2] == 3
        assert found_kinds(instance, "weight") == {(1, "mass", 1): 1}
        assert found_kinds(instance, "mass") == {}


def dependencies(instance: Instance3, name: str) -> set[tuple[int, str, int]]:
    return set(found_kinds(instance, name))


def found_kinds(instance: Instance3, name: str) -> dict[tuple[int, str, int], int]:
    """Element, known, element of the known → kind, as the FMU says it."""
    count, reference = ctypes.c_size_t(), ctypes.c_uint(instance.references[name])
    assert instance.call("GetNumberOfVariableDependencies", reference, ctypes.byref(count)) == 0
    n = count.value
    elements, others = (ctypes.c_size_t * n)(), (ctypes.c_size_t * n)()
    knowns, kinds = (ctypes.c_uint * n)(), (ctypes.c_int * n)()
    status = instance.call(
        "GetVariableDependencies", reference, elements, knowns, others, kinds, ctypes.c_size_t(n)
    )
    assert status == 0
    names = {reference: name for name, reference in instance.references.items()}
    rows = zip(elements, (names[k] for k in knowns), others, strict=True)
    return dict(zip(rows, kinds, strict=True))
