"""The linear power take-off: direction and sign of its force, its power and energy."""

import pytest
from support.programs import Evaluated

from m4e_adapters.control import LinearPtoConfig, linear_pto
from m4e_fmi.program import Program


def program(**changes) -> Program:
    values = {"point": "p", "anchor": (1.0, -50.0), "damping": 0.0, "rest_length": 5.0} | changes
    return linear_pto(LinearPtoConfig.model_validate(values), name="pto")


def outputs(pto: Program, motion: tuple, energy: float = 0.0) -> dict[str, float]:
    return Evaluated(pto).outputs({"energy": energy, **moved(pto, motion)})


def moved(pto: Program, motion: tuple) -> dict[str, float]:
    return dict(zip(order(pto), motion, strict=True))


def order(pto: Program) -> list[str]:
    return [v.name for v in pto.inputs]


def test_variables():
    pto = program()
    assert order(pto) == ["p.x", "p.vx", "p.z", "p.vz"]
    # a program holds its inputs: it does not move x along vx, so it must not say so
    assert [v.derivative_of for v in pto.inputs] == [None] * 4
    assert {v.name for v in pto.parameters if v.tunable} == {"damping", "stiffness"}
    bounded = {"damping", "stiffness", "rest_length"}
    assert {v.name for v in pto.parameters if v.minimum == 0.0} == bounded
    assert [v.name for v in pto.states] == ["energy"]


def test_in_space():
    # from the anchor (1, 2, −50) the point is at 3·(1, 2, 2): length 9
    pto = program(anchor=(1.0, 2.0, -50.0), rest_length=6.0, stiffness=100.0, damping=20.0)
    assert order(pto) == ["p.x", "p.vx", "p.y", "p.vy", "p.z", "p.vz"]
    found = outputs(pto, (4.0, 3.0, 8.0, 0.0, -44.0, -3.0))  # l̇ = (3 − 2·3)/3 = −1
    force = -(100.0 * 3.0 + 20.0 * -1.0)
    parts = [found[f"p.force_{axis}"] for axis in "xyz"]
    assert parts == pytest.approx([force / 3, 2 * force / 3, 2 * force / 3])
    assert found["power"] == pytest.approx(20.0)


def test_pretension_pulls_and_a_compressed_spring_pushes():
    found = outputs(program(pretension=10.0, rest_length=10.0), (7.0, 0.0, -42.0, 0.0))
    assert (found["p.force_x"], found["p.force_z"]) == pytest.approx((-6.0, -8.0))
    found = outputs(program(stiffness=1.0, rest_length=20.0), (7.0, 0.0, -42.0, 0.0))
    assert (found["p.force_x"], found["p.force_z"]) == pytest.approx((6.0, 8.0))


def test_the_rest_length_follows_from_where_the_point_is_at_rest():
    values = {"point": "p", "anchor": (1.0, -50.0), "damping": 1.0, "point_at": (7.0, -42.0)}
    pto = linear_pto(LinearPtoConfig.model_validate(values), name="pto")
    starts = {v.name: v.start for v in (*pto.parameters, *pto.inputs)}
    assert starts["rest_length"] == pytest.approx(10.0)
    assert (starts["p.x"], starts["p.z"]) == (7.0, -42.0)
    assert outputs(pto, (7.0, 0.0, -42.0, 0.0))["p.force_x"] == 0
