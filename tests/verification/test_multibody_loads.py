"""Loads: signs and axes by one small case each, motions with a solution in closed form.

Simulations have a tolerance of 1e-10 per step and some hundred steps.
"""

from __future__ import annotations

from dataclasses import replace
from math import asinh, cos, pi, sin, sinh, sqrt, tanh
from typing import Any

import numpy as np
import pytest
import sympy as sp
from support.programs import Evaluated

from m4e_fmi.analysis import linearize
from m4e_fmi.model import (
    Body,
    BodyDrag,
    BodyForce,
    Joint,
    JointEffort,
    JointFriction,
    JointStop,
    Model,
    Parameter,
    Point,
    PointDrag,
    PointForce,
    Table,
    TensionDamper,
    TensionSpring,
    TensionStop,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.model.loads import Load
from m4e_fmi.multibody import Equations, model_program
from m4e_fmi.program import jacobian
from m4e_fmi.simulate import simulate
from m4e_fmi.simulate.simulation import Simulation

ROUNDING = 1e-14
SIMULATED = 1e-7
MASS, INERTIA = 2.0, 0.3


def sliding(load: Load, **more: Any) -> Model:
    """A block of 2 kg on a rail along X, at q, without gravity."""
    return Model(
        name="block",
        gravity=0.0,
        bodies={"block": Body(MASS, INERTIA)},
        joints={"rail": Joint("prismatic", "block", direction=(1.0, 0.0))},
        points={"hook": Point("block", (0.0, 0.0)), "wall": Point("ground", (-1.0, 0.0))},
        loads={"load": load},
        **more,
    )


def pair(load: Load, coordinate: Any = "absolute") -> Model:
    """Two bodies of 0.3 kg m² that turn about their centres of gravity, without gravity."""
    return Model(
        name="pair",
        gravity=0.0,
        bodies={"first": Body(MASS, INERTIA), "second": Body(MASS, INERTIA)},
        joints={
            "a": Joint("revolute", "first"),
            "b": Joint("revolute", "second", "first", coordinate=coordinate),
        },
        loads={"load": load},
    )


def acceleration(model: Model, q: float = 0.0, u: float = 0.0, t: float = 0.0) -> float:
    state = {"joint.rail.q": q, "joint.rail.u": u}
    return Evaluated(model_program(model)).rates(state, t=t)["joint.rail.u"]


def moved(model: Model, stop: float, **start: float) -> Simulation:
    values = {f"joint.rail.{name}": value for name, value in start.items()}
    return simulate(model, stop_time=stop, start_values=values, tolerance=1e-10)


@pytest.mark.verifies(
    "laws of springs and dampers, their potential",
    analytic="the law, the work that it does",
    tolerance="1e-14",
)
class TestLaws:
    """A law is the whole tension or moment; the block's hook is at 1 + q from the wall."""

    def test_a_tension_spring_pulls_back_by_its_law(self) -> None:
        law = "5*l + 7*l**3 - 2*ld"
        model = sliding(TensionSpring(("wall", "hook"), length=0.6, law=law))
        got = acceleration(model, q=0.2, u=3.0)
        assert got == pytest.approx(-(5 * 0.6 + 7 * 0.6**3 - 6) / MASS, rel=ROUNDING)

    def test_dampers_resist_by_their_law(self) -> None:
        model = sliding(TensionDamper(("wall", "hook"), law="4*ld*abs(ld)"))
        assert acceleration(model, u=-3.0) == pytest.approx(36 / MASS, rel=ROUNDING)
        damper = TorsionDamper(("first", "second"), law="tanh(2*thetad)")
        rates = Evaluated(model_program(pair(damper))).rates({"joint.b.u": 0.4})
        assert rates["joint.a.u"] == pytest.approx(tanh(0.8) / INERTIA, rel=ROUNDING)
        assert rates["joint.b.u"] == -rates["joint.a.u"]

    def test_a_torsion_law_acts_like_the_linear_spring_it_says(self) -> None:
        linear = TorsionSpring(("first", "second"), 4.0, 0.3)
        law = TorsionSpring(("first", "second"), angle=0.3, law="4*theta")
        state = {"joint.a.q": 0.2, "joint.b.q": -0.9}
        first, second = (Evaluated(model_program(pair(load))) for load in (linear, law))
        assert first.rates(state) == second.rates(state)
        assert first.outputs(state) == second.outputs(state)

    def test_the_potential_is_the_work_of_the_law(self) -> None:
        """∫ (k l − c l³) dl = k l²/2 − c l⁴/4."""
        parameters = {"k": Parameter(50.0, "N/m"), "c": Parameter(0.25, "N/m3")}
        spring = TensionSpring(("wall", "hook"), length=1.0, law="k*l - c*l**3")
        program = Evaluated(model_program(sliding(spring, parameters=parameters)))
        for q in (0.25, -0.5, 20.0):  # in which the length 1 + q has no error
            got = program.outputs({"joint.rail.q": q})
            expected = 25.0 * q**2 - 0.0625 * q**4
            assert got["energy.potential"] == pytest.approx(expected, rel=ROUNDING)
            assert "load.load.power" not in got

    def test_what_has_no_potential_is_counted_by_its_power(self) -> None:
        """A law of ld, one that changes in time, and those that are no polynomials."""
        for law in ("3*l + ld", "3*l*t", "3*max(0, l)", "l*tanh(l)", "3*l*joint.rail.q"):
            model = sliding(TensionSpring(("wall", "hook"), length=1.0, law=law))
            program = model_program(model)
            (told,) = (v.description for v in program.outputs if v.name == "load.load.power")
            assert told.endswith("in which it has no potential")
            state = {"joint.rail.q": 0.5, "joint.rail.u": 2.0}
            got = Evaluated(program).outputs(state, t=0.7)
            assert got["energy.potential"] == 0
            force = MASS * acceleration(model, q=0.5, u=2.0, t=0.7)
            assert got["load.load.power"] == pytest.approx(2.0 * force, rel=ROUNDING)

    def test_stiffness_that_changes_has_no_potential(self) -> None:
        model = sliding(TensionSpring(("wall", "hook"), "3 + t", 1.0))
        got = Evaluated(model_program(model)).outputs({"joint.rail.q": 0.5, "joint.rail.u": 2.0})
        assert got["energy.potential"] == 0
        assert got["load.load.power"] == pytest.approx(-3.0 * 0.5 * 2.0, rel=ROUNDING)

    def test_symbolic_potential_reads_like_a_textbook(self) -> None:
        spring = TensionSpring(("wall", "hook"), length=1.0, law="k*l**3")
        equations = Equations(sliding(spring, parameters={"k": Parameter(1.0, "N/m3")}))
        k, s = sp.symbols("k S_1", real=True)
        extension = sp.sqrt((s + 1) ** 2) - 1
        assert equations.potential_energy == k * extension**4 / 4
        assert equations.load_powers == {}


class TestForces:
    @pytest.mark.parametrize("load", [
        BodyForce("body", (3.0, -1.0), 0.4, "body"),
        PointForce("top", (3.0, -1.0), "body"),
    ])  # fmt: skip
    def test_forces_in_body_axes_turn_with_the_body(self, load: Load) -> None:
        model = Model(
            name="free",
            gravity=0.0,
            bodies={"body": Body(MASS, INERTIA)},
            joints={"sea": Joint("floating", "body")},
            points={"top": Point("body", (0.0, 0.5))},
            loads={"load": load},
        )
        theta = 0.7
        rates = Evaluated(model_program(model)).rates({"body.body.theta": theta})
        x, z = 3 * cos(theta) - sin(theta), -3 * sin(theta) - cos(theta)
        assert rates["body.body.vx"] == pytest.approx(x / MASS, rel=ROUNDING)
        assert rates["body.body.vz"] == pytest.approx(z / MASS, rel=ROUNDING)
        # at the point 0.5 above: M_y = 0.5 · 3
        moment = 0.4 if isinstance(load, BodyForce) else 1.5
        assert rates["body.body.omega"] == pytest.approx(moment / INERTIA, rel=ROUNDING)

    @pytest.mark.parametrize("coordinate", ["absolute", "relative"])
    def test_a_joint_effort_is_what_the_input_is(self, coordinate: str) -> None:
        load = JointEffort("b", "3*t - 2*joint.b.u + body.first.theta")
        model = pair(load, coordinate)
        state = {"joint.b.u": 0.3, "joint.a.q": 0.8, "joint.a.u": -0.1}
        loaded = Evaluated(model_program(model)).rates(state, t=2.0)
        effort = 3 * 2.0 - 2 * 0.3 + 0.8
        bare = Evaluated(model_program(replace(model, loads={})))
        driven = bare.rates({**state, "joint.b.effort": effort})
        assert loaded == pytest.approx(driven, rel=ROUNDING)
        assert loaded["joint.a.u"] == pytest.approx(-effort / INERTIA, rel=ROUNDING)

    def test_an_expression_of_the_motion_closes_a_loop(self) -> None:
        """A PD controller written as a force: ẍ = (−8 x − 2 ẋ)/2, ω = 2, ζ = 1/4."""
        load = BodyForce("block", ("-8*body.block.x - 2*point.hook.vx", 0.0))
        result = moved(sliding(load), 3.0, q=1.0)
        rate, damped = 0.5, 2 * sqrt(1 - 1 / 16)
        t = result.time
        expected = np.exp(-rate * t) * (np.cos(damped * t) + rate / damped * np.sin(damped * t))
        assert result["joint.rail.q"] == pytest.approx(expected, abs=SIMULATED)


@pytest.mark.verifies(
    "a body slows down, drifts, reaches its terminal velocity",
    analytic="closed forms (logarithm, tanh)",
    tolerance="1e-7",
)
class TestDrag:
    def test_a_body_slows_down(self) -> None:
        """m v̇ = −c v²: v = v₀/(1 + c v₀ t/m)."""
        result = moved(sliding(BodyDrag("block", 0.6)), 5.0, u=3.0)
        expected = 3 / (1 + 0.6 * 3 * result.time / MASS)
        assert result["joint.rail.u"] == pytest.approx(expected, abs=SIMULATED)

    def test_a_point_drifts_with_the_flow(self) -> None:
        """Against a flow of 1.5 m/s the same law holds for v − 1.5."""
        result = moved(sliding(PointDrag("hook", 0.6, (1.5, 0.0))), 5.0, u=0.0)
        expected = 1.5 - 1.5 / (1 + 0.6 * 1.5 * result.time / MASS)
        assert result["joint.rail.u"] == pytest.approx(expected, abs=SIMULATED)

    def test_a_falling_body_reaches_its_terminal_velocity(self) -> None:
        """v = v∞ tanh(g t/v∞) with v∞ = √(m g/c)."""
        rail = Joint("prismatic", "block", direction=(0.0, -1.0))
        model = replace(sliding(BodyDrag("block", 0.5)), gravity=9.81, joints={"rail": rail})
        result = moved(model, 3.0)
        terminal = sqrt(MASS * 9.81 / 0.5)
        expected = terminal * np.tanh(9.81 * result.time / terminal)
        assert result["joint.rail.u"] == pytest.approx(expected, abs=SIMULATED)

    def test_drag_is_isotropic_and_acts_on_turning(self) -> None:
        model = Model(
            name="free",
            gravity=0.0,
            bodies={"body": Body(MASS, INERTIA)},
            joints={"sea": Joint("floating", "body")},
            loads={"load": BodyDrag("body", 0.7, 0.2)},
        )
        state = {"body.body.vx": 3.0, "body.body.vz": -4.0, "body.body.omega": -2.0}
        rates = Evaluated(model_program(model)).rates({**state, "body.body.theta": 0.3})
        assert rates["body.body.vx"] == pytest.approx(-0.7 * 5 * 3 / MASS, rel=ROUNDING)
        assert rates["body.body.vz"] == pytest.approx(0.7 * 5 * 4 / MASS, rel=ROUNDING)
        assert rates["body.body.omega"] == pytest.approx(0.2 * 4 / INERTIA, rel=ROUNDING)

    def test_drag_has_a_derivative_at_rest(self) -> None:
        """It is zero (but for what keeps it from being 0/0)."""
        found = jacobian(model_program(sliding(BodyDrag("block", 0.6, 0.1, (0.0, 0.0)))))
        values = Evaluated(found.program).outputs({})
        assert values["d(der(joint.rail.u))/d(joint.rail.u)"] == pytest.approx(0, abs=1e-100)


@pytest.mark.verifies(
    "a block comes to rest by smooth friction", analytic="closed form", tolerance="1e-7 m"
)
class TestFriction:
    def test_a_block_comes_to_rest(self) -> None:
        """m v̇ = −F tanh(v/v₀): sinh(v/v₀) falls off exponentially with F/(m v₀)."""
        force, scale, start = 3.0, 0.5, 2.0
        result = moved(sliding(JointFriction("rail", force, scale)), 3.0, u=start)
        decay = np.exp(-force * result.time / (MASS * scale))
        expected = scale * np.arcsinh(sinh(start / scale) * decay)
        assert result["joint.rail.u"] == pytest.approx(expected, abs=SIMULATED)
        assert asinh(sinh(1.0)) == pytest.approx(1.0)

    @pytest.mark.parametrize("coordinate", ["absolute", "relative"])
    def test_it_rubs_on_the_difference_of_the_two_bodies(self, coordinate: str) -> None:
        program = Evaluated(model_program(pair(JointFriction("b", 3.0, 0.5), coordinate)))
        second = 1.1 if coordinate == "absolute" else 1.1 - 0.4
        got = program.rates({"joint.a.u": 0.4, "joint.b.u": second})
        assert got["joint.a.u"] == pytest.approx(3 * tanh(0.7 / 0.5) / INERTIA, rel=ROUNDING)


@pytest.mark.verifies(
    "a block bounces off a stop", analytic="half a period of an oscillator", tolerance="1e-5 m"
)
class TestStops:
    def test_nothing_acts_between_the_limits(self) -> None:
        model = sliding(JointStop("rail", 100.0, -0.5, 0.5, 10.0))
        for q, u in ((0.0, 3.0), (0.5, 3.0), (-0.5, -3.0), (0.49, -3.0)):
            assert acceleration(model, q, u) == 0

    def test_beyond_a_limit_it_pushes_back_and_never_pulls(self) -> None:
        model = sliding(JointStop("rail", 100.0, -0.5, 0.5, 10.0))
        assert acceleration(model, 0.6, 0.2) == pytest.approx(-(10 + 2) / MASS, rel=1e-13)
        assert acceleration(model, -0.6, -0.2) == pytest.approx((10 + 2) / MASS, rel=1e-13)
        # damping is bounded by what stiffness does: no more than twice that, and no pull
        assert acceleration(model, 0.6, 9.0) == pytest.approx(-20 / MASS, rel=1e-13)
        assert acceleration(model, 0.6, -9.0) == 0
        assert acceleration(model, -0.6, 9.0) == 0

    @pytest.mark.parametrize("q", [0.0, 0.2])
    def test_without_contact_it_has_no_damping_at_rest(self, q: float) -> None:
        """Bounds of the damping and the speed are all 0 there."""
        model = sliding(JointStop("rail", 100.0, -0.5, 0.5, 10.0))
        linear = linearize(model, at={"joint.rail.q": q})
        assert linear.A[1].tolist() == [0.0, 0.0]
        inside = linearize(model, at={"joint.rail.q": 0.6, "joint.rail.u": 0.1})
        assert inside.A[1] == pytest.approx([-100.0 / MASS, -10.0 / MASS], rel=1e-13)

    def test_a_block_bounces_off(self) -> None:
        """It touches for half a period, π√(m/k), as deep as v√(m/k), and leaves as it came."""
        stiffness, speed = 5000.0, 1.5
        period = sqrt(MASS / stiffness)
        model = sliding(JointStop("rail", stiffness, upper=0.3))
        contact = 0.3 / speed
        result = simulate(
            model,
            stop_time=contact + pi * period + 0.1,
            output_interval=1e-3,
            start_values={"joint.rail.u": speed},
            tolerance=1e-10,
        )
        # the kink of the force costs an error of about the step at it
        assert result["joint.rail.u"][-1] == pytest.approx(-speed, abs=1e-5)
        assert result["joint.rail.q"][-1] == pytest.approx(0.3 - 0.1 * speed, abs=1e-5)
        assert result["joint.rail.q"].max() == pytest.approx(0.3 + speed * period, abs=1e-4)
        energy = result["energy.total"]
        assert energy == pytest.approx(np.full_like(energy, 0.5 * MASS * speed**2), abs=1e-5)

    def test_a_rope_is_slack_until_it_is_long(self) -> None:
        """The wall is at −1: the rope of 1.5 m is tight from q = 0.5."""
        model = sliding(TensionStop(("wall", "hook"), 40.0, upper=1.5))
        assert acceleration(model, q=0.4) == 0
        assert acceleration(model, q=0.75) == pytest.approx(-40 * 0.25 / MASS, rel=1e-13)

    def test_a_bumper_keeps_points_apart(self) -> None:
        model = sliding(TensionStop(("wall", "hook"), 40.0, lower=0.8, damping=1.0))
        assert acceleration(model, q=-0.1) == 0
        assert acceleration(model, q=-0.3) == pytest.approx(40 * 0.1 / MASS, rel=1e-13)
        assert acceleration(model, q=-0.3, u=-1.0) == pytest.approx((4 + 1) / MASS, rel=1e-13)

    @pytest.mark.parametrize("coordinate", ["absolute", "relative"])
    def test_a_hinge_is_stopped_by_its_own_angle(self, coordinate: str) -> None:
        program = Evaluated(model_program(pair(JointStop("b", 6.0, upper=0.5), coordinate)))
        second = 1.2 if coordinate == "absolute" else 1.2 - 0.4
        got = program.rates({"joint.a.q": 0.4, "joint.b.q": second})
        assert got["joint.a.u"] == pytest.approx(6 * 0.3 / INERTIA, rel=1e-13)


@pytest.mark.verifies(
    "a block is driven by a table", analytic="twice integrated by hand", tolerance="1e-7 m"
)
class TestTables:
    def test_a_block_is_driven_by_its_table(self) -> None:
        """The momentum is the area under the force: a triangle and a plateau."""
        table = Table((0.0, 1.0, 2.0, 3.0), (0.0, 6.0, 2.0, 2.0))
        model = sliding(JointEffort("rail", "push"), tables={"push": table})
        result = moved(model, 4.0)
        areas = {0.5: 0.75, 1.0: 3.0, 2.0: 7.0, 3.0: 9.0, 4.0: 11.0}
        for time, area in areas.items():
            speed = result["joint.rail.u"][round(time / 0.01)]
            assert speed == pytest.approx(area / MASS, abs=SIMULATED)

    def test_values_are_those_of_a_straight_line_in_the_unit_of_the_table(self) -> None:
        rng = np.random.default_rng(4)
        times = np.cumsum(rng.uniform(0.01, 1.0, 1000))
        values = rng.uniform(-1.0, 1.0, 1000)
        table = Table(tuple(times), tuple(values), "kN")
        model = sliding(JointEffort("rail", "push"), tables={"push": table})
        program = Evaluated(model_program(model))
        for t in (-5.0, times[0], 77.7, times[500], 333.3, times[-1], 1e4):
            expected = 1000 * np.interp(t, times, values) / MASS
            got = program.rates({}, t=float(t))["joint.rail.u"]
            # 1000 terms, each rounded to 1e-16 of 2000 N
            assert got == pytest.approx(expected, abs=1e-9)
        assert len(program.program.operations(program.program.rates)) < 5 * 1000 + 10

    def test_a_table_is_a_function_by_its_name_in_equations(self) -> None:
        table = Table((0.0, 1.0), (0.0, 6.0))
        model = sliding(JointEffort("rail", "2*push"), tables={"push": table})
        t = sp.Symbol("t", real=True)
        assert Equations(model).forcing[0] == 2 * sp.Function("push")(t)


@pytest.mark.verifies(
    "energy of a tree with all loads", analytic="integral of their power", tolerance="1e-7 J"
)
def test_the_energy_changes_by_what_the_loads_do() -> None:
    """By Simpson's rule over steps of 1 ms: its error is 1e-15/90 of a fourth derivative.

    That is below 1e8 W/s⁴, for a friction that changes its sign within 4 ms.
    """
    model = Model(
        name="swing",
        gravity="g",
        parameters={"g": Parameter(9.81, "m/s2"), "c": Parameter(0.4, "kg/m")},
        bodies={"rod": Body(2.0, 0.3), "flap": Body(1.0, 0.1)},
        joints={
            "pin": Joint("revolute", "rod", joint_to_child=(0.0, -0.5), initial={"q": 1.0}),
            "knee": Joint(
                "revolute", "flap", "rod", (0.0, -0.5), (0.0, -0.3), coordinate="relative"
            ),
        },
        points={"tip": Point("flap", (0.0, -0.3)), "wall": Point("ground", (2.0, 0.0))},
        loads={
            "spring": TensionSpring(("wall", "tip"), length=1.0, law="3*l + 2*l**3"),
            "drag": PointDrag("tip", "c", ("sin(t)", 0.0)),
            "rub": JointFriction("pin", 0.3, 0.2),
            "motor": JointEffort("knee", "-joint.knee.u + 0.5*sin(2*t)"),
            "wind": BodyForce("rod", (0.3, 0.0), "0.1*body.flap.theta", "body"),
        },
    )
    result = simulate(model, stop_time=4.0, output_interval=1e-3, tolerance=1e-11)
    powers = [result[f"load.{name}.power"] for name in model.loads if name != "spring"]
    power, energy = np.sum(powers, axis=0), result["energy.total"]
    gained = (power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) * 1e-3 / 3
    assert np.diff(energy[::2]) == pytest.approx(gained, abs=1e-7)
    assert abs(energy[-1] - energy[0]) > 1
