"""Records of runs: powers in watts, and all that a run was made of."""

from __future__ import annotations

import hashlib
import platform
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import m4e_fmi
from m4e_fmi.cosim import Bond, Link, Port, Prepared, prepare
from m4e_fmi.cosim.results.run_record import _flow, record_of_system
from m4e_fmi.cosim.wiring.links import BondAxis
from m4e_fmi.report.run_report.record import Product
from m4e_fmi.units import parse_unit

SYSTEM = """\
name: s
components:
  ball: {model: sub/ball.model.yaml}
  sea: {kind: sea, waves: {spectrum: jonswap, significant_height: 2, peak_period: 8, seed: 7}}
simulation: {stop_time: 1, step_size: 0.1}
"""
BALL = "name: ball\nbodies: {b: {mass: 1, inertia: 1}}\njoints: {j: {type: floating, child: b}}\n"


def test_powers_are_in_watts_whatever_the_units() -> None:
    """3 kN on a body that moves by 2 km/h against it: 6000/3.6 W out of it."""
    force = Link(Port("pto", "p.force_x"), Port("buoy", "p.force_x"), 0)
    velocity = Link(Port("buoy", "p.vx"), Port("pto", "p.vx"), 0)
    bond = Bond("buoy.p <-> pto.p", (BondAxis(force, velocity, None, share=-1.0),), ("a", "b"))
    units = {"pto": {"p.force_x": "kN"}, "buoy": {"p.vx": "km/h"}}
    descriptions: dict[str, Any] = {
        component: SimpleNamespace(
            variables={n: SimpleNamespace(dimension=parse_unit(u)) for n, u in members.items()}
        )
        for component, members in units.items()
    }
    flow = _flow(bond, cast(Prepared, SimpleNamespace(descriptions=descriptions)))
    assert (flow.source, flow.target, flow.adds) == ("pto", "buoy", ("a", "b"))
    assert flow.products == (Product("pto.p.force_x", "buoy.p.vx", -1000.0 / 3.6),)


def test_a_record_has_files_and_versions(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/ball.model.yaml").write_text(BALL, encoding="ascii")
    (tmp_path / "s.yaml").write_text(SYSTEM, encoding="ascii")
    (tmp_path / "jonswap").write_text("a file by the name of a value", encoding="ascii")
    prepared = prepare(m4e_fmi.load_system(tmp_path / "s.yaml"), build_directory=tmp_path)
    record = record_of_system(prepared)
    texts = {one.name: one.text for one in record.inputs}
    assert texts == {"s.yaml": SYSTEM, "sub/ball.model.yaml": BALL, "jonswap": None}
    sums = {one.name: one.sha256 for one in record.inputs}
    assert sums["s.yaml"] == hashlib.sha256(SYSTEM.encode()).hexdigest()
    assert record.fmus["sea"].startswith("sea.fmu, SHA-256 ")
    assert record.versions["m4e_fmi"] == m4e_fmi.__version__
    assert record.versions["Python"] == platform.python_version()
    assert "numpy" in record.versions
    assert "pyrefly" not in record.versions  # of tests only
    graph = record.graph
    assert graph is not None
    assert [component.name for component in graph.components] == ["ball", "sea"]
