"""Added mass goes to the bodies whose forces and motions are connected, or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.raft import BOTH, MATRIX, model, raft_system, water

from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description

HINGE = {
    2: "{type: revolute, parent: big, child: small, parent_to_joint: [5, 0]}",
    3: "{type: revolute, parent: big, child: small, parent_to_joint: [5, 0, 0], axis: [0, 1, 0]}",
}


def refusal(m: Description, hydro: Description, *connections: str) -> tuple[str, str]:
    """Message and remedy of the one problem, at the line of the last connection; or no texts."""
    system = raft_system(m, hydro, *connections)
    try:
        connect(system, {c.name: m if c.name == "m" else hydro for c in system.components})
    except InputError as error:
        (problem,) = error.problems
        assert MATRIX.split(" ")[0] in problem.source
        return problem.message, problem.remedy
    return "", ""


def one_by_one(water_body: str, body: str) -> list[str]:
    forces, motions = ("force_x", "force_z", "moment_y"), ("x", "z", "theta", "vx", "vz", "omega")
    return [
        *(f"hydro.{water_body}.{name} -> m.body.{body}.{name}" for name in forces),
        *(f"m.body.{body}.{name} -> hydro.{water_body}.{name}" for name in motions),
    ]


@pytest.mark.parametrize(("dimensions", "fmi"), [(2, "2"), (3, "2"), (2, "3")])
def test_bodies_in_another_order_are_refused(dimensions: int, fmi: str, tmp_path: Path) -> None:
    m = model(tmp_path, dimensions, fmi=fmi)
    right = water(tmp_path, "small", "big", dimensions=dimensions, fmi=fmi)
    assert refusal(m, right, *BOTH, MATRIX) == ("", "")
    wrong = water(tmp_path, "big", "small", dimensions=dimensions, fmi=fmi)
    message, remedy = refusal(m, wrong, *BOTH, MATRIX)
    assert message == (
        "the added mass of hydro.big would act on m.body.small, with which it is not connected: "
        "rows of hydro are for big, small, those of m for small, big"
    )
    assert remedy == "write the bodies of 'hydro' in the order small, big"


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_hinge_changes_the_order_of_the_model(dimensions: int, tmp_path: Path) -> None:
    """The body on the hinge counts after the one that carries it."""
    m = model(tmp_path, dimensions, joint=HINGE[dimensions])
    assert (
        refusal(m, water(tmp_path, "big", "small", dimensions=dimensions), *BOTH, MATRIX)[0] == ""
    )
    wrong = water(tmp_path, "small", "big", dimensions=dimensions)
    assert (
        refusal(m, wrong, *BOTH, MATRIX)[1] == "write the bodies of 'hydro' in the order big, small"
    )


def test_added_mass_at_another_body_is_refused(tmp_path: Path) -> None:
    m = model(tmp_path, flags="tower")
    message, remedy = refusal(m, water(tmp_path, "hull"), "m.big <-> hydro.hull", MATRIX)
    assert message.startswith("the added mass of hydro.hull would act on m.body.tower, with which")
    assert remedy == (
        "in the model write 'added_mass: true' at big, and in the model leave it out at tower"
    )


def test_a_body_that_nothing_moves_is_refused(tmp_path: Path) -> None:
    """Its added mass would act on a body of the model that is not in its place."""
    m = model(tmp_path, flags="big tower")
    message, remedy = refusal(m, water(tmp_path, "hull", "stern"), "m.big <-> hydro.hull", MATRIX)
    assert message.startswith("the added mass of hydro.stern would act on m.body.tower")
    assert remedy == "in the model leave it out at tower, and connect hydro.stern"


def test_elements_that_are_connected_one_by_one_are_compared(tmp_path: Path) -> None:
    """Surge, heave and pitch of water in space for bodies in the plane."""
    m, hydro = model(tmp_path), water(tmp_path, "big", "small", dimensions=3)
    joined = [*one_by_one("big", "big"), *one_by_one("small", "small")]
    element = "hydro.added_mass[{},{}] -> m.added_mass[{},{}]"
    assert refusal(m, hydro, *joined, element.format(3, 3, 5, 5)) == ("", "")
    assert refusal(m, hydro, *joined, element.format(3, 9, 5, 2)) == ("", "")
    for rows in ((3, 3, 2, 2), (9, 9, 5, 5), (3, 9, 2, 2), (3, 9, 5, 5)):
        assert (
            "with which it is not connected" in refusal(m, hydro, *joined, element.format(*rows))[0]
        )


def test_bodies_are_matched_by_connections_not_by_names(tmp_path: Path) -> None:
    m = model(tmp_path)
    crossed = ("m.small <-> hydro.big", "m.big <-> hydro.small")
    assert refusal(m, water(tmp_path, "big", "small"), *crossed, MATRIX) == ("", "")
    remedy = refusal(m, water(tmp_path, "small", "big"), *crossed, MATRIX)[1]
    assert remedy == "write the bodies of 'hydro' in the order big, small"
    assert refusal(m, water(tmp_path, "fore", "aft"), *one_by_one("fore", "small"), MATRIX)[0] != ""
    scalars = [*one_by_one("fore", "small"), *one_by_one("aft", "big")]
    assert refusal(m, water(tmp_path, "fore", "aft"), *scalars, MATRIX) == ("", "")


def test_bodies_that_are_not_known_are_not_refused(tmp_path: Path) -> None:
    """Forces and motions through a third component, and matrices without our descriptions."""
    m, hydro = model(tmp_path), water(tmp_path, "big", "small")
    assert refusal(m, hydro, "m.small <-> other.small", "m.big <-> other.big", MATRIX) == ("", "")
    named = {name: replace(v, description="") for name, v in hydro.variables.items()}
    assert refusal(m, replace(hydro, variables=named), *BOTH, MATRIX) == ("", "")
