"""Which scalars become the elements of one variable of FMI 3.0."""

from __future__ import annotations

from typing import Any

import pytest

from m4e_fmi.fmu.export.description.arrays import Grouped, Place, grouped, places
from m4e_fmi.fmu.export.description.description import FmuVariable, ModelDescription


def output(name: str, **more: Any) -> FmuVariable:
    given = {"unit": "m", "causality": "output", "initial": "calculated", "description": name}
    return FmuVariable(name=name, **{**given, **more})


def arrays(*variables: FmuVariable, derivatives: tuple[str, ...] = ()) -> dict[str, Grouped]:
    description = ModelDescription("m", "m", variables, derivatives=derivatives)
    return {v.name: v for v in grouped(description)}


def names(*variables: FmuVariable, derivatives: tuple[str, ...] = ()) -> list[str]:
    return list(arrays(*variables, derivatives=derivatives))


def test_time_comes_first_and_arrays_at_their_first_element() -> None:
    found = arrays(output("a"), output("b.x.z"), output("c"), output("b.x.x"))
    assert list(found) == ["time", "a", "b.x.position", "c"]
    assert [v.name for v in found["b.x.position"].members] == ["b.x.x", "b.x.z"]
    assert found["b.x.position"].shape == (2,)
    assert places(list(found.values())) == {
        "time": Place(0, 1),
        "a": Place(1, 1),
        "b.x.x": Place(2, 1),
        "b.x.z": Place(2, 2),
        "c": Place(3, 1),
    }


def test_three_axes() -> None:
    found = arrays(*(output(f"p.moment_{axis}") for axis in "zyx"))
    assert [v.name for v in found["p.moment"].members] == [f"p.moment_{axis}" for axis in "xyz"]


def test_forces_of_any_name() -> None:
    listed = [output(f"p.{name}_{axis}") for name in ("reaction", "wave_force") for axis in "xz"]
    assert names(*listed, output("p.lift_z")) == [
        *("time", "p.reaction", "p.wave_force", "p.lift_z")
    ]


def test_in_space() -> None:
    """A component about Y has no axis in its name; the array may have that name."""
    e = [output(f"b.e{k}") for k in (1, 0, 3, 2)]
    turns = [output(f"b.{part}") for part in ("omega", "omega_x", "omega_z")]
    moments = [output(f"j.reaction_moment{axis}") for axis in ("", "_z", "_x")]
    found = arrays(*e, *turns, *moments)
    assert list(found) == ["time", "b.quaternion", "b.angular_velocity", "j.reaction_moment"]
    assert [v.name for v in found["b.quaternion"].members] == ["b.e0", "b.e1", "b.e2", "b.e3"]
    axes = [v.name.removeprefix("j.reaction_moment") for v in found["j.reaction_moment"].members]
    assert axes == ["_x", "", "_z"]
    rates = [output(f"der(b.e{k})", derivative_of=f"b.e{k}") for k in range(4)]
    assert names(*e, *rates) == ["time", "b.quaternion", "der(b.quaternion)"]


def test_parts_of_what_exists_in_space_stay_apart() -> None:
    assert names(*map(output, ("b.e1", "b.e2", "b.phi", "b.theta"))) == [
        *("time", "b.e1", "b.e2", "b.phi", "b.theta")
    ]
    assert names(output("b.omega_x"), output("b.omega"), output("b.omega_z", unit="deg")) == [
        *("time", "b.omega_x", "b.omega", "b.omega_z")
    ]


def test_indices() -> None:
    matrix = [output(f"a.m[{i},{j}]", unit=f"m{i + j}") for j in (1, 2, 3) for i in (1, 2)]
    found = arrays(*matrix, output("v[2]"), output("v[1]"), output("w[1]"))
    assert list(found) == ["time", "a.m", "v", "w[1]"]
    assert found["a.m"].shape == (2, 3)
    assert [v.name[-5:] for v in found["a.m"].members] == [
        *("[1,1]", "[1,2]", "[1,3]", "[2,1]", "[2,2]", "[2,3]")
    ]


def test_words_that_differ_are_listed() -> None:
    forces = [output(f"b.force_{a}", description=f"Force, world {a.upper()}") for a in "xyz"]
    assert arrays(*forces)["b.force"].description == "Force, world X, Y, Z"
    texts = "Roll of the body", "Yaw, about Z", "Pitch"
    turns = [
        output(f"b.{a}", description=t) for a, t in zip(("phi", "theta", "psi"), texts, strict=True)
    ]
    assert arrays(*turns)["b.attitude"].description == "; ".join(texts)


def test_what_an_array_is_called_and_says() -> None:
    matrix = [output(f"a[{i},{j}]", unit=f"m{i}") for i in (1, 2) for j in (1, 2)]
    found = arrays(output("b.x"), output("b.z"), *matrix, output("c"))
    assert found["b.position"].elements == ("b.position[1]", "b.position[2]")
    assert found["b.position"].unit == "m"
    assert found["b.position"].description == "b.x; b.z"
    assert found["a"].elements == ("a[1,1]", "a[1,2]", "a[2,1]", "a[2,2]")
    assert found["a"].unit is None
    assert found["a"].description.endswith("units of the elements: m1, m1, m2, m2")
    assert found["c"].elements == ("c",)


@pytest.mark.parametrize(
    "other",
    [
        output("b.z", causality="input", initial=None),
        output("b.z", variability="discrete"),
        output("b.z", initial="exact", start=0.0),
        output("b.z", unit="km"),
        output("b.z", display_unit="mm"),
        output("z"),
        output("c.z"),
    ],
)
def test_what_does_not_agree_stays_apart(other: FmuVariable) -> None:
    assert names(output("b.x"), other) == ["time", "b.x", other.name]


@pytest.mark.parametrize(
    "listed",
    [
        ("a[1,1]", "a[1,2]", "a[2,1]"),  # incomplete
        ("a[1]", "a[1,1]"),
        ("a[0]", "a[1]"),
        ("a[1]", "a[3]"),
        ("v[1]", "v[2]", "v"),  # the name is taken
        ("b.x", "b.z", "b.position"),
        ("x", "z"),  # of nothing
    ],
)
def test_what_is_no_array(listed: tuple[str, ...]) -> None:
    assert names(*map(output, listed)) == ["time", *listed]


def test_derivatives_of_elements_are_elements() -> None:
    places_ = output("b.x"), output("b.z")
    speeds = [output(f"b.v{a}", derivative_of=f"b.{a}") for a in "xz"]
    assert names(*places_, *speeds) == ["time", "b.position", "b.velocity"]
    crossed = [output(f"b.v{a}", derivative_of=f"b.{o}") for a, o in ("xz", "zx")]
    assert names(*places_, *crossed) == ["time", "b.x", "b.z", "b.vx", "b.vz"]
    apart = output("b.x"), output("b.z", unit="km")
    assert names(*apart, *speeds) == ["time", "b.x", "b.z", "b.vx", "b.vz"]


def test_what_has_a_scalar_as_derivative_is_none() -> None:
    """A variable and its derivative have equal dimensions."""
    places_ = output("b.x"), output("b.z")
    speeds = [output(f"b.v{a}", derivative_of=f"b.{a}") for a in "xz"]
    assert names(*places_, speeds[1]) == ["time", "b.x", "b.z", "b.vz"]
    accelerations = output("b.ax", derivative_of="b.vx"), output("acc", derivative_of="b.vz")
    listed = [*places_, *speeds, *accelerations]
    assert names(*listed) == ["time", *(v.name for v in listed)]


def test_an_index_may_be_large() -> None:
    assert names(output("q[300000000]"), output("q[1]")) == ["time", "q[300000000]", "q[1]"]


def test_rates_of_an_array_of_states_are_an_array() -> None:
    states = [output(f"b.{a}", initial="exact", start=0.0) for a in "xz"]
    rates = [output(f"der(b.{a})", causality="local", derivative_of=f"b.{a}") for a in "xz"]
    listed = tuple(v.name for v in rates)
    assert names(*states, *rates, derivatives=listed) == ["time", "b.position", "der(b.position)"]
    odd = [output("b.up", derivative_of="b.z"), rates[0]]
    assert names(*states, *odd, derivatives=("der(b.x)", "b.up")) == [
        *("time", "b.x", "b.z", "b.up", "der(b.x)")
    ]
