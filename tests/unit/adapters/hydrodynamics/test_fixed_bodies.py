"""Bodies that do not move, and bodies on the sea bed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support import mesh_writers

from m4e_adapters.hydrodynamics.build import check_config, frequency_table
from m4e_adapters.hydrodynamics.config import Body, Cylinder, HydrodynamicsConfig, Water
from m4e_adapters.hydrodynamics.flow.bem import solve_hulls
from m4e_adapters.hydrodynamics.geometry.mesh import Hull, hulls_and_problems, make_hull, make_hulls
from m4e_adapters.hydrodynamics.geometry.shapes import cylinder_panels
from m4e_fmi.errors import InputError

DEPTH = 8.0
WATER = {"density": 1000, "depth": DEPTH}
FLOAT = {
    "shape": {"cylinder": {"radius": 2, "draft": 2}},
    "center_of_gravity": [0, -1],
    "panels": 60,
}
PILE = {
    "shape": {"cylinder": {"radius": 2, "draft": DEPTH, "center_x": 6}},
    "fixed": True,
    "panels": 60,
}


def config(**bodies: dict) -> HydrodynamicsConfig:
    return HydrodynamicsConfig.model_validate({"water": WATER, "bodies": bodies})


def hulls(folder: Path | None = None, **bodies: dict) -> tuple[Hull, ...]:
    return make_hulls(config(**bodies), folder or Path(), progress=lambda _: None)


def solved(*made: Hull):
    water = Water.model_validate(WATER)
    return solve_hulls(made, water=water, omega=np.array([1.2]), progress=lambda _: None)


def test_a_fixed_body_has_no_variables_wherever_it_is_named() -> None:
    alone = check_config(config(float=FLOAT), folder=Path())
    beside = check_config(config(pile=PILE, float=FLOAT), folder=Path())
    for kind in ("inputs", "outputs", "states"):
        names = [v.name for v in getattr(beside, kind)]
        assert names == [v.name for v in getattr(alone, kind)]
    assert not any(v.name.startswith("pile") for v in beside.parameters)


def test_frequencies_are_those_of_the_body_that_moves() -> None:
    small = {**PILE, "shape": {"cylinder": {"radius": 0.5, "draft": DEPTH, "center_x": 6}}}
    alone = frequency_table(config(float=FLOAT), hulls(float=FLOAT))
    beside = frequency_table(config(pile=small, float=FLOAT), hulls(pile=small, float=FLOAT))
    np.testing.assert_array_equal(beside, alone)


def test_a_fixed_body_acts_as_one_of_two_that_move() -> None:
    """Its rows and columns are left out of the coefficients of both, and nothing else changes."""
    made = hulls(pile=PILE, float=FLOAT)
    assert [hull.fixed for hull in made] == [True, False]
    found = solved(*made)
    assert found.bodies == ("float",)
    assert found.added_mass.shape == (1, 3, 3)
    both = solved(replace(made[0], fixed=False, center=(6.0, -4.0)), made[1])
    for name in ("added_mass", "radiation_damping"):
        expected = getattr(both, name)[:, 3:, 3:]
        tolerance = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(found, name), expected, atol=tolerance)
    np.testing.assert_allclose(found.excitation, both.excitation[:, 3:], rtol=1e-9)
    alone = solved(*hulls(float=FLOAT))
    change = np.abs(found.excitation - alone.excitation)[:, :2] / np.abs(alone.excitation)[:, :2]
    assert change.max() > 0.1


def test_in_space_too() -> None:
    """Directions reach as far as the obstacle; mirror symmetry in y = 0 is kept."""
    water, moving = {"water": WATER, "dimensions": 3}, {**FLOAT, "center_of_gravity": [0, 0, -1]}
    given = HydrodynamicsConfig.model_validate({**water, "bodies": {"a": moving, "pile": PILE}})
    found = solved(*make_hulls(given, Path(), progress=lambda _: None))
    assert found.added_mass.shape == (1, 6, 6)
    np.testing.assert_array_equal(found.added_mass[0][[0, 2, 4]][:, [1, 3, 5]], 0.0)
    plane = solved(*hulls(a=FLOAT, pile=PILE))
    np.testing.assert_allclose(found.excitation[0, [0, 2, 4]], plane.excitation[0], rtol=1e-4)


def test_panels_on_the_bed_are_left_out() -> None:
    (pile, _) = hulls(pile=PILE, float=FLOAT)
    assert pile.bed is not None
    assert np.all(pile.bed.vertices[pile.bed.faces][:, :, 2] == -DEPTH)
    assert pile.panels.centers[:, 2].min() > -DEPTH
    assert pile.hydrostatics.volume == pytest.approx(np.pi * 4 * DEPTH, rel=1e-12)
    assert pile.lid is not None


def mesh_of_pile(folder: Path, *, bottom: bool) -> str:
    whole = cylinder_panels(Cylinder(radius=2, draft=DEPTH, center_x=6), 60)
    side = whole if bottom else whole.kept(whole.centers[:, 2] > -DEPTH + 1e-6)
    (folder / "pile.gdf").write_text(mesh_writers.gdf(side))
    return "pile.gdf"


@pytest.mark.parametrize("bottom", [True, False])
def test_a_mesh_may_be_open_on_the_bed(tmp_path: Path, bottom: bool) -> None:
    """It makes the same flow as the shape, and other bodies are seen to be outside of it."""
    body = {"shape": {"mesh": mesh_of_pile(tmp_path, bottom=bottom)}, "fixed": True}
    made = hulls(tmp_path, pile=body, float=FLOAT)
    expected = solved(*hulls(pile=PILE, float=FLOAT))
    found = solved(*made)
    np.testing.assert_allclose(found.excitation, expected.excitation, rtol=1e-5)
    assert made[0].hydrostatics.volume == pytest.approx(np.pi * 4 * DEPTH, rel=1e-6)
    within = {**FLOAT, "shape": {"sphere": {"radius": 0.5, "center_x": 6, "center_z": -4}}}
    _, problems = hulls_and_problems(
        config(pile=Body.model_validate(body).model_dump(exclude_unset=True), ball=within),
        tmp_path,
        progress=lambda _: None,
    )
    assert any("'pile' and 'ball' overlap" in problem.message for problem in problems)


def test_a_mesh_that_is_open_on_the_bed_must_be_fixed(tmp_path: Path) -> None:
    name = mesh_of_pile(tmp_path, bottom=False)
    with pytest.raises(InputError, match="not watertight"):
        hulls(tmp_path, pile={"shape": {"mesh": name}, "center_of_gravity": [6, -2]})
    with pytest.raises(InputError, match=r"reaches down to z = -8 m") as caught:
        hulls(tmp_path, pile={**PILE, "fixed": False, "center_of_gravity": [6, -2]})
    assert "'fixed: true'" in caught.value.problems[0].remedy


def test_a_fixed_body_may_not_go_into_the_bed(tmp_path: Path) -> None:
    shape = {"cylinder": {"radius": 2, "draft": DEPTH + 0.01, "center_x": 6}}
    with pytest.raises(InputError, match=r"reaches down to z = -8\.01 m, the sea bed is at"):
        hulls(tmp_path, pile={**PILE, "shape": shape}, float=FLOAT)


def test_a_fixed_hull_has_no_centre() -> None:
    made = make_hull("pile", Body.model_validate(PILE), Path(), progress=lambda _: None)
    assert made.fixed
    assert made.center == ()
    assert made.axis is None
    assert made.bed is None  # the water is deep
