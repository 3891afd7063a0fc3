"""`m4e-fmi compare`: exit codes, text, JSON, pictures, maps, refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

Said = Callable[..., str]
TIME = np.linspace(0.0, 30.0, 601)
ROWS = {"ours": 1.0, "near": 1.001, "far": 1.2}


@pytest.fixture
def files(here: Path) -> Path:
    for name, factor in ROWS.items():
        values = np.stack([TIME, factor * np.sin(TIME), np.cos(TIME)], axis=1)
        lines = [",".join(f"{x:.9g}" for x in row) for row in values]
        text = "\n".join(["time [s],buoy.z [m],buoy.pitch [rad]", *lines])
        (here / f"{name}.csv").write_text(text, encoding="utf-8")
    return here


@pytest.mark.usefixtures("files")
def test_exit_codes_and_text(said: Said) -> None:
    assert "all 2 variables are within 1 % of the range" in said(
        "compare", "ours.csv", "near.csv", "--tolerance", "0.01", "--no-plot"
    )
    text = said("compare", "ours.csv", "far.csv", "--tolerance", "0.01", "--no-plot", code=1)
    assert "1 of 2 variables beyond 1 % of the range" in text
    first = next(line for line in text.splitlines() if "buoy." in line)
    assert "buoy.z" in first  # the largest difference
    assert "0.83333" in first  # amplitude ratio
    said("compare", "ours.csv", "far.csv", "--no-plot")


def test_a_part_of_the_reference_is_no_pass(files: Path, said: Said) -> None:
    rows = (files / "near.csv").read_text("utf-8").splitlines()
    (files / "failed.csv").write_text("\n".join(rows[:302]), encoding="utf-8")
    command = ["compare", "failed.csv", "ours.csv", "--tolerance", "0.01", "--no-plot"]
    text = said(*command, code=1)
    assert "not within: failed.csv lacks 15 to 30 s of the reference" in text
    assert "in the times of both, all 2 variables are within 1 % of the range" in text
    found = json.loads(said(*command, "--json", code=1))
    assert found["within"] is False
    assert found["lacking"] == [[15.0, 30.0]]
    said(*command, "--stop-time", "15")


@pytest.mark.usefixtures("files")
def test_json_and_picture(said: Said) -> None:
    found = json.loads(said("compare", "ours.csv", "far.csv", "--json", "--tolerance", "0.1"))
    assert found["within"] is True
    one = found["variables"]["buoy.z"]
    assert one["rms_share"] == pytest.approx(
        0.2 / 2.4 * one["amplitude"] / 1.2 / np.sqrt(2), rel=0.05
    )
    assert one["first_beyond"] is None
    assert one["largest_of_value"] == pytest.approx(2.0 * one["largest_of_range"], rel=1e-3)
    assert Path("build/ours_compared.png").is_file()
    assert "wrote p.svg" in said("compare", "ours.csv", "far.csv", "--output-file", "p.svg")
    assert Path("p.svg").is_file()


def test_maps_of_names(files: Path, said: Said) -> None:
    text = (files / "near.csv").read_text().replace("buoy.z [m]", "Heave (cm)")
    (files / "tool.csv").write_text(text.replace("buoy.pitch", "P=1"))
    pairs = ["--map", "Heave=buoy.z", "--map", "P=1=buoy.pitch"]
    given = json.loads(said("compare", "ours.csv", "tool.csv", "--json", "--no-plot", *pairs))
    assert "buoy.z: 'Heave' converted from cm to m" in "".join(given["notes"]).replace("ours", "")
