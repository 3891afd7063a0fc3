"""Bodies in water without added mass are told of, with the line that their model lacks."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.raft import BOTH, MATRIX, model, raft_system, water

from m4e_fmi.cosim import prepare
from m4e_fmi.cosim.connections.added_mass.left_out import without_added_mass
from m4e_fmi.cosim.connections.connect import connect
from m4e_fmi.errors import InputError
from m4e_fmi.fmu.importer.reading import Description

HULL = "m.big <-> hydro.hull"


def told(m: Description, hydro: Description, *connections: str) -> list[str]:
    parts = {"m": m, "hydro": hydro}
    return without_added_mass(parts, connect(raft_system(m, hydro, *connections), parts))


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_body_without_the_flag_is_told_of(dimensions: int, tmp_path: Path) -> None:
    m = model(tmp_path, dimensions, flags="")
    (line,) = told(m, water(tmp_path, "hull", dimensions=dimensions), HULL)
    assert line == (
        "hydro.hull has added mass, which m.body.big does not take: write 'added_mass: true' at "
        "big in its model, and connect 'hydro.added_mass -> m.added_mass'"
    )


def test_a_run_tells_of_it(tmp_path: Path) -> None:
    system = raft_system(model(tmp_path, flags=""), water(tmp_path, "hull"), HULL)
    assert [w for w in prepare(system).warnings if w.startswith("hydro.hull has added mass")]


def test_a_body_with_added_mass_is_not_told_of(tmp_path: Path) -> None:
    assert told(model(tmp_path, flags="big"), water(tmp_path, "hull"), HULL, MATRIX) == []
    assert told(model(tmp_path, flags="big"), water(tmp_path, "hull"), HULL) == []


def test_a_body_that_cannot_move_is_not_told_of(tmp_path: Path) -> None:
    m = model(tmp_path, flags="", joint="{type: fixed, child: small}")
    assert told(m, water(tmp_path, "small"), "m.small <-> hydro.small") == []


def test_a_matrix_that_the_model_lacks_is_refused_with_the_flag(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        told(model(tmp_path, flags=""), water(tmp_path, "hull"), HULL, MATRIX)
    (problem,) = caught.value.problems
    assert problem.message == "'m' has no variable 'added_mass'"
    assert problem.remedy == (
        "write 'added_mass: true' in its model at each body that is in water (bodies: small, big, "
        "tower)"
    )


def test_matrices_of_more_and_less_bodies_are_refused_with_their_names(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        told(model(tmp_path, flags="big"), water(tmp_path, "big", "small"), *BOTH, MATRIX)
    (problem,) = caught.value.problems
    assert problem.message == "hydro.added_mass and m.added_mass differ in size"
    assert problem.remedy.endswith(
        "rows are for big, small, and for big: write 'added_mass: true' in the model at each body "
        "that is in water, and at no other"
    )
