"""What FMUs of every kind carry by their options and models: outputs, names, words, units."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import pytest
from support.fmu_instances import ERROR, FILES, Instance, answers, discarded

from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Body, Joint, Model, Parameter, Point, TorsionDamper
from m4e_fmi.multibody import model_program

KINDS = pytest.mark.parametrize("kind", FILES)
Load = Callable[..., Instance]


def series(instance: Instance, *names: str) -> list[list[float]]:
    """Values after steps that are long enough for several of the integrator."""
    instance.initialise()
    rows = []
    for k in range(5):
        instance.step(float(k), 1.0)
        rows.append(instance.get(names))
    return rows


class TestSelection:
    @KINDS
    def test_fewer_outputs_have_the_same_values(self, load: Load, kind: str) -> None:
        names = ["height", "energy", "x", "v", "frequency"]
        chosen = load(kind, built={"outputs": ("height", "energy")})
        assert series(chosen, *names) == series(load(kind), *names)
        listed = {name: v.causality for name, v in chosen.variables.items()}
        assert {n for n, c in listed.items() if c == "output"} == {"height", "energy"}
        assert {n for n, c in listed.items() if c == "local"} == {
            *("x", "v", "der(x)", "der(v)", "last_error")
        }


@pytest.fixture(scope="module")
def pendulums(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    program, folder = model_program(pendulum()), tmp_path_factory.mktemp("pendulums")
    return {n: build_fmu(program, folder / f"{n}.fmu", **kind.build) for n, kind in FILES.items()}


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


def variables(path: Path) -> dict[str, Any]:
    description: Any = fmpy.read_model_description(str(path))
    return {v.name: v for v in description.modelVariables}


@KINDS
class TestDescription:
    def test_words_of_the_user(self, pendulums: dict[str, Path], kind: str) -> None:
        found = variables(pendulums[kind])
        assert found["m"].description == "How heavy the bob is"
        assert found["c"].description == "Parameter c"
        assert found["joint.hinge.q"].description == "Axle: coordinate Theta_1 of body bob"
        assert found["joint.hinge.effort"].description.startswith("Axle: generalised force")
        assert found["load.grease.power"].description.startswith("Old grease: power by which")
        if "3" not in kind:
            texts = [found[n].description for n in ("body.bob.x", "body.bob.force_z")]
            assert texts == [
                "The bob: position of the CG, world X",
                "The bob: force at the CG, world Z",
            ]
            reaction, end = found["joint.hinge.reaction_x"], found["point.end.vz"]
            assert reaction.description.startswith("Axle: force of the joint")
            assert end.description == "Lower end: velocity of the point, world Z"

    def test_types_and_display_units(self, pendulums: dict[str, Path], kind: str) -> None:
        """Value in the display unit = factor · value in the unit; exponents of the base units."""
        description: Any = fmpy.read_model_description(str(pendulums[kind]))
        types = {t.name: (t.quantity, t.unit, t.displayUnit) for t in description.typeDefinitions}
        assert types["SI.Angle"] == ("Angle", "rad", "deg")
        assert types["SI.AngularVelocity"] == ("AngularVelocity", "rad/s", "rpm")
        assert types["SI.Force"] == ("Force", "N", "kN")
        assert types["SI.Torque"] == ("Torque", "N.m", "kN.m")
        assert types["SI.Length"] == ("Length", "m", None)
        found = variables(pendulums[kind])
        declared = {v.declaredType.name for v in found.values() if v.declaredType}
        assert set(types) == declared
        for name, type_name, unit, display in (
            ("joint.hinge.q", "SI.Angle", "rad", "deg"),
            ("m", "SI.Mass", "kg", "t"),
            ("load.grease.moment", "SI.Torque", "N.m", "kN.m"),
        ):
            v = found[name]
            assert (v.declaredType.name, v.unit, v.displayUnit) == (type_name, unit, display)
        assert found["m"].start == "2000.0"
        units = {unit.name: unit for unit in description.unitDefinitions}
        factors = {(u, d.name): d.factor for u in units for d in units[u].displayUnits}
        half_turn = factors["rad", "deg"] * math.pi
        assert half_turn == pytest.approx(180.0, rel=1e-15)
        assert factors["rad/s", "rpm"] * 2.0 * math.pi == pytest.approx(60.0, rel=1e-15)
        assert factors["N", "kN"] == factors["N.m", "kN.m"] == factors["kg", "t"] == 1e-3
        assert all(d.offset == 0.0 for unit in units.values() for d in unit.displayUnits)
        base = units["N.m.s/rad"].baseUnit
        assert (base.kg, base.m, base.s, base.rad, base.factor) == (1, 2, -1, -1, 1.0)

    def test_limits_and_nominal_values(self, pendulums: dict[str, Path], kind: str) -> None:
        found = variables(pendulums[kind])
        limits = {n: (found[n].min, found[n].max, found[n].nominal) for n in ("m", "c")}
        assert limits == {"m": ("0.0", None, None), "c": (None, None, None)}
        # √(9.81/20) rad/s is nearer to 1 than to 0.1; 20 m to 10 m
        assert [found[n].nominal for n in ("joint.hinge.q", "joint.hinge.u")] == [None, None]
        assert (found["c"].variability, found["m"].variability) == ("tunable", "fixed")

    def test_a_mass_below_zero_is_refused(
        self, pendulums: dict[str, Path], load: Load, kind: str
    ) -> None:
        """Native at once; in Python at the next step: PythonFMU's binary has no other way."""
        instance, wrong = load(kind, pendulums[kind]), {"m": -1.0}
        if kind == "python":
            instance.initialise(wrong)
            discarded(lambda: instance.step(0.0, 0.1))
        else:
            answers(ERROR, lambda: instance.set(wrong))
            instance.initialise().step(0.0, 0.1)
        texts = [text for _, text in instance.heard()]
        assert any("m was set to -1, outside its range from 0 to inf" in text for text in texts)


@pytest.mark.parametrize("kind", ["native 2, exchange", "native 3, exchange"])
def test_nominal_values_of_the_states(load: Load, kind: str) -> None:
    """A float on a 300 m arm: 100 m, and 100 m·√(9.81/300)/s, to a power of ten each."""
    model = Model(
        name="far",
        gravity=9.81,
        bodies={"buoy": Body(1.0, 1.0)},
        joints={"sea": Joint("floating", "buoy")},
        points={"end": Point("buoy", (300.0, 0.0))},
    )
    instance = load(kind, model_program(model)).initialise()
    expected = {"x": 100.0, "z": 100.0, "theta": 1.0, "vx": 100.0, "vz": 100.0, "omega": 0.1}
    nominal = {n: expected[n.rpartition(".")[2]] for n in instance.state_names}
    listed = {n: float(instance.variables[n].nominal or 1.0) for n in nominal}
    assert listed == nominal
    found = instance.nominals().tolist()
    assert found == [nominal[n] for n in nominal for _ in range(instance.size(n))]
