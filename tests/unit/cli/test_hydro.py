"""`m4e-fmi hydro`: tables, files, pictures, and its refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.coefficient_files import SPHERE, rm3_files, rm3_system

Said = Callable[..., str]


def test_a_file(tmp_path: Path, said: Said) -> None:
    output = tmp_path / "sphere.nc"
    printed = said("hydro", SPHERE, "--output-file", output)
    assert "oes10_sphere: 6 motions, 240 frequencies from 0.05 to 12 rad/s" in printed
    assert "A∞ is that of the file" in printed
    assert "cost: 26 states," in printed
    assert "causality: A∞ differs by up to 0.1" in printed
    assert f"wrote {output}" in printed
    assert output.with_suffix(".png").stat().st_size > 50_000
    with xarray.open_dataset(output) as found:
        heave = found.sel(force="sphere heave", motion="sphere heave")
        assert float(heave["added_mass_inf"]) == pytest.approx(130876.8, rel=1e-6)
        # the fit, and the cosine transform of the data, which end at 12 rad/s
        memory, fit = heave["radiation_irf"].values, heave["fit_radiation_irf"].values
        assert np.abs(memory - fit).max() < 3e-3 * np.abs(fit).max()


def test_a_system_as_json(tmp_path: Path, said: Said) -> None:
    path, output = rm3_system(tmp_path, modes=(3, 9)), tmp_path / "rm3.nc"
    given = [path, "--json", "--no-plot", "--output-file", output]
    found = json.loads(said("hydro", *given))
    assert not output.with_suffix(".png").exists()
    assert found["motions"][2] == "float heave"
    assert found["added_mass_inf"][2][2] == pytest.approx(1_232_838, rel=1e-6)
    assert found["memories"][0]["motions"] == ["float heave", "spar heave"]
    assert found["states"] == found["memories"][0]["states"]
    assert {f["name"] for f in found["findings"]} >= {"causality", "long waves"}


def test_the_depth_of_a_file(tmp_path: Path, said: Said) -> None:
    rm3_files(tmp_path, (3, 9))
    given = ["hydro", str(tmp_path / "rm3.1"), "--no-plot"]
    given += ["--output-file", str(tmp_path / "a.nc")]
    assert "depth 400 m of the system file" in said(*given, "--depth", "400")
    assert "--depth must be positive" in said(*given, "--depth", "-4", code=2)


BOX = """\
name: box
components:
  hydro:
    kind: hydrodynamics
    bodies:
      float:
        shape: {box: {length: 8, width: 6, draft: 3}}
        center_of_gravity: [0, -1]
        panels: 48
    frequencies: {count: 12, maximum: 1.0}
connections: []
simulation: {stop_time: 1, step_size: 0.1}
"""


def test_a_convergence_study(here: Path, said: Said) -> None:
    path = here / "box.system.yaml"
    path.write_text(BOX, "utf-8")
    printed = said("hydro", path, "--refine")
    assert printed.startswith("meshes of 48, 192, 432 panels; errors up to ")
    assert "added_mass float heave" in printed
    found = json.loads(said("hydro", path, "--refine", "--json"))
    assert found["panels"] == [48, 192, 432]
    rows = {(row["quantity"], row["motions"]): row for row in found["rows"]}
    heave = rows["added_mass", "float heave"]
    assert heave["largest"] == pytest.approx(max(a[1][1] for a in found["added_mass"]), rel=1e-9)
    assert heave["errors"] == sorted(heave["errors"], reverse=True)
    assert heave["errors"][-1] > heave["error_of_limit"] > 0
    assert 0.5 < heave["order"] < 2.5
