"""Frames and signs of the planar models, each pinned by one small case."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import pytest
import sympy as sp
from support.programs import Evaluated

from m4e_fmi.model import (
    Body,
    BodyForce,
    Joint,
    Model,
    Parameter,
    Point,
    TensionDamper,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
)
from m4e_fmi.multibody import Equations, model_program
from m4e_fmi.space import ABOUT_Y, Rotation, Y, cross, outward

ROUNDING = 1e-14  # relative: a few dozen operations in double precision
G = 9.81


def link(**fields: Any) -> Evaluated:
    """One body on a revolute joint at the origin, its CG 0.5 m below, m = 2 kg, J = 0.3 kg m²."""
    model = Model(
        name="link",
        gravity=fields.pop("gravity", G),
        bodies={"link": Body(2.0, 0.3)},
        joints={"pin": Joint("revolute", "link", joint_to_child=(0, -0.5))},
        **fields,
    )
    return Evaluated(model_program(model))


def free(**fields: Any) -> Evaluated:
    """One floating body, m = 2 kg, J = 0.3 kg m², without gravity."""
    joints = {"sea": Joint("floating", "body")}
    model = Model(
        name="free", gravity=0.0, bodies={"body": Body(2.0, 0.3)}, joints=joints, **fields
    )
    return Evaluated(model_program(model))


def pair(**fields: Any) -> Evaluated:
    """Two equal bodies (m = 2 kg, J = 0.3 kg m²) that turn about their CGs, no gravity."""
    model = Model(
        name="pair",
        gravity=0.0,
        bodies={"first": Body(2.0, 0.3), "second": Body(2.0, 0.3)},
        joints={"a": Joint("revolute", "first"), "b": Joint("revolute", "second", "first")},
        **fields,
    )
    return Evaluated(model_program(model))


@pytest.mark.verifies(
    "sense of rotation, arms and moments",
    analytic="one small case each, by hand",
    tolerance="1e-14",
)
class TestRotation:
    def test_positive_angles_turn_z_towards_x(self) -> None:
        turned = Rotation.about_axis(Y, 0.1)
        assert turned((0, 0, 1.0)) == (sin(0.1), 0, cos(0.1))
        assert turned((1.0, 0, 0)) == (cos(0.1), 0, -sin(0.1))
        assert turned((0, 1.0, 0)) == (0, 1.0, 0)

    def test_an_arm_that_turns_changes_by_the_cross_product(self) -> None:
        theta, x, y, z = sp.symbols("theta x y z")
        arm = Rotation.about_axis(Y, theta)((x, y, z))
        for found, expected in zip(cross(ABOUT_Y, arm), arm, strict=True):
            assert sp.simplify(sp.diff(expected, theta) - found) == 0

    def test_moment_about_y_is_z_times_fx_minus_x_times_fz(self) -> None:
        assert cross((2.0, 0, 3.0), (5.0, 0, 7.0)) == (0, 3 * 5 - 2 * 7, 0)

    def test_turning_twice_is_what_it_would_throw_out(self) -> None:
        omega, arm = (1.0, -2.0, 3.0), (5.0, 7.0, -11.0)
        inwards = cross(omega, cross(omega, arm))
        assert outward(omega, arm) == tuple(-part for part in inwards)

    def test_a_hanging_link_with_positive_angle_has_its_cg_at_negative_x(self) -> None:
        values = link().outputs({"joint.pin.q": 0.1})
        assert values["body.link.x"] == pytest.approx(-0.5 * sin(0.1), rel=ROUNDING)
        assert round(values["body.link.x"], 4) == -0.0499
        assert values["body.link.z"] == pytest.approx(-0.5 * cos(0.1), rel=ROUNDING)


@pytest.mark.verifies(
    "signs and axes of gravity, forces, moments and efforts",
    analytic="one small case each, by hand",
    tolerance="1e-14",
)
class TestForces:
    def test_gravity_pulls_down_and_back(self) -> None:
        assert free().rates({})["body.body.vz"] == 0.0
        model = Model(
            name="falling",
            gravity=G,
            bodies={"body": Body(2.0, 0.3)},
            joints={"sea": Joint("floating", "body")},
        )
        rates = Evaluated(model_program(model)).rates({"body.body.theta": 0.4})
        assert rates["body.body.vz"] == pytest.approx(-G, rel=ROUNDING)
        assert rates["body.body.vx"] == rates["body.body.omega"] == 0.0
        expected = -2 * G * 0.5 * sin(0.1) / (0.3 + 2 * 0.25)
        got = link().rates({"joint.pin.q": 0.1})["joint.pin.u"]
        assert got == pytest.approx(expected, rel=ROUNDING)

    def test_positive_moment_turns_forward(self) -> None:
        rates = link().rates({"body.link.moment_y": 1.0})
        assert rates["joint.pin.u"] == pytest.approx(1 / (0.3 + 2 * 0.25), rel=ROUNDING)

    @pytest.mark.parametrize("theta", [0.0, 0.7, -2.0, pi])
    def test_a_force_at_a_point_has_a_moment_about_the_cg(self, theta: float) -> None:
        """F_x = 1 at the local point (0, 1): M_y = +cos θ, and F_x itself at the CG."""
        body = free(points={"top": Point("body", (0, 1))})
        rates = body.rates({"point.top.force_x": 1.0, "body.body.theta": theta})
        assert rates["body.body.omega"] == pytest.approx(cos(theta) / 0.3, rel=ROUNDING)
        assert rates["body.body.vx"] == pytest.approx(0.5, rel=ROUNDING)
        rates = body.rates({"point.top.force_z": 1.0, "body.body.theta": theta})
        assert rates["body.body.omega"] == pytest.approx(-sin(theta) / 0.3, rel=ROUNDING)

    def test_loads_are_in_world_axes_and_add_to_inputs(self) -> None:
        body = free(loads={"push": BodyForce("body", (3.0, "t"), -0.6)})
        rates = body.rates({"body.body.theta": 1.0, "body.body.force_x": 1.0}, t=5.0)
        assert rates["body.body.vx"] == pytest.approx((3 + 1) / 2, rel=ROUNDING)
        assert rates["body.body.vz"] == pytest.approx(5 / 2, rel=ROUNDING)
        assert rates["body.body.omega"] == pytest.approx(-0.6 / 0.3, rel=ROUNDING)

    def test_an_effort_acts_on_the_child_and_back_on_the_parent(self) -> None:
        rates = pair().rates({"joint.b.effort": 0.9})
        assert rates["joint.b.u"] == pytest.approx(0.9 / 0.3, rel=ROUNDING)
        assert rates["joint.a.u"] == pytest.approx(-0.9 / 0.3, rel=ROUNDING)
        rates = pair().rates({"joint.a.effort": 0.9})  # from the ground
        assert rates["joint.a.u"] == pytest.approx(0.9 / 0.3, rel=ROUNDING)
        assert rates["joint.b.u"] == 0.0

    def test_an_effort_pushes_a_slider_along_its_direction(self) -> None:
        joint = Joint("prismatic", "body", direction=(3, -4))
        model = Model(
            name="slider", gravity=0.0, bodies={"body": Body(2.0, 0.3)}, joints={"rail": joint}
        )
        slider = Evaluated(model_program(model))
        assert slider.rates({"joint.rail.effort": 5.0})["joint.rail.u"] == pytest.approx(2.5)
        place = slider.outputs({"joint.rail.q": 10.0})
        assert place["body.body.x"] == pytest.approx(6.0, rel=ROUNDING)
        assert place["body.body.z"] == pytest.approx(-8.0, rel=ROUNDING)


@pytest.mark.verifies(
    "signs of springs and dampers", analytic="one small case each, by hand", tolerance="1e-14"
)
class TestSpringsAndDampers:
    """Force or moment on the first end, the opposite on the second."""

    POINTS = {"wall": Point("ground", (0, 0)), "eye": Point("body", (0, 0))}  # noqa: RUF012

    def test_tension_spring_pulls_when_long_and_pushes_when_short(self) -> None:
        body = free(points=self.POINTS, loads={"k": TensionSpring(("wall", "eye"), 10.0, 2.0)})
        for x, force in ((3.0, -10.0), (1.5, 5.0), (-3.0, 10.0)):
            rates = body.rates({"body.body.x": x})
            assert rates["body.body.vx"] == pytest.approx(force / 2, rel=ROUNDING)
        values = body.outputs({"body.body.x": 3.0})
        assert values["energy.potential"] == pytest.approx(5.0, rel=ROUNDING)

    def test_tension_damper_resists_lengthening_only(self) -> None:
        body = free(points=self.POINTS, loads={"c": TensionDamper(("wall", "eye"), 4.0)})
        rates = body.rates({"body.body.x": 2.0, "body.body.vx": 3.0, "body.body.vz": 7.0})
        assert rates["body.body.vx"] == pytest.approx(-6.0, rel=ROUNDING)
        assert rates["body.body.vz"] == 0.0

    def test_torsion_spring_rests_where_the_second_angle_leads_by_its_angle(self) -> None:
        body = pair(loads={"k": TorsionSpring(("first", "second"), 6.0, 0.2)})
        at_rest = body.rates({"joint.a.q": 0.1, "joint.b.q": 0.1 + 0.2})
        assert abs(at_rest["joint.a.u"]) < 1e-14
        twisted = body.rates({"joint.a.q": 0.1, "joint.b.q": 0.8})
        assert twisted["joint.a.u"] == pytest.approx(+6 * 0.5 / 0.3, rel=ROUNDING)
        assert twisted["joint.b.u"] == pytest.approx(-6 * 0.5 / 0.3, rel=ROUNDING)

    def test_torsion_damper_pulls_the_first_after_the_second(self) -> None:
        body = pair(loads={"c": TorsionDamper(("first", "second"), 6.0)})
        rates = body.rates({"joint.a.u": 1.0, "joint.b.u": 1.5})
        assert rates["joint.a.u"] == pytest.approx(+6 * 0.5 / 0.3, rel=ROUNDING)
        assert rates["joint.b.u"] == pytest.approx(-6 * 0.5 / 0.3, rel=ROUNDING)

    def test_the_ground_does_not_turn(self) -> None:
        body = pair(loads={"k": TorsionSpring(("ground", "first"), 6.0)})
        assert body.rates({"joint.a.q": 0.5})["joint.a.u"] == pytest.approx(-10.0, rel=ROUNDING)

    def test_a_slider_has_the_angle_of_its_parent(self) -> None:
        model = Model(
            name="telescope",
            gravity=0.0,
            bodies={"tube": Body(2.0, 0.3), "rod": Body(1.0, 0.1)},
            joints={
                "pin": Joint("revolute", "tube"),
                "rail": Joint("prismatic", "rod", "tube", direction=(1, 0)),
            },
            loads={"k": TorsionSpring(("ground", "rod"), 6.0)},
        )
        telescope = Evaluated(model_program(model))
        rates = telescope.rates({"joint.pin.q": 0.5})
        assert rates["joint.pin.u"] == pytest.approx(-6 * 0.5 / (0.3 + 0.1), rel=ROUNDING)
        assert telescope.outputs({"joint.pin.q": 0.5})["body.rod.theta"] == 0.5


class TestGeometry:
    def test_angles_are_absolute(self) -> None:
        model = Model(
            name="chain",
            bodies={"a": Body(1, 1), "b": Body(1, 1)},
            joints={
                "one": Joint("revolute", "a", joint_to_child=(0, -1)),
                "two": Joint("revolute", "b", "a", parent_to_joint=(0, -1), joint_to_child=(0, -1)),
            },
        )
        values = Evaluated(model_program(model)).outputs({"joint.one.q": 0.5, "joint.two.q": 0.2})
        assert values["body.b.theta"] == 0.2
        assert values["body.b.x"] == pytest.approx(-2 * sin(0.5) - sin(0.2), rel=ROUNDING)
        assert values["body.b.z"] == pytest.approx(-2 * cos(0.5) - cos(0.2), rel=ROUNDING)

    def test_geometry_is_given_in_the_pose_zero(self) -> None:
        """At q = 0 every arm is a world vector; from the origin, for the ground."""
        model = Model(
            name="arm",
            bodies={"a": Body(1, 1), "b": Body(1, 1)},
            joints={
                "one": Joint("revolute", "a", parent_to_joint=(5, 7), joint_to_child=(1, 2)),
                "two": Joint(
                    "prismatic",
                    "b",
                    "a",
                    parent_to_joint=(0.1, 0.2),
                    joint_to_child=(10, 20),
                    direction=(1, 0),
                ),
            },
            points={"eye": Point("b", (100, 200))},
        )
        values = Evaluated(model_program(model)).outputs({})
        assert (values["body.a.x"], values["body.a.z"]) == (6.0, 9.0)
        place = pytest.approx((6 + 0.1 + 10, 9 + 0.2 + 20), rel=ROUNDING)
        assert (values["body.b.x"], values["body.b.z"]) == place
        eye = pytest.approx((6 + 0.1 + 110, 9 + 0.2 + 220), rel=ROUNDING)
        assert (values["point.eye.x"], values["point.eye.z"]) == eye

    def test_potential_energy_is_zero_at_the_origin(self) -> None:
        values = link().outputs({"joint.pin.q": pi})
        assert values["energy.potential"] == pytest.approx(2 * G * 0.5, rel=ROUNDING)
        assert values["energy.kinetic"] == 0.0


@pytest.mark.verifies(
    "frame of the added mass, no weight of it",
    analytic="one small case each, by hand",
    tolerance="1e-14",
)
class TestAddedMass:
    @staticmethod
    def wet(**added: float) -> Evaluated:
        model = Model(
            name="wet",
            gravity=G,
            bodies={"body": Body(2.0, 0.3, added_mass=True)},
            joints={"sea": Joint("floating", "body")},
        )
        indices = {"xx": "1,1", "zz": "2,2", "xz": "1,2", "zx": "2,1", "tt": "3,3"}
        start = {f"added_mass[{indices[key]}]": value for key, value in added.items()}
        return Evaluated(model_program(model).with_start(start))

    def test_it_is_zero_unless_set(self) -> None:
        assert self.wet().rates({})["body.body.vz"] == pytest.approx(-G, rel=ROUNDING)

    def test_gravity_acts_on_the_dry_mass_only(self) -> None:
        rates = self.wet(zz=3.0).rates({})
        assert rates["body.body.vz"] == pytest.approx(-2 * G / (2 + 3), rel=ROUNDING)

    def test_it_stays_in_world_axes(self) -> None:
        """Turning the body does not turn its added mass."""
        body = self.wet(xx=6.0, zz=1.0, tt=0.2)
        for theta in (0.0, pi / 2):
            rates = body.rates(
                {"body.body.theta": theta, "body.body.force_x": 1.0, "body.body.moment_y": 1.0}
            )
            assert rates["body.body.vx"] == pytest.approx(1 / (2 + 6), rel=ROUNDING)
            assert rates["body.body.omega"] == pytest.approx(1 / (0.3 + 0.2), rel=ROUNDING)

    def test_kinetic_energy_includes_it(self) -> None:
        values = self.wet(xx=6.0, xz=1.0, zx=1.0).outputs(
            {"body.body.vx": 2.0, "body.body.vz": 3.0}
        )
        assert values["energy.kinetic"] == pytest.approx(
            (2 * (4 + 9) + 6 * 4 + 2 * 6) / 2, rel=ROUNDING
        )


class TestEquations:
    """The SymPy view is the same mechanics, in the paper's symbols."""

    MODEL = Model(
        name="telescope",
        description="Two lines\n\\input{secrets} % of description",
        gravity="g",
        parameters={
            "g": Parameter(9.81, "m/s2"),
            "L": Parameter(0.8, "m"),
            "k": Parameter(7, "N/m"),
        },
        bodies={"tube": Body(2.0, 0.3, added_mass=True), "rod": Body(1.0, 0.1)},
        joints={
            "pin": Joint("revolute", "tube", joint_to_child=(0, "-L")),
            "rail": Joint("prismatic", "rod", "tube", direction=(3, 4)),
        },
        points={"eye": Point("rod", (0.1, 0.2)), "wall": Point("ground", (5, 5))},
        loads={"k": TensionSpring(("wall", "eye"), "k", "L")},
    )

    def test_velocity_transformation_is_the_jacobian_of_positions(self) -> None:
        equations = Equations(self.MODEL)
        jacobian = equations.positions.reshape(4, 1).jacobian(equations.q)
        rows = [0, 1, 3, 4]
        difference = equations.B.extract(rows, [0, 1]) - jacobian
        assert difference.applyfunc(sp.simplify) == sp.zeros(4, 2)
        assert equations.B.extract([2, 5], [0, 1]) == sp.Matrix([[1, 0], [1, 0]])

    def test_derivative_of_the_velocity_transformation(self) -> None:
        equations = Equations(self.MODEL)
        pairs = zip(equations.q.flat(), equations.u.flat(), strict=True)
        rates = sum((sp.diff(equations.B, q) * u for q, u in pairs), sp.zeros(6, 2))
        assert (equations.B_dot - rates).applyfunc(sp.simplify) == sp.zeros(6, 2)

    def test_numbers_stay_exact(self) -> None:
        floats = Equations(self.MODEL).mass_matrix.atoms(sp.Float)
        assert not floats

    def test_no_text_of_the_user_leaves_the_comments_of_latex(self) -> None:
        lines = Equations(self.MODEL).text(latex=True).splitlines()
        assert all(line.startswith(("%", r"\[ ")) for line in lines)
        assert r"\dot{\theta}_{1}" in "\n".join(lines)
