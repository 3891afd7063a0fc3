"""What an FMU carries by its options: the same in both backends, whose results agree to the bit."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy import fmi2
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from support.driven import driven
from support.fmu_instance import Instance

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import ModelDescription, PythonSource, build_fmu
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, TorsionDamper
from m4e_fmi.multibody import model_program

BACKENDS = pytest.mark.parametrize("native", [False, True], ids=["python", "native"])
STEPS = 10
STEP = 1.0  # long enough for several of the integrator

Open = Callable[..., Instance]


@pytest.fixture
def open_fmu(tmp_path: Path) -> Iterator[Open]:
    """`open_fmu(native, **options)`: an instance of the FMU of `driven` with these options."""
    with ExitStack() as stack:
        count = iter(range(100))

        def opened(native: bool, **options: Any) -> Instance:
            k = next(count)
            path = build_fmu(driven(), tmp_path / f"{k}.fmu", native=native, **options)
            assert validate_fmu(str(path)) == []
            return stack.enter_context(Instance(path, tmp_path / f"unpacked_{k}"))

        yield opened


def series(instance: Instance, *names: str, **experiment: Any) -> list[list[float]]:
    instance.initialise(**experiment)
    rows = []
    for k in range(STEPS):
        instance.step(k * STEP, STEP)
        rows.append([instance[name] for name in names])
    return rows


class TestIntegration:
    @pytest.mark.parametrize(
        "options",
        [{"method": "rk45"}, {"method": "rodas"}, {"tolerance": 2.5e-4}],
        ids=["rk45", "rodas", "tolerance"],
    )
    def test_method_and_tolerance_in_both_to_the_bit(
        self, open_fmu: Open, options: dict[str, Any]
    ) -> None:
        python, native = (series(open_fmu(n, **options), "x", "v", "a") for n in (False, True))
        assert python == native
        assert python != series(open_fmu(True), "x", "v", "a")

    @BACKENDS
    def test_the_tolerance_is_that_of_importers_who_give_none(
        self, open_fmu: Open, native: bool
    ) -> None:
        own = series(open_fmu(native, tolerance=2.5e-4), "x")
        assert own == series(open_fmu(native), "x", tolerance=2.5e-4)

    @BACKENDS
    def test_default_experiment(self, tmp_path: Path, native: bool) -> None:
        asked = {"stop_time": 3.5, "step_size": 0.25, "tolerance": 1e-6}
        path = build_fmu(driven(), tmp_path / "a.fmu", native=native, **asked)  # type: ignore[arg-type]
        description: Any = fmpy.read_model_description(str(path))
        found = description.defaultExperiment
        assert (found.stopTime, found.stepSize, found.tolerance) == ("3.5", "0.25", "1e-06")


class TestSelection:
    @BACKENDS
    def test_fewer_outputs_have_the_same_values(self, open_fmu: Open, native: bool) -> None:
        names = ["height", "energy", "x", "v", "frequency"]
        full = series(open_fmu(native), *names)
        chosen = open_fmu(native, outputs=["height", "energy"])
        assert series(chosen, *names) == full
        listed = {v.name: v.causality for v in chosen.description.modelVariables}
        assert {n for n, c in listed.items() if c == "output"} == {"height", "energy"}
        assert {n for n, c in listed.items() if c == "local"} == {
            "x", "v", "der(x)", "der(v)", "last_error",
        }  # fmt: skip

    @BACKENDS
    def test_other_names_have_the_same_values(self, open_fmu: Open, native: bool) -> None:
        full = series(open_fmu(native), "x", "energy", "a")
        table = {"x": "spring.length", "energy": "spring.energy", "mass": "m"}
        renamed = open_fmu(native, rename=table)
        assert series(renamed, "spring.length", "spring.energy", "a") == full
        derivatives = {
            v.name: v.derivative.name for v in renamed.description.modelVariables if v.derivative
        }
        assert derivatives == {
            "v": "spring.length", "a": "v", "der(spring.length)": "spring.length",
        }  # fmt: skip

    def test_errors_are_told_by_the_new_names(self, open_fmu: Open) -> None:
        instance = open_fmu(True, rename={"root": "spoilt.root"}).initialise({"x": -2.0})
        with pytest.raises(FMICallException):
            assert instance["spoilt.root"]
        assert instance.messages[-1][1].startswith("spoilt.root is ")


def test_python_code_has_no_options_of_programs(tmp_path: Path) -> None:
    source = PythonSource(ModelDescription("p", "p", ()), "slave:Slave", {}, {})
    for option in ({"outputs": ["*"]}, {"method": "rk45"}, {"rename": {"a": "b"}}):
        with pytest.raises(InputError, match="is Python code"):
            build_fmu(source, tmp_path / "p.fmu", **option)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def pendulums(tmp_path_factory: pytest.TempPathFactory) -> dict[bool, Path]:
    program, folder = model_program(pendulum()), tmp_path_factory.mktemp("pendulums")
    return {n: build_fmu(program, folder / f"{n}.fmu", native=n) for n in (False, True)}


def pendulum() -> Model:
    """20 m long under 9.81 m/s², with the user's words for everything."""
    return Model(
        name="pendulum",
        gravity=9.81,
        parameters={
            "m": Parameter(2, "t", "How heavy the bob is"),
            "c": Parameter(5.0, "N.m.s/rad", tunable=True),
        },
        bodies={"bob": Body("m", 3.0, "The\nbob")},
        joints={"hinge": Joint("revolute", "bob", joint_to_child=(0.0, -20.0), description="Axle")},
        points={"end": Point("bob", (0.0, -1.0), "Lower end")},
        loads={"grease": TorsionDamper(("ground", "bob"), damping="c", description="Old grease")},
    )


@BACKENDS
class TestDescription:
    def test_words_of_the_user(self, pendulums: dict[bool, Path], native: bool) -> None:
        texts = {v.name: v.description for v in variables(pendulums[native])}
        assert texts["m"] == "How heavy the bob is"
        assert texts["c"] == "Parameter c"
        assert texts["body.bob.x"] == "The bob: position of the CG, world X"
        assert texts["body.bob.force_z"] == "The bob: force at the CG, world Z"
        assert texts["joint.hinge.q"] == "Axle: coordinate Theta_1 of body bob"
        assert texts["joint.hinge.effort"].startswith("Axle: generalised force")
        assert texts["joint.hinge.reaction_x"].startswith("Axle: force of the joint")
        assert texts["point.end.vz"] == "Lower end: velocity of the point, world Z"
        assert texts["load.grease.power"].startswith("Old grease: power by which")

    def test_types(self, pendulums: dict[bool, Path], native: bool) -> None:
        description: Any = fmpy.read_model_description(str(pendulums[native]))
        types = {t.name: (t.quantity, t.unit, t.displayUnit) for t in description.typeDefinitions}
        assert types["SI.Angle"] == ("Angle", "rad", "deg")
        assert types["SI.AngularVelocity"] == ("AngularVelocity", "rad/s", "rpm")
        assert types["SI.Force"] == ("Force", "N", "kN")
        assert types["SI.Torque"] == ("Torque", "N.m", "kN.m")
        assert types["SI.Length"] == ("Length", "m", None)
        declared = [v.declaredType for v in variables(pendulums[native])]
        assert set(types) == {kind.name for kind in declared if kind}
        found = {v.name: v for v in variables(pendulums[native])}
        for name, kind, unit, display in (
            ("joint.hinge.q", "SI.Angle", "rad", "deg"),
            ("m", "SI.Mass", "kg", "t"),
            ("joint.hinge.reaction_z", "SI.Force", "N", "kN"),
        ):
            v = found[name]
            assert (v.declaredType.name, v.unit, v.displayUnit) == (kind, unit, display)

    def test_display_units_convert_as_the_standard_says(
        self, pendulums: dict[bool, Path], native: bool
    ) -> None:
        """Value in the display unit = factor · value in the unit; exponents of the base units."""
        description: Any = fmpy.read_model_description(str(pendulums[native]))
        units = {unit.name: unit for unit in description.unitDefinitions}
        factors = {(u, d.name): d.factor for u in units for d in units[u].displayUnits}
        half_turn = factors["rad", "deg"] * math.pi
        assert half_turn == pytest.approx(180.0, rel=1e-15)
        assert factors["rad/s", "rpm"] * 2.0 * math.pi == pytest.approx(60.0, rel=1e-15)
        assert factors["N", "kN"] == factors["N.m", "kN.m"] == factors["kg", "t"] == 1e-3
        assert all(d.offset == 0.0 for unit in units.values() for d in unit.displayUnits)
        base = units["N.m.s/rad"].baseUnit
        assert (base.kg, base.m, base.s, base.rad, base.factor) == (1, 2, -1, -1, 1.0)

    def test_minimum_and_nominal_values(self, pendulums: dict[bool, Path], native: bool) -> None:
        found = {v.name: (v.min, v.max, v.nominal) for v in variables(pendulums[native])}
        assert found["m"] == ("0.0", None, None)
        assert found["c"] == (None, None, None)
        # √(9.81/20) rad/s is nearer to 1 than to 0.1; 20 m to 10 m
        assert [found[n][2] for n in ("joint.hinge.q", "joint.hinge.u")] == [None, None]
        assert found["body.bob.x"] == (None, None, None)

    def test_a_parameter_may_change_between_steps(
        self, pendulums: dict[bool, Path], tmp_path: Path, native: bool
    ) -> None:
        variability = {v.name: v.variability for v in variables(pendulums[native])}
        assert (variability["c"], variability["m"]) == ("tunable", "fixed")
        found = []
        for damping in (5.0, 5e5):
            with Instance(pendulums[native], tmp_path / f"{damping}") as instance:
                instance.initialise({"joint.hinge.u": 0.1})
                instance.step(0.0, 0.5)
                before = instance["joint.hinge.u"]
                instance.set({"c": damping})
                instance.step(0.5, 0.5)
                found.append((before, instance["joint.hinge.u"]))
        assert found[0][0] == found[1][0]
        assert abs(found[1][1]) < abs(found[0][1])

    def test_a_mass_below_zero_is_refused(
        self, pendulums: dict[bool, Path], tmp_path: Path, native: bool
    ) -> None:
        """Native at once; in Python at the next step: PythonFMU's binary has no other way."""
        with Instance(pendulums[native], tmp_path / "unpacked") as instance:
            with pytest.raises(FMICallException) if native else nullcontext():
                instance.set({"m": -1.0})
            assert "m was set to -1, outside its range from 0 to inf" in instance.messages[-1][1]
            instance.initialise()
            with nullcontext() if native else pytest.raises(FMICallException):
                instance.step(0.0, 0.1)


def variables(path: Path) -> list[Any]:
    description: Any = fmpy.read_model_description(str(path))
    return list(description.modelVariables)


def test_nominal_values_of_the_states(tmp_path: Path) -> None:
    """A float on a 300 m arm: 100 m, and 100 m·√(9.81/300)/s, to a power of ten each."""
    model = Model(
        name="far",
        gravity=9.81,
        bodies={"buoy": Body(1.0, 1.0)},
        joints={"sea": Joint("floating", "buoy")},
        points={"end": Point("buoy", (300.0, 0.0))},
    )
    path = build_fmu(model_program(model), tmp_path / "far.fmu", native=True)
    expected = {"x": 100.0, "z": 100.0, "theta": 1.0, "vx": 100.0, "vz": 100.0, "omega": 0.1}
    listed = {v.name: v.nominal for v in variables(path)}
    assert {k: float(listed[f"body.buoy.{k}"] or 1.0) for k in expected} == expected
    description: Any = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path), str(tmp_path / "far"))
    exchange = fmi2.FMU2Model(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="far",
    )
    exchange.instantiate()
    found = (ctypes.c_double * 6)()
    exchange.fmi2GetNominalsOfContinuousStates(exchange.component, found, 6)
    exchange.freeInstance()
    states = [v.derivative.name for v in (d.variable for d in description.derivatives)]
    assert dict(zip(states, found, strict=True)) == {
        f"body.buoy.{name}": value for name, value in expected.items()
    }
