"""The paper's lists: the listings as typed, other spellings; mistakes are in tests/corpus."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sym

from m4e_fmi.errors import InputError
from m4e_fmi.model import (
    BodyForce,
    Parameter,
    PointForce,
    load_model,
    model_from_lists,
)
from m4e_fmi.multibody import model_program

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
    def test_yaml_and_json(self, tmp_path: Path) -> None:
        expected = model_from_lists(cart(), name="cart")
        path = tmp_path / "cart.json"
        path.write_text(json.dumps(cart()))
        assert load_model(path) == expected
        path.write_text(json.dumps({"name": "trolley", **cart()}).replace("null", ".nan"))
        assert load_model(path).name == "trolley"


class TestMeaning:
    def test_a_floating_body_starts_where_its_row_says(self) -> None:
        lists: dict[str, Any] = {
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

    def test_a_coefficient_that_depends_on_the_extension_is_a_law(self) -> None:
        """With `l`, `ld`, `theta` or `thetad` the expression is the force itself, as in M4E."""
        extension, rate = sym.symbols("l ld")
        lists = cart() | {
            "Force": {
                "TensionSpring": [(("BD10", "GR00"), [1, 3 * extension**3])],
                "TensionDamper": [(("BD1_0", "GR0_0"), 2 * rate * sym.Abs(rate))],
                "TorsionSpring": [((0, 2), [0.5, "4*sin(theta)"])],
                "TorsionDamper": [((0, 2), sym.Symbol("thetad", real=True) ** 3)],
            }
        }
        loads = model_from_lists(lists).loads
        laws = {name: str(load.law) for name, load in loads.items()}  # pyrefly: ignore[missing-attribute]
        assert laws == {
            "TensionSpring_0": "3*l**3",
            "TensionDamper_0": "2*ld*Abs(ld)",
            "TorsionSpring_0": "4*sin(theta)",
            "TorsionDamper_0": "thetad**3",
        }
        spring, damper, *_ = loads.values()
        assert spring.points == damper.points  # pyrefly: ignore[missing-attribute]
        assert model_program(model_from_lists(lists)).states

    def test_numbers_of_two_digits_take_a_line(self) -> None:
        count = 11
        lists: dict[str, Any] = {
            "joints": [[k, k + 1] for k in range(count)],
            "types": ["R"] * count,
            "parent_cg_to_joint": [[0, 0]] * count,
            "joint_to_child_cg": [[0, -1]] * count,
            "Initial_Points": {"GR": [[0, 0]], "BD": {11: [[0, 1]]}},
            "Force": {
                "TensionSpring": [(("GR00", "BD11_0"), [1, 2]), (("GR00", "CG11_11"), [1, 2])]
            },
            "m0": np.ones(count),
            "J0": np.ones(count),
        }
        loads = model_from_lists(lists).loads
        assert [load.points[1] for load in loads.values()] == ["BD11_0", "CG11"]  # pyrefly: ignore[missing-attribute]
        lists["Force"]["TensionSpring"][0] = (("GR00", "BD110"), [1, 2])
        with pytest.raises(InputError, match="'BD110' does not name a point"):
            model_from_lists(lists)

    def test_a_point_force_with_a_moment(self) -> None:
        lists = cart() | {"Force": {"PointsBD": [[2, 1, 3, 4, 5], [1, 0, "t", 0, 0]]}}
        assert model_from_lists(lists).loads == {
            "PointsBD_0": PointForce("BD2_1", (3, 4)),
            "PointsBD_0_moment": BodyForce("body_2", moment=5),
            "PointsBD_1": PointForce("BD1_0", ("t", 0)),
        }


@pytest.mark.parametrize(("change", "message"), [
    ({"joints": None}, "joints: missing list 'joints'"),
    ({"Force": {"TensionSpring": [(("BD10", "GR00"), [1, lambda extension: extension])]}},
     r'Force\["TensionSpring"\]\[0\]\[1\]\[1\]: expected a number or an expression'),
    ({"J0": [3, "x +"]}, r"J0\[1\]: something is missing at the end"),
    ({"m0": [None, 1.0]}, r"m0\[0\]: .*got None"),
])  # fmt: skip
def test_places_in_python_are_those_of_the_lists(change: dict[str, Any], message: str) -> None:
    """What can be wrong in a file is in tests/corpus."""
    lists = {name: value for name, value in (cart() | change).items() if value is not None}
    with pytest.raises(InputError, match=rf"^cart: {message}"):
        model_from_lists(lists, name="cart")
