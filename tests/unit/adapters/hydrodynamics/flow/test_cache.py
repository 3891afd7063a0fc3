"""The cache of hydrodynamic coefficients: what it depends on, damage, several processes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import published_coefficients

from m4e_adapters.hydrodynamics.config import Box, Water
from m4e_adapters.hydrodynamics.flow import bem, cache
from m4e_adapters.hydrodynamics.geometry.hydrostatics import hydrostatics_of
from m4e_adapters.hydrodynamics.geometry.mesh import Hull
from m4e_adapters.hydrodynamics.geometry.panels import Panels
from m4e_adapters.hydrodynamics.geometry.shapes import box_panels
from m4e_adapters.hydrodynamics.memory import group_fit
from m4e_adapters.hydrodynamics.memory.radiation import fit_radiation

ORDER = 5
FROM_CACHE = "potential flow: coefficients taken from the cache"
PART = "potential flow: coefficients of {} frequencies taken from the cache"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(cache.ENVIRONMENT, str(tmp_path))
    return tmp_path / "hydrodynamics"


def hull(panels: Panels | None = None, center: tuple[float, float] = (0.0, -1.0)) -> Hull:
    panels = panels or box_panels(Box(length=6.0, width=4.0, draft=2.0), 48)
    return Hull("float", panels, None, center, hydrostatics_of(panels))


def test_all_that_counts_is_in_the_key(monkeypatch: pytest.MonkeyPatch) -> None:
    one, omega = hull(), 1.0
    moved = one.panels.vertices.copy()
    moved[-1, 2] = np.nextafter(moved[-1, 2], 1.0)
    lid = Panels(one.panels.vertices, one.panels.faces[:1])
    water = Water()

    def key(
        hulls: Any = (one,), water: Water = water, omega: float = omega, at: float = 0.0
    ) -> str:
        content = bem._content(hulls, water)
        return cache.content_key({**content, "omega": omega, "directions": [at]})

    keys = [
        key(),
        key(hulls=(hull(Panels(moved, one.panels.faces)),)),
        key(hulls=(hull(center=(0.0, -1.5)),)),
        key(hulls=(replace(one, lid=lid),)),
        key(hulls=(one, one)),
        key(omega=omega + 1e-15),
        key(omega=math.inf),
        key(at=180.0),
        *(key(water=water.model_copy(update={name: 7.0})) for name in Water.model_fields),
    ]
    assert key() == keys[0]
    for name in bem.CODE:
        with monkeypatch.context() as patch:
            changed = f"m4e_adapters.hydrodynamics.{name}"
            patch.setattr(bem, "package_hash", lambda n, changed=changed: str(n == changed))
            keys.append(key())
    for name in bem.LIBRARIES:
        with monkeypatch.context() as patch:
            patch.setattr(bem, "version", lambda n, name=name: "0" if n == name else "1")
            keys.append(key())
    assert len(set(keys)) == len(keys)


class Flow:
    """In the place of the solver: takes no time, and fails from the `lasting`-th frequency on."""

    lasting = math.inf

    def __init__(self, *_: Any) -> None:
        self.solved = 0

    def at(self, omega: float, directions: list[float]) -> dict[str, np.ndarray]:
        if self.solved >= self.lasting:
            raise KeyboardInterrupt
        self.solved += 1
        flat = np.full((3, 3), 1 / omega)
        warnings = np.array(["coarse"] if 0.3 < omega < math.inf else [], dtype=str)
        waves = np.ones((len(directions), 3), dtype=complex)
        return {"added_mass": flat, "radiation_damping": flat, "excitation": waves,
                "warnings": warnings}  # fmt: skip


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[str]]:
    """`solved()` solves a hull and returns what was told."""
    monkeypatch.setattr(bem, "FlowSolver", Flow)

    def told(*omega: float) -> list[str]:
        lines: list[str] = []
        table = np.array(omega or [0.3])
        found = bem.solve_hulls([hull()], water=Water(), omega=table, progress=lines.append)
        assert found.added_mass[:, 0, 0] == pytest.approx(1 / table, rel=1e-15)
        return lines

    return told


def test_frequencies_are_kept_one_by_one_and_computed_again_where_damaged(
    folder: Path, solved: Callable[..., list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What was computed before an interruption stays; another table computes what it has more."""
    with monkeypatch.context() as patch:
        patch.setattr(Flow, "lasting", 2)
        with pytest.raises(KeyboardInterrupt):
            solved(0.1, 0.2, 0.3)
    assert solved(0.1, 0.2, 0.3)[0] == PART.format("2 of 4")
    assert solved(0.1, 0.2, 0.3, 0.4) == [
        PART.format("4 of 5"),
        "potential flow: frequency 1 of 1",
        "warning: capytaine: coarse",
    ]
    assert solved(0.2, 0.4) == [FROM_CACHE, "warning: capytaine: coarse"]
    files = sorted(folder.iterdir())
    for file in files:
        content = file.read_bytes()
        file.write_bytes(content[:-20])
        told = solved(0.1, 0.2, 0.3, 0.4)
        assert f"cannot be used and are computed again: {file} is damaged" in told[0]
        assert file.read_bytes() == content
    files[-1].unlink()
    files[-1].mkdir()  # neither to be read nor to be replaced
    assert any("the coefficients are not cached" in line for line in solved(0.1, 0.2, 0.3, 0.4))


def test_a_memory_is_fitted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    data = published_coefficients.sphere()
    first, told = fit_radiation(data, order=ORDER), list[str]()
    with monkeypatch.context() as patch:
        patch.setattr(group_fit, "fit_group", lambda *_, **__: pytest.fail("fitted again"))
        second = fit_radiation(data, order=ORDER, progress=told.append)
        changed = replace(data, added_mass=data.added_mass * (1 + 1e-12))
        for other, order in ((data, ORDER + 1), (changed, ORDER)):
            with pytest.raises(pytest.fail.Exception, match="again"):
                fit_radiation(other, order=order)
    for one, other in zip(first.groups, second.groups, strict=True):
        for name, value in vars(one).items():
            assert np.array_equal(value, getattr(other, name)), name
    assert "radiation of" in told[-1]
