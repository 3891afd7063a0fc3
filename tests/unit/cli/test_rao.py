"""`m4e-fmi rao`: tables, files, pictures; mistakes are in tests/corpus/rao.yaml."""

from __future__ import annotations

import json
import math
import statistics
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray
from support.floating_buoy import held_buoy

Said = Callable[..., str]
SEA = "{spectrum: jonswap, significant_height: 1.5, peak_period: 8, components: 60}"


@pytest.fixture(scope="module")
def buoy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return held_buoy(tmp_path_factory.mktemp("buoy"), SEA)


def test_regular_waves(buoy: Path, tmp_path: Path, said: Said) -> None:
    file = tmp_path / "r.nc"
    given = ["--periods", "5:9:3", "12", "--height", "1", "--output-file", str(file)]
    printed = said("rao", buoy, *given)
    assert "response to waves of 1 m" in printed
    assert "waves to 0 deg" in printed
    assert f"wrote {file}" in printed
    assert file.with_suffix(".png").is_file()
    with xarray.open_dataset(file) as found:
        assert found["period"].values.tolist() == pytest.approx([5, 7, 9, 12])
        heave = found["buoy.body.float.z.amplitude"]
        assert heave.dims == ("direction", "period")
        assert heave.attrs["units"] == "(m)/m"
        assert float(heave[0, 3]) == pytest.approx(0.95, abs=0.05)
        assert float(found["generator.power.mean"][0, 1]) > 0


def test_what_is_settled_is_told_to_have_no_dynamics(
    c_fmu: Callable[[str], Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    said: Said,
) -> None:
    monkeypatch.chdir(tmp_path)
    path = held_buoy(tmp_path, SEA)
    line = f"  line: {{fmu: {c_fmu('spring')}, start: {{stiffness: 1e4}}}}\nconnections:\n"
    for name, ends in (("x", "{0} -> {1}"), ("vx", "{0} -> {1}"), ("force_x", "{1} -> {0}")):
        line += f"  - {ends.format(f'buoy.point.middle.{name}', f'line.end.{name}')}\n"
    path.write_text(path.read_text("utf-8").replace("connections:\n", line), encoding="utf-8")
    given = ["--settled", "line", "--periods", "8", "--height", "0.5", "--no-plot"]
    told = said("rao", path, *given, "--outputs", "line.end.force_x")
    assert "note: line (settled): linear about the rest in still water, and without" in told
    assert "note: line.end.force_x: quasi-static, without dynamics" in told


def test_the_sea_of_the_file_and_another(buoy: Path, tmp_path: Path, said: Said) -> None:
    found = []
    for sea in ([], ["1.5", "8"]):
        file = tmp_path / "sea.nc"
        given = ["--sea", *sea, "--json", "--output-file", str(file)]
        found.append(json.loads(said("rao", buoy, *given)))
    heave = found[0]["outputs"]["buoy.body.float.z"]["zero_crossing_period"]
    assert 5 < heave < 9
    own, other = (x["outputs"]["generator.power"]["mean"] for x in found)
    assert found[0]["significant_height"] == pytest.approx(1.5)
    # 0.9034 of the peak period, by the integrals of a JONSWAP spectrum of 3.3
    assert found[1]["energy_period"] == pytest.approx(0.9034 * 8.0, rel=0.01)
    # 60 components at random frequencies, beside 300 in the middles of their parts
    assert own == pytest.approx(other, rel=0.05)


@pytest.mark.parametrize(("given", "part"), [
    (["--headings", "30"], "use one of these directions"),
    (["--outputs", "buoy.body.flaot.z"], "did you mean 'buoy.body.float.z'"),
    (["--open", "buoy", "generator"], "no output to show"),
    (["--height", "-1"], "must not be negative"),
    (["--outputs", "generator.power"], "powers are of second order, in small waves 0"),
])  # fmt: skip
def test_what_is_wrong_with_computed_coefficients(
    given: list[str], part: str, buoy: Path, said: Said
) -> None:
    """Other mistakes are in tests/corpus/rao.yaml."""
    assert part in said("rao", buoy, *given, code=2)


def test_still_water_has_no_sea(tmp_path: Path, said: Said) -> None:
    assert "configured with no irregular sea" in said(
        "rao", str(held_buoy(tmp_path)), "--sea", code=2
    )


def test_waves_that_break_and_seas_that_are_too_steep_are_told(
    buoy: Path, tmp_path: Path, said: Said
) -> None:
    """Which periods, in the table and in the JSON."""
    file = ["--no-plot", "--output-file", str(tmp_path / "r.nc")]
    heights = ["--periods", "3", "4", "8", "--height", "2.5", "--outputs", "buoy.body.float.z"]
    text = said("rao", buoy, *heights, *file)
    told = [line for line in text.splitlines() if " break " in line]
    assert told == [
        "note: waves of 2.5 m break at periods of 3 s (at 3 s above 2 m): there are no such waves: "
        "take lower or longer ones"
    ]
    start = ("--start-value", "hydro.wave.significant_height", "7")
    for sea, part in (
        (("5", "8"), ""),
        (("7", "8"), "the sea is too steep: 2 pi Hs/(g Tp^2) is 0.0701"),
        (start, "Hs 7 m, Tp 8 s"),
    ):
        notes = json.loads(said("rao", buoy, "--sea", *sea, "--json", *file))["notes"]
        steep = [note for note in notes if "too steep" in note]
        assert part in steep[0] if part else not steep


ROWS = [0.2 * math.sin(0.45 * k) + 0.1 * math.sin(0.3 * k + 1) for k in range(400)]
SEVERAL = """&sea
      - {spectrum: jonswap, significant_height: 0.9, peak_period: 8, components: 60}
      - {spectrum: regular, height: 0.4, period: 12}
      - {spectrum: record, file: r.csv, place: [-40]}"""
GAUGE = """\
  gauge:
    kind: sea
    water: {density: 1025, depth: 50, gravity: 9.81}
    waves: *sea
    points: {a: [0, 0]}
    moving_points: {b: [0, -1.2]}
  generator:
"""


@pytest.fixture(scope="module")
def several(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The buoy in three systems of waves, with the sea at two points beside it."""
    folder = tmp_path_factory.mktemp("several")
    rows = "".join(f"{0.5 * k},{value!r}\n" for k, value in enumerate(ROWS))
    (folder / "r.csv").write_text(f"time,elevation\n{rows}")
    path = held_buoy(folder, SEVERAL)
    text = path.read_text(encoding="utf-8").replace("  generator:\n", GAUGE)
    links = "  - buoy.body.float.x -> gauge.b.x\n  - buoy.body.float.z -> gauge.b.z\n"
    path.write_text(text.replace("connections:\n", f"connections:\n{links}"), encoding="utf-8")
    return path


def test_several_systems_of_waves_are_one_sea(several: Path, tmp_path: Path, said: Said) -> None:
    """The sum of the spectra; the sea's component takes part, as linear waves."""
    given = ["--json", "--output-file", str(tmp_path / "sea.nc"), "--outputs",
             "hydro.wave.elevation", "gauge.a.elevation", "gauge.b.velocity_x"]  # fmt: skip
    found = json.loads(said("rao", str(several), "--sea", *given))
    record = statistics.pvariance(ROWS)  # of all rows: the tapered ends take 8.5 % of a run's
    variance = 0.9**2 / 16 + 0.2**2 / 2 + record
    assert found["significant_height"] == pytest.approx(4 * math.sqrt(variance), rel=1e-6)
    outputs = found["outputs"]
    deviation = outputs["hydro.wave.elevation"]["standard_deviation"]
    assert deviation == pytest.approx(found["significant_height"] / 4, rel=1e-9)
    assert outputs["gauge.a.elevation"]["standard_deviation"] == pytest.approx(deviation, rel=1e-9)
    assert 0.3 < outputs["gauge.b.velocity_x"]["standard_deviation"] / deviation < 1.5
