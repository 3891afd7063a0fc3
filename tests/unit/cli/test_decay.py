"""`m4e-fmi decay`: tables, results, pictures, and its refusals."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cli import main

TIME = np.arange(0.0, 40.0, 0.1)
RATIO, OMEGA = 0.05, 2.0 * math.pi / 5.0
DAMPED = OMEGA * math.sqrt(1 - RATIO**2)
MOTION = np.exp(-RATIO * OMEGA * TIME) * (
    np.cos(DAMPED * TIME) + RATIO * OMEGA / DAMPED * np.sin(DAMPED * TIME)
)
MODEL = """
name: buoy
bodies: {float: {mass: 2000, inertia: 1}}
joints: {rail: {type: prismatic, child: float, direction: [0, 1], initial: {q: 0.5}}}
loads:
  spring: {type: joint_effort, joint: rail, effort: -8000*joint.rail.q}
  water: {type: joint_effort, joint: rail, effort: -900*abs(joint.rail.u)*joint.rail.u}
gravity: 0
"""


def table(folder: Path, header: str, factor: float = 1.0, *, rows: str = "") -> Path:
    path = folder / "tank.csv"
    lines = [f"{t:.6f},{factor * x:.12g}" for t, x in zip(TIME, MOTION, strict=True)]
    path.write_text("\n".join([header, *lines, rows]), encoding="utf-8")
    return path


def test_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, picture = table(tmp_path, "time [s],heave [mm]", 1e3), tmp_path / "p.png"
    assert main(["decay", str(path), "--mass", "3e5", "--output-file", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "tank.csv, heave [m]: free decay from 2.6 to 39.9 s, from the first peak after" in said
    assert "no drag" in said
    assert picture.is_file()
    assert main(["decay", str(path), "--mass", "3e5", "--json", "--no-plot"]) == 0
    found = json.loads(capsys.readouterr().out)
    values = {name: one["value"] for name, one in found["values"].items()}
    # the rows have 12 digits
    assert values["period"] == pytest.approx(5.0, rel=1e-6)
    assert values["damping_ratio"] == pytest.approx(RATIO, abs=1e-6)
    assert values["linear_coefficient"] == pytest.approx(2 * RATIO * OMEGA * 3e5, rel=1e-5)
    assert found["motion"] == "heave"
    assert found["values"]["rest"]["unit"] == "m"


def test_a_table_of_a_logger(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Lines above the names, decimal commas, times of day and gaps are read as by `compare`."""
    path = tmp_path / "tank.csv"
    above = ["Tank 2", "Project: 4711", "Date: 2026-03-11", "", "Clock;Heave;Pitch", ";mm;deg"]
    rows = [
        f"09:12:{t:09.6f};{'NaN' if 100 <= k < 110 else f'{1e3 * x:.9f}'};0".replace(".", ",")
        for k, (t, x) in enumerate(zip(TIME, MOTION, strict=True))
    ]
    clock = [row.replace(",", ".", 1) for row in rows]
    path.write_text("\n".join([*above, *clock]), encoding="utf-8")
    assert main(["decay", str(path), "--column", "Heave", "--no-plot"]) == 0
    said = capsys.readouterr().out
    assert "tank.csv, Heave [m]: free decay" in said
    assert "undamped period                                        5 " in said
    assert "lines above the names left out" in said
    assert "the record has a gap from 9.9 to 11 s" in said
    assert main(["decay", str(path), "--no-plot"]) == 2
    assert "2 columns beside the time" in capsys.readouterr().err


def test_marks_and_spikes_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A mark of missing values and a spike count as measured; a clean record has no such note."""
    path = table(tmp_path, "time [s],heave [mm]", 1e3)
    assert main(["decay", str(path), "--no-plot"]) == 0
    assert "as measured" not in capsys.readouterr().out
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[200] = "19.9,900"
    lines[300:303] = [f"{t},-9999" for t in (29.9, 30.0, 30.1)]
    path.write_text("\n".join(lines), encoding="utf-8")
    assert main(["decay", str(path), "--from", "3", "--no-plot"]) == 2
    said = "".join(capsys.readouterr())
    assert "3 rows are -9999 mm, the first at 29.9 s" in said
    assert "1 row is far from those beside, the first at 19.9 s (900 mm)" in said


def test_results_and_the_line_for_a_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Quadratic damping of a simulated model comes back as its coefficient."""
    model = tmp_path / "buoy.model.yaml"
    model.write_text(MODEL, encoding="utf-8")
    file = tmp_path / "buoy.nc"
    run = ["simulate", str(model), "--stop-time", "30", "--output-interval", "0.05", "--no-plot"]
    assert main([*run, "--output-file", str(file)]) == 0
    capsys.readouterr()
    given = ["--variable", "buoy.body.float.z", "--mass", "2000", "--no-plot"]
    assert main(["decay", str(file), *given]) == 0
    said = capsys.readouterr().out
    drag = float(said.partition("drag: {heave: ")[2].partition("}")[0])
    assert drag == pytest.approx(900.0, rel=1e-4)


def test_a_column_without_a_unit_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["decay", str(table(tmp_path, "time,heave")), "--no-plot"]) == 0
    assert "says no unit: taken as m" in capsys.readouterr().out


def test_degrees_are_converted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = table(tmp_path, "t,angles of pitch [deg]", 10.0)
    assert main(["decay", str(path), "--json", "--no-plot"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["release"] == pytest.approx(math.radians(10.0), rel=1e-3)
    assert found["values"]["quadratic"]["unit"] == "1/rad"
