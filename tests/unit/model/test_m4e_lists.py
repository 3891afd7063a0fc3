"""The paper's lists: the listings as typed, other spellings, and everything that can be wrong."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sym
from support.paper_listings import double_pendulum, spiderfloat

from m4e_fmi.errors import InputError
from m4e_fmi.model import (
    BodyForce,
    Model,
    Parameter,
    Point,
    PointForce,
    TensionSpring,
    TorsionDamper,
    TorsionSpring,
    load_model,
    model_from_lists,
    normalize_prismatic,
)
from m4e_fmi.multibody import Equations, model_program
from m4e_fmi.simulate import simulate

EXAMPLE = Path(__file__).parents[3] / "examples" / "double_pendulum" / "double_pendulum.model.yaml"
NAN = math.nan


def cart() -> dict[str, Any]:
    """A trolley with a beam, in the short form that a file may have, too."""
    return {
        "joints": [[0, 1], [1, 2]],
        "types": ["P", "R"],
        "parent_cg_to_joint": [[0, 0], [0, 0.1]],
        "joint_to_child_cg": [[0, 0.5], [0, "-L/2"]],
        "prismatic_direction": [[2, 0], [None, None]],
        "Initial_Points": {"GR": [[3, 1]], "BD": {1: [[0.2, 0]], 2: [["L", 0], [0, 1]]}},
        "Force": {"TensionSpring": [[["BD10", "GR00"], [1, 5]]]},
        "BodyDataSym": ["L"],
        "BodyDataNum": [2.5],
        "ic": [0.1, 0.2, 0.3, 0.4],
        "m0": [1, 2],
        "J0": [3, 4],
        "g": 9.81,
    }


class TestListings:
    def test_double_pendulum_is_the_example(self) -> None:
        ours = simulate(load_model(EXAMPLE), stop_time=2.0)
        theirs = simulate(model_from_lists(double_pendulum()), stop_time=2.0)
        for mine, listed in (("shoulder", "joint_1"), ("elbow", "joint_2")):
            # the same equations with other names, and so in another order of operations
            expected = ours[f"joint.{mine}.q"]
            assert theirs[f"joint.{listed}.q"] == pytest.approx(expected, abs=1e-7)

    def test_torsion_elements_without_a_key_tension_damper(self) -> None:
        loads = model_from_lists(double_pendulum()).loads
        assert loads == {
            "CG_0": BodyForce("body_2", (20, 20), 0),
            "TorsionSpring_0": TorsionSpring(("ground", "body_1"), 50.0, -0.75 * math.pi),
            "TorsionDamper_0": TorsionDamper(("ground", "body_1"), 5.0),
            "TorsionDamper_1": TorsionDamper(("body_1", "body_2"), 5),
        }

    def test_spiderfloat(self) -> None:
        model = model_from_lists(spiderfloat(), name="spiderfloat")
        assert len(model.loads) == 3 + 6 + 2 + 2 + 2
        assert model.loads["TensionSpring_4"] == TensionSpring(("BD2_0", "GR0"), 0.1, 3.0414)
        assert model.points["CG3"] == Point("body_3", (0.0, 0.0))
        assert model.joints["joint_1"].initial == {"x": 10, "z": 6}
        states = {v.name: v.start for v in model_program(model).states if v.start}
        assert states == {"body.body_1.x": 10.0, "body.body_1.z": 6.0}

    def test_symbols_are_those_of_the_paper(self) -> None:
        equations = Equations(model_from_lists(double_pendulum()))
        names = {str(symbol) for symbol in equations.mass_matrix.free_symbols}
        assert names == {"m1", "m2", "J1", "J2", "Theta_1", "Theta_2"}

    def test_both_spellings_of_points(self) -> None:
        lists = spiderfloat()
        text = repr(lists["Force"]["TensionSpring"]) + repr(lists["Force"]["TensionDamper"])
        newer = spiderfloat()
        for kind in ("TensionSpring", "TensionDamper"):
            newer["Force"][kind] = [
                (tuple(f"{end[:3]}_{end[3:]}" for end in ends), values)
                for ends, values in lists["Force"][kind]
            ]
        assert "BD10" in text
        assert newer["Force"]["TensionDamper"][0][0] == ("GR0_0", "CG2_2")
        assert model_from_lists(newer) == model_from_lists(lists)

    def test_namespace_of_a_script(self) -> None:
        script = {**double_pendulum(), "__name__": "__main__", "np": np, "answer": 42}
        assert model_from_lists(script) == model_from_lists(double_pendulum())

    def test_yaml_and_json(self, tmp_path: Path) -> None:
        expected = model_from_lists(cart(), name="cart")
        path = tmp_path / "cart.json"
        path.write_text(json.dumps(cart()))
        assert load_model(path) == expected
        path.write_text(json.dumps({"name": "trolley", **cart()}).replace("null", ".nan"))
        assert load_model(path).name == "trolley"


class TestMeaning:
    def test_origin_moves_what_is_measured_from_the_ground(self) -> None:
        lists = {**cart(), "Reference_frame_Origin": np.array([10, 20])}
        model = model_from_lists(lists)
        assert model.joints["joint_1"].parent_to_joint == (10, 20)
        assert model.joints["joint_2"].parent_to_joint == (0, 0.1)
        assert model.points["GR0"].at == (13, 21)

    def test_a_floating_body_starts_where_its_row_says(self) -> None:
        lists = {
            "joints": [[0, 1]], "types": ["F"], "parent_cg_to_joint": [[1, 2]],
            "joint_to_child_cg": [[NAN, NAN]], "Reference_frame_Origin": [0, 0.91],
            "m0": [1], "J0": [1], "ic": [0, 0, 0.3, 4, 5, 6],
        }  # fmt: skip
        expected = {"x": 1, "z": 2.91, "theta": 0.3, "vx": 4, "vz": 5, "omega": 6}
        assert model_from_lists(lists).joints["joint_1"].initial == expected
        lists["ic"] = [1, 2, 0.3, 4, 5, 6]
        assert model_from_lists(lists).joints["joint_1"].initial == expected
        lists["parent_cg_to_joint"] = [[NAN, NAN]]
        assert model_from_lists(lists).joints["joint_1"].initial == expected

    def test_start_values_follow_the_numbers_of_the_children(self) -> None:
        lists = cart()
        lists["joints"] = lists["joints"][::-1]
        for key in ("types", "parent_cg_to_joint", "joint_to_child_cg", "prismatic_direction"):
            lists[key] = lists[key][::-1]
        assert model_from_lists(lists) == model_from_lists(cart())
        assert model_from_lists(cart()).joints["joint_2"].initial == {"q": 0.2, "u": 0.4}

    def test_values_of_symbols(self) -> None:
        L, t = sym.symbols("L t", real=True)
        lists = cart() | {"ForcesPointsSym": [t], "ForcesPointsNum": np.ones(1)}
        lists["joint_to_child_cg"][1] = [0, -L / 2]
        lists["BodyDataSym"] = [L]
        lists["Force"] = {"CG": [[1, sym.cos(t) * L, 0, 0]]}
        model = model_from_lists(lists)
        assert model.parameters["L"].value == 2.5
        assert "t" not in model.parameters
        del lists["BodyDataSym"], lists["BodyDataNum"]
        given = model_from_lists(lists, parameters={"L": Parameter(2.5, "m", "Length")})
        assert given.parameters["L"].unit == "m"

    def test_a_point_force_with_a_moment(self) -> None:
        lists = cart() | {"Force": {"PointsBD": [[2, 1, 3, 4, 5], [1, 0, "t", 0, 0]]}}
        assert model_from_lists(lists).loads == {
            "PointsBD_0": PointForce("BD2_1", (3, 4)),
            "PointsBD_0_moment": BodyForce("body_2", moment=5),
            "PointsBD_1": PointForce("BD1_0", ("t", 0)),
        }

    def test_a_coefficient_that_depends_on_the_extension_is_a_law(self) -> None:
        """With `l`, `ld`, `theta` or `thetad` the expression is the force itself, as in M4E."""
        extension, rate = sym.symbols("l ld")
        lists = cart() | {
            "Force": {
                "TensionSpring": [(("BD10", "GR00"), [1, 3 * extension**3])],
                "TensionDamper": [(("BD10", "GR00"), 2 * rate * sym.Abs(rate))],
                "TorsionSpring": [((0, 2), [0.5, "4*sin(theta)"])],
                "TorsionDamper": [((0, 2), sym.Symbol("thetad", real=True) ** 3)],
            }
        }
        loads = model_from_lists(lists).loads
        laws = {name: str(load.law) for name, load in loads.items()}  # type: ignore[union-attr]
        assert laws == {
            "TensionSpring_0": "3*l**3",
            "TensionDamper_0": "2*ld*Abs(ld)",
            "TorsionSpring_0": "4*sin(theta)",
            "TorsionDamper_0": "thetad**3",
        }
        assert model_program(model_from_lists(lists)).states

    @pytest.mark.parametrize("scales", [[0.0, 0.0], [1.0, 0.0], [0.25, 0.5]])
    def test_gravity_of_single_bodies(self, scales: list[float]) -> None:
        """m z̈ of two free bodies is −m g gVec, whichever way it is expressed."""
        lists = {
            "joints": [[0, 1], [0, 2]], "types": ["F", "F"],
            "parent_cg_to_joint": [[0, 0], [5, 0]], "joint_to_child_cg": [[NAN, NAN]] * 2,
            "m0": [2, 3], "J0": [1, 1], "g": 9.81, "gVec": np.array(scales).reshape(2, 1),
        }  # fmt: skip
        result = simulate(model_from_lists(lists), stop_time=1.0, output_interval=1.0)
        for body, scale in enumerate(scales, start=1):
            assert result[f"body.body_{body}.z"][-1] == pytest.approx(-9.81 * scale / 2, abs=1e-9)

    def test_two_digits_without_a_line(self) -> None:
        """ "BD110" with eleven bodies: body 1 has no point 10, so it is body 11, point 0."""
        count = 11
        lists: dict[str, Any] = {
            "joints": [[k, k + 1] for k in range(count)],
            "types": ["R"] * count,
            "parent_cg_to_joint": [[0, 0]] * count,
            "joint_to_child_cg": [[0, -1]] * count,
            "Initial_Points": {"GR": [[0, 0]], "BD": {11: [[0, 1]]}},
            "Force": {"TensionSpring": [(("GR00", "BD110"), [1, 2]), (("GR00", "CG1111"), [1, 2])]},
            "m0": np.ones(count),
            "J0": np.ones(count),
        }
        loads = model_from_lists(lists).loads
        assert [load.points[1] for load in loads.values()] == ["BD11_0", "CG11"]  # type: ignore[union-attr]
        lists["Initial_Points"]["BD"][1] = [[0, 0]] * 11
        assert 'write "BD1_10" or "BD11_0"' in problems(lists)

    def test_normalize_prismatic(self) -> None:
        a = sym.Symbol("a", positive=True)
        rows = normalize_prismatic(np.array([[3, 4], [NAN, NAN]]))
        assert rows[0] == [0.6, 0.8]
        assert np.isnan(rows[1]).all()
        assert normalize_prismatic([[a, 0]]) == [[1, 0]]


def problems(lists: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        model_from_lists(lists, name="cart")
    return str(caught.value)


def put(*path: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(lists: dict[str, Any]) -> None:
        *parents, last = path
        target: Any = lists
        for key in parents:
            target = target[key]
        target[last] = value

    return change


FORCE = "Force"
WRONG = {
    "first joint not to the ground": (
        put("joints", 0, value=[2, 1]), r"body_1' is not connected to the ground",
        "one body of this chain must have a joint with parent: ground"),
    "fewer types than joints": (
        put("types", value=["P"]), "types: 1 rows, but joints has 2", "one row per joint"),
    "a body is missing": (
        put("joints", 1, value=[1, 4]), "joints: bodies are numbered without gaps; missing: 2, 3",
        "renumber the bodies"),
    "a parent that nobody defines": (
        put("joints", 1, value=[7, 2]), r"joints\[1\]\[0\]: body 7 is a parent, but no joint",
        r"add a joint \[0, 7\]"),
    "floating body off the ground": (
        put("types", 1, value="F"), r"joints\[1\]\[0\]: a floating joint is always to the ground",
        r"write \[0, 2\]"),
    "vector of a revolute joint is NaN": (
        put("parent_cg_to_joint", 1, value=[NAN, NAN]),
        r"parent_cg_to_joint\[1\]: a joint of type 'R' needs both entries, got NaN", "the vector"),
    "vector of a prismatic joint is NaN": (
        put("joint_to_child_cg", 0, value=[0, NAN]),
        r"joint_to_child_cg\[0\]: a joint of type 'P' needs both entries", "the vector"),
    "direction of a prismatic joint is NaN": (
        put("prismatic_direction", 0, value=[NAN, NAN]),
        r"prismatic_direction\[0\]: a joint of type 'P' needs both", "the vector"),
    "direction without length": (
        put("prismatic_direction", 0, value=[0, 0]),
        r"prismatic_direction\[0\]: the direction has no length", "give a vector"),
    "direction of a revolute joint": (
        put("prismatic_direction", 1, value=[0, 1]),
        r"prismatic_direction\[1\]: a joint of type 'R' has no direction", r"write \[nan, nan\]"),
    "child listed twice": (
        put("joints", 1, value=[0, 1]),
        r"joints\[1\]\[1\]: body 1 is the child of joints\[0\] already", "cut one joint"),
    "no list of joints": (
        lambda lists: lists.pop("joints"), "joints: missing list 'joints'", "the ground is 0"),
    "joint that is no pair": (
        put("joints", 1, value=[1]), r"joints\[1\]: expected \[parent, child\]", "two"),
    "the ground as a child": (
        put("joints", 1, value=[1, 0]), r"joints\[1\]: body numbers begin at 1", "number"),
    "unknown type": (
        put("types", 1, value="X"), r"types\[1\]: unknown type 'X'", "known: 'R', 'P', 'F'"),
    "no vector": (
        put("joint_to_child_cg", 1, value=[1, 2, 3]),
        r"joint_to_child_cg\[1\]: expected \[x, z\], got \[1, 2, 3\]", ""),
    "mass of nothing": (
        put("m0", 1, value=0), r"m0\[1\]: must be positive, got 0", "give a positive mass"),
    "too few masses": (put("m0", value=[1]), "m0: 1 entries for 2 bodies", "one entry per body"),
    "no inertias": (lambda lists: lists.pop("J0"), "J0: missing list 'J0'", "one number per body"),
    "start values too short": (
        put("ic", value=[0, 0]), "ic: 2 entries, expected 4", "S_1, Theta_2, SD_1, ThetaD_2"),
    "start value that is no number": (
        put("ic", 3, value="x +"), r"ic\[3\]: something is missing at the end", "allowed"),
    "symbol without a value": (
        put("BodyDataNum", value=[]), r"joint_to_child_cg\[1\]\[1\]: 'L' is not declared", ""),
    "symbols that are no list": (
        put("BodyDataSym", value=3), "BodyDataSym: expected a list, got 3", "give a list"),
    "value that is no number": (
        put("BodyDataNum", value=["x"]), r"BodyDataNum\[0\]: expected a finite number", ""),
    "power of another language": (
        put("joint_to_child_cg", 1, value=[0, "L^2"]),
        r"joint_to_child_cg\[1\]\[1\]: '\^' has no meaning here", "allowed"),
    "code instead of an expression": (
        put("m0", 0, value="__import__('os')"), r"m0\[0\]: .*no meaning here", "allowed"),
    "gravity per body that is no number": (
        put("gVec", value=[1, "x"]), r"gVec\[1\]: expected a number, got 'x'", "full gravity"),
    "origin that is no vector": (
        put("Reference_frame_Origin", value=3), r"Reference_frame_Origin: expected \[x, z\]", ""),
    "unknown group of points": (
        put("Initial_Points", "CG", value=[]),
        r'Initial_Points\["CG"\]: unknown group', "known: 'GR', 'BD'"),
    "points of an unknown body": (
        put("Initial_Points", "BD", 5, value=[[0, 0]]),
        r'Initial_Points\["BD"\]\[5\]: there is no body 5', "bodies: 1 to 2"),
    "point that is no vector": (
        put("Initial_Points", "GR", value=[3]), r'Initial_Points\["GR"\]\[0\]: expected', ""),
    "unknown point": (
        put(FORCE, "TensionSpring", 0, 0, value=["BD13", "GR00"]),
        r'Force\["TensionSpring"\]\[0\]\[0\]\[0\]: there is no point \'BD13\'', "points: BD1_0"),
    "a point of the ground as models call it": (
        put(FORCE, "TensionSpring", 0, 0, value=["BD10", "GR0"]),
        "there is no point 'GR0'", 'did you mean "GR0_0"'),
    "a prismatic joint, and no directions at all": (
        lambda lists: lists.pop("prismatic_direction"),
        r"types\[0\]: a joint of type 'P' needs a direction, and there is no prismatic_direction",
        r"add prismatic_direction: \[x, z\]"),
    "not the name of a point": (
        put(FORCE, "TensionSpring", 0, 0, value=["B1", "GR00"]),
        "'B1' does not name a point", "BD1_0"),
    "spring between one point": (
        put(FORCE, "TensionSpring", 0, 0, value=["GR00", "GR00"]),
        r'Force\["TensionSpring"\]\[0\].*both ends are', "name two points"),
    "spring without a stiffness": (
        put(FORCE, "TensionSpring", 0, value=[["BD10", "GR00"], 5]),
        r'Force\["TensionSpring"\]\[0\]: expected \(\(end, end\), \[rest, stiffness\]\)', ""),
    "damper with two numbers": (
        put(FORCE, "TensionDamper", value=[(("BD10", "GR00"), [1, 2])]),
        r'Force\["TensionDamper"\]\[0\]: expected \(\(end, end\), damping\)', ""),
    "stiffness as a function": (
        put(FORCE, "TensionSpring", 0, 1, value=[1, lambda extension: extension]),
        r'Force\["TensionSpring"\]\[0\]\[1\]\[1\]: a Python function cannot', "an expression"),
    "torsion between unknown bodies": (
        put(FORCE, "TorsionSpring", value=[((0, 3), [0, 1])]),
        r'Force\["TorsionSpring"\]\[0\]\[0\]\[1\]: there is no body 3', "bodies: 0 to 2"),
    "force on the ground": (
        put(FORCE, "CG", value=[[0, 1, 0, 0]]),
        r'Force\["CG"\]\[0\]\[0\]: there is no body 0', "bodies: 1 to 2"),
    "force with too few components": (
        put(FORCE, "CG", value=[[1, 1, 0]]),
        r'Force\["CG"\]\[0\]: expected \[body, Fx, Fz, My\]', ""),
    "force at an unknown point": (
        put(FORCE, "PointsBD", value=[[2, 2, 1, 0, 0]]),
        r'Force\["PointsBD"\]\[0\]\[1\]: body 2 has no point 2', "it has 2 points"),
    "unknown name in a force": (
        put(FORCE, "CG", value=[[1, "cos(tt)", 0, 0]]),
        r'Force\["CG"\]\[0\]\[1\]: \'tt\' is not declared', "did you mean 't'"),
    "unknown kind of force": (
        put(FORCE, "Tension", value=[]), r'Force\["Tension"\]: unknown kind', "TensionSpring"),
    "mooring lines": (
        put(FORCE, "Moorings", value=[[("BD10", "GR00"), ["chain", 100, 20, "-"]]]),
        r'Force\["Moorings"\]: mooring lines are not part of a model', "kind: mooring"),
    "misspelled name": (
        put("joint", value=[]), "joint: unknown name 'joint'", "did you mean 'joints'"),
    "place of a floating body said twice": (
        lambda lists: lists.update(
            joints=[[0, 1]], types=["F"], parent_cg_to_joint=[[1, 0]], joint_to_child_cg=[[0, 0]],
            prismatic_direction=[[NAN, NAN]], Initial_Points={}, Force={}, m0=[1], J0=[1],
            ic=[2, 0, 0, 0, 0, 0]),
        r"ic\[0\]: x starts at 2 here, at 1 in parent_cg_to_joint\[0\]", "0 here, or nan there"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_can_be_wrong(case: str) -> None:
    change, message, remedy = WRONG[case]
    lists = cart()
    change(lists)
    text = problems(lists)
    found = re.search(message, text)
    assert found, text
    assert re.search(remedy, text[found.start() :]), text


def test_all_problems_at_once() -> None:
    lists = cart()
    for case in ("unknown point", "unknown kind of force", "start values too short"):
        WRONG[case][0](lists)
    text = problems(lists)
    assert text.endswith("3 problems")
    assert all(f"cart: {place}" in text for place in ("ic:", 'Force["Tension"]', 'Force["Tension'))


def test_problems_of_a_file_have_lines(tmp_path: Path) -> None:
    path = tmp_path / "cart.yaml"
    path.write_text(
        "joints: [[0, 1]]\ntypes: [R]\nparent_cg_to_joint: [[0, 0]]\n"
        "joint_to_child_cg: [[0, nan]]\nm0: [1]\nJ0: [1]\nForce:\n  CG:\n    - [2, 0, 0, 0]\n"
    )
    with pytest.raises(InputError) as caught:
        load_model(path)
    places = [(p.line, p.column) for p in caught.value.problems]
    assert places == [(4, 21), (9, 8)]


def test_the_model_prints_its_equations() -> None:
    model: Model = model_from_lists(cart())
    assert "M[1,1] = m1 + m2" in Equations(model).text()
