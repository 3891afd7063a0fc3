"""Reports of any file: of a study by its own page, refusals of what is no result of ours."""

from __future__ import annotations

from pathlib import Path

import netCDF4
import pytest
from support.command_line import refused
from support.written_study import matrix

import m4e_fmi as m4e
from m4e_fmi.cli import main
from m4e_fmi.study import report_of_study


def test_the_result_of_a_study_has_the_page_of_studies(tmp_path: Path) -> None:
    file = matrix(tmp_path)
    page = m4e.write_report(file)
    assert page == file.with_suffix(".report.html")
    own = report_of_study(file, tmp_path / "own.html")
    assert page.read_bytes() == own.read_bytes()
    assert main(["report", str(file), "--output-file", str(tmp_path / "other.html")]) == 0
    assert (tmp_path / "other.html").read_bytes() == page.read_bytes()


def test_what_is_no_result_is_refused_by_its_content(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    waves, table, cut = (tmp_path / name for name in ("rao.nc", "table.csv", "cut.nc"))
    with netCDF4.Dataset(waves, "w") as file:
        for name in ("direction", "period"):
            file.createDimension(name, 2)
        file.createVariable("buoy.z.amplitude", "f8", ("direction", "period"))
    table.write_text("time,x\n0,1\n1,2\n")
    cut.write_bytes(waves.read_bytes()[:100])
    assert "has numbers over direction, period" in refused(capsys, "report", waves)
    assert "a table (CSV) with the first line 'time,x'" in refused(capsys, "report", table)
    assert "cut off or damaged" in refused(capsys, "report", cut)
    assert "no such file" in refused(capsys, "report", tmp_path / "none.nc")
    assert "use .html" in refused(capsys, "report", matrix(tmp_path), "--output-file", "r.pdf")
    assert not list(tmp_path.glob("*.html"))
