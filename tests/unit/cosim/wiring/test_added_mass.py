"""Added mass goes to the bodies whose forces and motions are connected, or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.raft import BOTH, MATRIX, model, raft_system, water

from m4e_fmi.cosim import prepare
from m4e_fmi.cosim.wiring.added_mass import without_added_mass
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description

HINGE = {
    2: "{type: revolute, parent: big, child: small, parent_to_joint: [5, 0]}",
    3: "{type: revolute, parent: big, child: small, parent_to_joint: [5, 0, 0], axis: [0, 1, 0]}",
}
HULL = "m.big <-> hydro.hull"


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


@pytest.mark.parametrize(
    ("dimensions", "fmi", "hinged"),
    [(2, "2", False), (3, "2", False), (2, "3", False), (2, "2", True), (3, "2", True)],
)
def test_bodies_in_another_order_are_refused(
    dimensions: int, fmi: str, hinged: bool, tmp_path: Path
) -> None:
    """A body on a hinge counts after the one that carries it."""
    more = {"joint": HINGE[dimensions]} if hinged else {}
    m = model(tmp_path, dimensions, fmi=fmi, **more)
    order = ("big", "small") if hinged else ("small", "big")
    right = water(tmp_path, *order, dimensions=dimensions, fmi=fmi)
    assert refusal(m, right, *BOTH, MATRIX) == ("", "")
    wrong = water(tmp_path, *order[::-1], dimensions=dimensions, fmi=fmi)
    message, remedy = refusal(m, wrong, *BOTH, MATRIX)
    assert message == (
        f"the added mass of hydro.{order[1]} would act on m.body.{order[0]}, with which it is not "
        f"connected: rows of hydro are for {order[1]}, {order[0]}, those of m for {order[0]}, "
        f"{order[1]}"
    )
    assert remedy == f"write the bodies of 'hydro' in the order {order[0]}, {order[1]}"


@pytest.mark.parametrize(
    ("flags", "bodies", "connections", "message", "remedy"),
    [
        (
            "tower", ("hull",), (HULL,), "the added mass of hydro.hull would act on m.body.tower",
            "in the model write 'added_mass: true' at the bodies that these are connected with",
        ),
        (  # a body that nothing moves
            "big tower", ("hull", "stern"), (HULL,), "hydro.stern would act on m.body.tower",
            "connect each body of 'hydro'",
        ),
        (
            "", ("hull",), (HULL,), "'m' has no variable 'added_mass'",
            "write 'added_mass: true' in its model at each body that has one (bodies: small, "
            "big, tower)",
        ),
        (
            "big", ("big", "small"), BOTH, "hydro.added_mass and m.added_mass differ in size",
            "rows are for big, small, and for big: write 'added_mass: true' in the model at each "
            "body that has added mass, and at no other",
        ),
    ],
)  # fmt: skip
def test_added_mass_at_other_bodies_is_refused(
    tmp_path: Path, flags: str, bodies: tuple[str, ...], connections: tuple[str, ...],
    message: str, remedy: str,
) -> None:  # fmt: skip
    found = refusal(model(tmp_path, flags=flags), water(tmp_path, *bodies), *connections, MATRIX)
    assert message in found[0]
    assert remedy in found[1]


def test_elements_that_are_connected_one_by_one_are_compared(tmp_path: Path) -> None:
    """Surge, heave and pitch of water in space for bodies in the plane."""
    m, hydro = model(tmp_path), water(tmp_path, "big", "small", dimensions=3)
    joined = [*one_by_one("big", "big"), *one_by_one("small", "small")]
    for rows in (
        (3, 3, 5, 5),
        (3, 9, 5, 2),
        (3, 3, 2, 2),
        (9, 9, 5, 5),
        (3, 9, 2, 2),
        (3, 9, 5, 5),
    ):
        element = "hydro.added_mass[{},{}] -> m.added_mass[{},{}]".format(*rows)
        message, _ = refusal(m, hydro, *joined, element)
        assert bool(message) == (rows not in ((3, 3, 5, 5), (3, 9, 5, 2)))


def test_bodies_are_matched_by_connections_not_by_names(tmp_path: Path) -> None:
    m = model(tmp_path)
    crossed = ("m.small <-> hydro.big", "m.big <-> hydro.small")
    assert refusal(m, water(tmp_path, "big", "small"), *crossed, MATRIX) == ("", "")
    remedy = refusal(m, water(tmp_path, "small", "big"), *crossed, MATRIX)[1]
    assert remedy == "write the bodies of 'hydro' in the order big, small"
    scalars = [*one_by_one("fore", "small"), *one_by_one("aft", "big")]
    assert refusal(m, water(tmp_path, "fore", "aft"), *scalars, MATRIX) == ("", "")


def test_bodies_that_are_not_known_are_not_refused(tmp_path: Path) -> None:
    """Forces and motions through a third component, and matrices without our descriptions."""
    m, hydro = model(tmp_path), water(tmp_path, "big", "small")
    assert refusal(m, hydro, "m.small <-> other.small", "m.big <-> other.big", MATRIX) == ("", "")
    named = {name: replace(v, description="") for name, v in hydro.variables.items()}
    assert refusal(m, replace(hydro, variables=named), *BOTH, MATRIX) == ("", "")


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_body_in_water_without_added_mass_is_told_of(dimensions: int, tmp_path: Path) -> None:
    """Before a run, with the line that its model lacks; not of one that cannot move."""
    hydro = water(tmp_path, "hull", dimensions=dimensions)
    system = raft_system(model(tmp_path, dimensions, flags=""), hydro, HULL)
    assert (
        "hydro.hull has added mass, which m.body.big does not take: write 'added_mass: true' at "
        "big in its model, and connect 'hydro.added_mass -> m.added_mass'"
    ) in prepare(system).warnings
    for flags, joint, connections in (
        ("big", None, (HULL, MATRIX)),
        ("big", None, (HULL,)),
        ("", "{type: fixed, child: small}", ("m.small <-> hydro.hull",)),
    ):
        m = model(tmp_path, dimensions, flags=flags, **({"joint": joint} if joint else {}))
        parts = {"m": m, "hydro": hydro}
        wiring = connect(raft_system(m, hydro, *connections), parts)
        assert without_added_mass(parts, wiring) == []
