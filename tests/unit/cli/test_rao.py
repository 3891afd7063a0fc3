"""`m4e-fmi rao`: tables, files, pictures, and its refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray
from support.floating_buoy import held_buoy

from m4e_fmi.cli import main

SEA = "{spectrum: jonswap, significant_height: 1.5, peak_period: 8, components: 60}"


@pytest.fixture(scope="module")
def buoy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return held_buoy(tmp_path_factory.mktemp("buoy"), SEA)


def test_regular_waves(buoy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "r.nc"
    given = ["--periods", "5:9:3", "12", "--height", "1", "--output-file", str(file)]
    assert main(["rao", str(buoy), *given]) == 0
    printed = capsys.readouterr().out
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
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    path = held_buoy(tmp_path, SEA)
    line = f"  line: {{fmu: {c_fmu('spring')}, start: {{stiffness: 1e4}}}}\nconnections:\n"
    for name, ends in (("x", "{0} -> {1}"), ("vx", "{0} -> {1}"), ("force_x", "{1} -> {0}")):
        line += f"  - {ends.format(f'buoy.point.middle.{name}', f'line.end.{name}')}\n"
    path.write_text(path.read_text("utf-8").replace("connections:\n", line), encoding="utf-8")
    given = ["--settled", "line", "--periods", "8", "--height", "0.5", "--check", "--no-plot"]
    assert main(["rao", str(path), *given, "--outputs", "line.end.force_x"]) == 0
    told = capsys.readouterr()
    assert "note: line (settled): linear about the rest in still water, and without" in told.out
    assert "note: line.end.force_x: quasi-static, without dynamics" in told.out
    assert "note: line: the same law at rest in this simulation, which checks nothing" in told.err


def test_the_sea_of_the_file_and_another(
    buoy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for sea in ([], ["1.5", "8"]):
        file = tmp_path / "sea.nc"
        given = ["--sea", *sea, "--json", "--output-file", str(file)]
        assert main(["rao", str(buoy), *given]) == 0
        found.append(json.loads(capsys.readouterr().out))
    heave = found[0]["outputs"]["buoy.body.float.z"]["zero_crossing_period"]
    assert 5 < heave < 9
    own, other = (x["outputs"]["generator.power"]["mean"] for x in found)
    assert found[0]["significant_height"] == pytest.approx(1.5)
    # 60 components at random frequencies, beside 300 in the middles of their parts
    assert own == pytest.approx(other, rel=0.05)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--periods", "4:14"], "FIRST:LAST:COUNT"),
        (["--periods", "0"], "wave periods must be positive, got 0 s"),
        (["--sea", "2"], "HEIGHT PERIOD [GAMMA]"),
        (["--sea", "2", "-8"], "must be positive"),
        (["--sea", "--height", "1"], "leave out --height and --periods"),
        (["--check"], "add --height, or --sea"),
        (["--headings", "30"], "the excitation was computed for waves that travel at 0 deg"),
        (["--outputs", "buoy.body.flaot.z"], "no output or state"),
        (["--sea", "2", "8", "11"], "between 1 and 10"),
        (["--open", "buoy", "generator"], "no output to show"),
        (["--height", "-1"], "must not be negative"),
    ],
)
def test_refusals(
    given: list[str], said: str, buoy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["rao", str(buoy), *given])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert said in capsys.readouterr().err


def test_a_model_alone_is_in_no_waves(buoy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rao", str(buoy.parent / "buoy.model.yaml")]) == 2
    assert "a model alone is in no waves" in capsys.readouterr().err


def test_still_water_has_no_sea(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rao", str(held_buoy(tmp_path)), "--sea"]) == 2
    assert "configured with no irregular sea" in capsys.readouterr().err


def test_what_is_wrong_is_told_before_the_flow_is_computed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = held_buoy(tmp_path)
    text = path.read_text("utf-8").replace("panels: 120", "panels: 333")  # not in the cache
    text = text.replace("buoy.float  ", "buoy.flaot  ")
    path.write_text(text, encoding="utf-8")
    assert main(["rao", str(path)]) == 2
    told = capsys.readouterr()
    assert "flaot" in told.err
    assert "potential flow" not in told.out + told.err
