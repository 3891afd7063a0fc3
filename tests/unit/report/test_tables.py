"""A model's tables: the paper's columns, every element, text and LaTeX."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.paper_listings import double_pendulum

from m4e_fmi.cli import main
from m4e_fmi.model import Model, load_model, model_from_lists
from m4e_fmi.report.text.tables import model_listings, model_tables

EXAMPLES = Path(__file__).parents[3] / "examples"
FLAP = EXAMPLES / "paper_cases" / "flap.model.yaml"


@pytest.fixture(scope="module")
def spiderfloat() -> Model:
    return load_model(EXAMPLES / "paper_cases" / "spiderfloat.model.yaml")


def test_joints_of_table_13() -> None:
    """Sabet and Diaz-Flores Caminero, table 13: joint, bodies, type, vectors, direction."""
    joints = model_listings(model_from_lists(double_pendulum()))[1]
    assert [row[2:7] for row in joints.rows] == [
        ("0 1", "revolute", "[0, 0]", "[0, -0.5]", "-"),
        ("1 2", "revolute", "[0, -0.5]", "[0, -0.5]", "-"),
    ]


def test_everything_has_a_row(spiderfloat: Model) -> None:
    listings = model_listings(spiderfloat)
    groups = ("bodies", "joints", "points", "loads", "parameters")
    for listing, group in zip(listings, groups, strict=True):
        assert len(listing.rows) == len(getattr(spiderfloat, group))
        assert {len(row) for row in listing.rows} == {len(listing.head)}


def test_cells(spiderfloat: Model) -> None:
    text = model_tables(spiderfloat)
    bodies, joints, points, loads, _ = model_listings(spiderfloat)
    assert bodies.rows[0][:5] == ("1", "float", "1", "2", "X_1, Z_1, Theta_1")
    assert joints.rows[3][1:] == (
        "right_guide", "2 4", "prismatic", "[4.5, 0]", "[0.5, 0]", "[1, 0]", "-"
    )  # fmt: skip
    assert joints.rows[0][-1] == "x = 10, z = 6"
    assert points.rows[0][:3] == ("right_anchor", "0 ground", "[20, 0]")
    assert loads.rows[3] == (
        "right_low", "tension spring", "right_foot, right_inner", "stiffness = k, length = 9.0139"
    )  # fmt: skip
    widths = {len(line) for line in text.splitlines() if set(line) == {" ", "-"}}
    assert len(widths) == 5


def test_latex() -> None:
    text = model_tables(load_model(FLAP), latex=True)
    assert text.count(r"\begin{tabular}") == text.count(r"\end{tabular}") == 5
    assert r"left\_spring & tension spring & hold, left & stiffness = $k$" in text
    assert r"length = $\sqrt{a^{2} + b^{2}}$ \\" in text
    assert r"[$0$, $\frac{L}{2}$]" in text


def test_command(capsys: pytest.CaptureFixture) -> None:
    assert main(["info", str(FLAP)]) == 0
    text = capsys.readouterr().out
    assert "No.  Joint  Bodies  Type" in text
    assert "outputs (" in text
    assert main(["info", str(FLAP), "--latex"]) == 0
    assert capsys.readouterr().out.startswith(r"\begin{table}")
