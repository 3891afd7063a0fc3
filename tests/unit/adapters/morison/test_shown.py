"""Members in animations: cylinders on their bodies, beside hulls of other components."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.frames import floating_frame

from m4e_adapters.morison import MorisonConfig
from m4e_adapters.morison.shown import shown
from m4e_fmi.cosim import load_system, scene_without_build


def test_a_member_is_a_cylinder(tmp_path: Path) -> None:
    ends = [[-3, 1, -4], [5, 4, 2]]
    member = {"ends": ends, "diameter": 0.8, "drag": 1}
    config = MorisonConfig.model_validate({"dimensions": 3, "members": {"leg": member}})
    (hull,) = shown(config, folder=tmp_path, values={}).hulls
    assert hull.fixed
    first, second = map(np.array, ends)
    length = np.linalg.norm(second - first)
    axis, away = (second - first) / length, hull.surface.vertices - first
    along = away @ axis
    across = np.linalg.norm(away - along[:, None] * axis, axis=1)
    assert across == pytest.approx(np.full(len(across), 0.4))
    assert np.sort(np.unique(along.round(9))) == pytest.approx([0.0, length])


def test_members_are_on_their_body_beside_hulls(tmp_path: Path) -> None:
    path = floating_frame(tmp_path)
    scene = scene_without_build(load_system(path))
    assert scene is not None
    (body,) = [b for b in scene.bodies if b.name == "frame.frame"]
    (surface,) = body.surfaces
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    assert (low[2], high[2]) == pytest.approx((-4.0, 12.0))  # from the centre of gravity
    assert scene.water is not None
    hull = (
        "  hull: {kind: hydrodynamics, dimensions: 3, bodies: {deck: "
        "{shape: {sphere: {radius: 2}}, center_of_gravity: [0, 0, -6]}}}"
    )
    text = path.read_text("utf-8")
    text = text.replace("connections: [", f"{hull}\nconnections: [frame.frame <-> hull.deck, ")
    path.write_text(text, "utf-8")
    scene = scene_without_build(load_system(path))
    assert scene is not None
    (body,) = [b for b in scene.bodies if b.name == "frame.frame"]
    assert len(body.surfaces) == 2
