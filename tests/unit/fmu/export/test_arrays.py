"""Which scalars become the elements of one variable of FMI 3.0."""

from __future__ import annotations

from typing import Any

import pytest

from m4e_fmi.fmu.export.arrays import Grouped, grouped, places
from m4e_fmi.fmu.export.description import FmuVariable, ModelDescription


def output(name: str, **more: Any) -> FmuVariable:
    given = {"unit": "m", "causality": "output", "initial": "calculated", "description": name}
    every: dict[str, Any] = {**given, **more}
    return FmuVariable(name=name, **every)


def arrays(*variables: FmuVariable, derivatives: tuple[str, ...] = ()) -> dict[str, Grouped]:
    description = ModelDescription("m", "m", variables, derivatives=derivatives)
    return {v.name: v for v in grouped(description, "3")}


def elements(found: dict[str, Grouped]) -> dict[str, list[str]]:
    """The scalars of each array."""
    return {name: [v.name for v in array.members] for name, array in found.items() if array.shape}


def test_time_comes_first_and_arrays_at_their_first_element() -> None:
    found = arrays(output("a"), output("b.x.z"), output("c"), output("b.x.x"))
    assert list(found) == ["time", "a", "b.x.position", "c"]
    assert found["b.x.position"].shape == (2,)
    assert places(list(found.values())) == {
        "time": (0, 1),
        "a": (1, 1),
        "b.x.x": (2, 1),
        "b.x.z": (2, 2),
        "c": (3, 1),
    }


MATRIX = [f"a.m[{i},{j}]" for j in (1, 2, 3) for i in (1, 2)]


@pytest.mark.parametrize(
    ("listed", "expected"),
    [
        ("b.x.z b.x.x", {"b.x.position": "b.x.x b.x.z"}),
        ("p.moment_z p.moment_y p.moment_x", {"p.moment": "p.moment_x p.moment_y p.moment_z"}),
        ("p.reaction_x p.reaction_z", {"p.reaction": "p.reaction_x p.reaction_z"}),
        ("p.wave_force_x p.wave_force_z", {"p.wave_force": "p.wave_force_x p.wave_force_z"}),
        # in space a component about Y has no axis in its name; the array may have that name
        ("b.e1 b.e0 b.e3 b.e2", {"b.quaternion": "b.e0 b.e1 b.e2 b.e3"}),
        (
            "b.omega b.omega_x b.omega_z",
            {"b.angular_velocity": "b.omega_x b.omega b.omega_z"},
        ),
        (
            "j.reaction_moment j.reaction_moment_z j.reaction_moment_x",
            {"j.reaction_moment": "j.reaction_moment_x j.reaction_moment j.reaction_moment_z"},
        ),
        ("v[2] v[1]", {"v": "v[1] v[2]"}),
        (" ".join(MATRIX), {"a.m": " ".join(sorted(MATRIX))}),
        # none: a part of what exists in space, incomplete, ambiguous, a name that is taken
        *((text, {}) for text in ("b.e1 b.e2 b.phi b.theta", "p.lift_z", "w[1]", "x z")),
        *((text, {}) for text in ("a[1,1] a[1,2] a[2,1]", "a[1] a[1,1]", "a[0] a[1]")),
        *((text, {}) for text in ("a[1] a[3]", "v[1] v[2] v", "b.x b.z b.position")),
        ("q[300000000] q[1]", {}),  # an index may be large
    ],
)
def test_what_becomes_an_array(listed: str, expected: dict[str, str]) -> None:
    found = arrays(*map(output, listed.split()))
    assert elements(found) == {name: text.split() for name, text in expected.items()}
    if not expected:
        assert list(found) == ["time", *listed.split()]
    assert not listed.startswith("a.m") or found["a.m"].shape == (2, 3)


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
    assert list(arrays(output("b.x"), other)) == ["time", "b.x", other.name]


PLACES = output("b.x"), output("b.z")
SPEEDS = [output(f"b.v{a}", derivative_of=f"b.{a}") for a in "xz"]
STATES = [output(f"b.{a}", initial="exact", start=0.0) for a in "xz"]
RATES = [output(f"der(b.{a})", causality="local", derivative_of=f"b.{a}") for a in "xz"]
TURN = [output(f"b.e{k}") for k in range(4)]


@pytest.mark.parametrize(
    ("listed", "derivatives", "expected"),
    [
        ([*PLACES, *SPEEDS], "", "b.position b.velocity"),
        (
            [*PLACES, *(output(f"b.v{a}", derivative_of=f"b.{o}") for a, o in ("xz", "zx"))],
            "",
            "b.x b.z b.vx b.vz",
        ),
        ([output("b.x"), output("b.z", unit="km"), *SPEEDS], "", "b.x b.z b.vx b.vz"),
        ([*PLACES, SPEEDS[1]], "", "b.x b.z b.vz"),
        (
            [
                *(*PLACES, *SPEEDS, output("b.ax", derivative_of="b.vx")),
                output("acc", derivative_of="b.vz"),
            ],
            "",
            "b.x b.z b.vx b.vz b.ax acc",
        ),
        ([*STATES, *RATES], "der(b.x) der(b.z)", "b.position der(b.position)"),
        (
            [*STATES, output("b.up", derivative_of="b.z"), RATES[0]],
            "der(b.x) b.up",
            "b.x b.z b.up der(b.x)",
        ),
        (
            [*TURN, *(output(f"der(b.e{k})", derivative_of=f"b.e{k}") for k in range(4))],
            "",
            "b.quaternion der(b.quaternion)",
        ),
    ],
)
def test_derivatives_of_elements_are_elements(
    listed: list[FmuVariable], derivatives: str, expected: str
) -> None:
    """A variable and its derivative have equal dimensions, in the same order, or are no arrays."""
    found = arrays(*listed, derivatives=tuple(derivatives.split()))
    assert list(found) == ["time", *expected.split()]
