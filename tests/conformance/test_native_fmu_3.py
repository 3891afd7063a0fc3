"""Native FMUs of FMI 3.0, as far as these differ: arrays, terminals, what happens within steps."""

from __future__ import annotations

import ctypes
import math
import zipfile
from collections.abc import Callable
from ctypes import byref, c_size_t, c_uint
from importlib.resources import files
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from lxml import etree
from support.fmu_instances import DISCARD, ERROR, Instance, answers
from support.fmu_programs import PROGRAMS
from support.plane import plane

from m4e_fmi.fmu.importer.opening import TERMINALS
from m4e_fmi.simulate import simulate

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
MOVING = {"body.ball.velocity": (0.5, -0.7)}
Load = Callable[..., Instance]
Fmu = Callable[..., Path]


@pytest.fixture
def ball(load: Load) -> Callable[..., Instance]:
    """`ball(start, …)`: an instance of `plane` that is initialised."""

    def made(start: dict[str, Any] | None = None, **arguments: Any) -> Instance:
        return load("native 3", "plane", **arguments).initialise(start or {})

    return made


class TestArrays:
    def test_shapes_starts_and_units(self, fmu: Fmu) -> None:
        description: Any = fmpy.read_model_description(str(fmu("native 3", "plane")))
        variables = {v.name: v for v in description.modelVariables}
        shapes = {name: v.shape for name, v in variables.items() if v.shape}
        assert shapes == {name: (2, 2) if name == "gain" else (2,) for name in ELEMENTS}
        position, gain = variables["body.ball.position"], variables["gain"]
        assert (position.unit, position.start) == ("m", "0.3 1.3")
        assert (gain.unit, gain.start) == (None, "1.0 0.1 0.2 1.0")
        assert "units of the elements: 1, rad, rad, 1" in gain.description
        assert variables["body.ball.acceleration"].derivative.name == "body.ball.velocity"
        assert (variables["time"].causality, variables["time"].unit) == ("independent", "s")

    @pytest.mark.parametrize("name", PROGRAMS)
    def test_every_scalar_is_an_element_of_one_variable(self, fmu: Fmu, name: str) -> None:
        scalars: Any = fmpy.read_model_description(str(fmu("native 2", name))).modelVariables
        variables: Any = fmpy.read_model_description(str(fmu("native 3", name))).modelVariables
        assert sum(math.prod(v.shape) for v in variables) == len(scalars) + 1  # time
        assert len({v.valueReference for v in variables}) == len(variables)

    def test_terminals(self, fmu: Fmu) -> None:
        """Bodies, points and joints with what goes in and out; valid by the standard's schema."""
        schema = files("fmpy") / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
        found = {}
        for name in PROGRAMS:
            with zipfile.ZipFile(fmu("native 3", name)) as archive:
                if TERMINALS not in archive.namelist():
                    continue
                root = etree.fromstring(archive.read(TERMINALS))
            etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
            found[name] = {
                t.get("name"): [m.get("memberName") for m in t] for t in root.iter("Terminal")
            }
        ball = ["force", "moment_y", "position", "velocity", "acceleration"]
        assert found["plane"] == {"body.ball": ball}
        assert set(found["pendulum"]) == {
            *("body.upper", "body.lower", "point.tip", "joint.shoulder", "joint.elbow")
        }
        assert set(found) == {"plane", "pendulum", "floating", "brick"}
        assert {"force", "moment", "quaternion", "attitude", "angular_velocity"} <= {
            *found["brick"]["body.brick"]
        }

    @pytest.mark.parametrize(("way", "error"), [("CoSimulation", 1e-8), ("ModelExchange", 1e-6)])
    def test_arrays_from_outside(self, fmu: Fmu, way: str, error: float) -> None:
        """FMPy sets a matrix and an input signal of two columns; tolerances of some tens of steps.

        CVODE is of lower order.
        """
        columns = [("time", float), ("body.ball.force", float, (2,))]
        signal = np.array([(t, (0.7, -1.0)) for t in (0.0, 2.0)], dtype=columns)
        gain = dict(zip(ELEMENTS["gain"], (1.0, 0.5, -0.25, 2.0), strict=True))
        how: dict[str, Any] = {"stop_time": 2.0, "output_interval": 0.1}
        found = fmpy.simulate_fmu(
            str(fmu("native 3", "plane")),
            fmi_type=way,
            relative_tolerance=1e-10,
            input=signal,
            start_values={"gain": list(gain.values())},
            output=["body.ball.position"],
            **how,
        )
        start = {**gain, "body.ball.force_x": 0.7, "body.ball.force_z": -1.0}
        expected = simulate(plane(), tolerance=1e-10, start_values=start, **how)
        for k, name in enumerate(ELEMENTS["body.ball.position"]):
            values = found["body.ball.position"][:, k]
            np.testing.assert_allclose(values, expected[name], atol=error, rtol=0)

    def test_states_of_model_exchange_are_in_the_order_of_the_arrays(self, load: Load) -> None:
        """Position x, z, then velocity x, z; not the program's x, vx, z, vz."""
        instance = load("native 3, exchange", "plane")
        model = instance.initialise({"body.ball.velocity": (5.0, 7.0)}).fmu
        assert model.getNumberOfContinuousStates() == 4
        assert model.getNumberOfEventIndicators() == 0
        assert instance.states().tolist() == [0.3, 1.3, 5.0, 7.0]
        model.setTime(0.25)
        instance.put_states((0.1, 0.2, 0.3, 0.4))
        rates = instance.rates().tolist()
        assert rates[:2] == [0.3, 0.4]
        assert rates[2:] == instance.get(["body.ball.acceleration"])
        assert rates[2:] == pytest.approx([-0.9, math.sin(0.5) / 2.0 - 3.6], rel=1e-15)
        assert instance["time"] == 0.25
        assert instance.nominals().min() > 0
        for count in (3, 5):
            room = (ctypes.c_double * 5)()
            answers(ERROR, lambda n=count, r=room: model.getContinuousStates(r, n))

    def test_numbers_that_do_not_fit(self, ball: Load) -> None:
        instance = ball()
        f, r = instance.fmu, instance.references["body.ball.force"]
        for call in (
            lambda: f.getFloat64([r], nValues=1),
            lambda: f.getFloat64([r], nValues=3),
            lambda: f.setFloat64([r], [1.0]),
            lambda: f.setFloat64([r], [1.0, math.nan]),
            lambda: f.getFloat64([instance.references["last_error"]]),
            lambda: f.getFloat32([r]),
            lambda: instance.set({"time": 1.0}),
            lambda: instance.set({"body.ball.acceleration": (0.0, 0.0)}),
        ):
            answers(ERROR, call)
        assert instance.get(["body.ball.force"]) == [0.0, 0.0]


class TestDerivatives:
    def test_adjoint_is_the_transpose(self, ball: Load) -> None:
        """w·(J s) = (Jᵀ w)·s to rounding, over all unknowns and knowns."""
        instance = ball(MOVING)
        r = instance.references
        unknowns = ["body.ball.acceleration", "power", "joint.post.reaction", "weight"]
        knowns = ["body.ball.force", "body.ball.velocity", "mass", "gain", "time"]
        rows, columns = (sum(map(instance.size, names)) for names in (unknowns, knowns))
        random = np.random.default_rng(1)
        w, s = random.normal(size=rows), random.normal(size=columns)
        forward = np.array(instance.slopes(unknowns, knowns, list(s)))
        lists = [r[name] for name in unknowns], [r[name] for name in knowns]
        backward = np.array(instance.fmu.getAdjointDerivative(*lists, list(w), columns))
        assert w @ forward == pytest.approx(backward @ s, rel=1e-13)

    def test_dependencies_of_elements(self, ball: Load) -> None:
        """Each is declared, and no derivative is without: by all knowns, of all unknowns."""
        instance = ball(MOVING)
        instance.set({"body.ball.force": (1.0, 2.0)})
        instance.step(0.0, 0.1)
        knowns = [
            *("time", "body.ball.force", "body.ball.moment_y"),
            *("body.ball.position", "body.ball.velocity"),
        ]
        for unknown in instance.description.outputs:
            name = unknown.variable.name
            found = set(found_kinds(instance, name))
            assert {known for _, known, _ in found} == {v.name for v in unknown.dependencies}
            for known in knowns:
                for k, seed in enumerate(np.eye(instance.size(known)).tolist()):
                    for i, slope in enumerate(instance.slopes([name], [known], seed)):
                        assert ((i + 1, known, k + 1) in found) == (slope != 0.0)
        assert found_kinds(instance, "body.ball.acceleration")[2, "time", 1] == 5
        assert found_kinds(instance, "body.ball.acceleration")[1, "body.ball.force", 2] == 3
        assert found_kinds(instance, "weight") == {(1, "mass", 1): 1}
        assert found_kinds(instance, "mass") == {}


def found_kinds(instance: Instance, name: str) -> dict[tuple[int, str, int], int]:
    """Element, known, element of the known → kind, as the FMU says it."""
    count, reference = c_size_t(), c_uint(instance.references[name])
    assert instance.call("GetNumberOfVariableDependencies", reference, byref(count)) == 0
    n = count.value
    elements, others = (c_size_t * n)(), (c_size_t * n)()
    knowns, kinds = (c_uint * n)(), (ctypes.c_int * n)()
    lists = elements, knowns, others, kinds
    assert instance.call("GetVariableDependencies", reference, *lists, c_size_t(n)) == 0
    names = {reference: name for name, reference in instance.references.items()}
    rows = zip(elements, (names[k] for k in knowns), others, strict=True)
    return dict(zip(rows, kinds, strict=True))


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
        plain, names = ball(), ["body.ball.position", "body.ball.velocity"]
        plain.step(0.0, reached)
        # other steps, of a local error of 1e-8 each, on a motion that does not amplify them
        assert instance.get(names) == pytest.approx(plain.get(names), abs=1e-6)
        watch.act = lambda _: None
        assert instance.step(reached, 3.5 - reached)[2:] == (False, 3.5)

    def test_inputs_set_within_a_step(self, ball: Load) -> None:
        """As a step that ends where the input is set."""
        watch = Watch()
        instance, plain = ball(intermediateUpdate=watch), ball()
        force = {"body.ball.force": (4.0, -1.0)}
        watch.act = lambda _: instance.set(force) if len(watch.seen) == 2 else None
        instance.step(0.0, 2.0)
        turn = watch.seen[1][0]
        plain.step(0.0, turn)
        plain.set(force)
        plain.step(turn, 2.0 - turn)
        names = ["body.ball.position", "body.ball.force"]
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

    def test_files_that_are_not_of_the_fmu(self, ball: Load) -> None:
        """Damaged lists of variables and dependencies: an error, never a crash."""
        instance = ball()
        resources, component = instance.folder / "resources", instance.fmu.component
        variables = (resources / "variables.txt").read_text()
        for text in ("", "0\n", variables + "x", variables[:-1], variables + "999\n", "7\n7\n"):
            (resources / "variables.txt").write_text(text)
            with pytest.raises(Exception, match="instantiate"):
                instance.instantiate()
            assert instance.messages[-1][1] == "variables.txt is not of this FMU"
        instance.fmu.component = component
        arguments = c_uint(1), byref(c_size_t())
        for text in ("1 1 1\n", "1 9 1 1 1\n", "2 1 1 1 1\n1 1 1 1 1\n", "1 1 1 1 7\n", "x\n"):
            (resources / "dependencies.txt").write_text(text)
            assert instance.call("GetNumberOfVariableDependencies", *arguments) == ERROR
            assert instance.messages[-1][1] == "dependencies.txt is not of this FMU"
        (resources / "dependencies.txt").write_text("")
        assert instance.call("GetNumberOfVariableDependencies", *arguments) == 0
