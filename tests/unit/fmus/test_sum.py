"""The kind `sum`: one input for each source, for one signal or for connectors."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import Component, Kind, ModelFile, Simulation, System, prepare, run
from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.report import run_summary
from m4e_fmus import linear_pto, table
from m4e_fmus.sum import Config, make


def program(**keys: Any) -> Program:
    return make(Config(**keys), name="total", folder=Path())


def outputs(total: Program, *inputs: float) -> list[float]:
    parameters = [v.start for v in total.parameters]
    return load_python(total).outputs(0.0, [], list(inputs), parameters, [])


def test_a_list_is_added_up() -> None:
    total = program(inputs=["wind", "waves", "tow"], unit="kN")
    assert [(v.name, v.unit) for v in total.inputs] == [
        ("wind", "kN"),
        ("waves", "kN"),
        ("tow", "kN"),
    ]
    assert [v.name for v in total.outputs] == ["sum"]
    assert outputs(total, 1.0, 20.0, 300.0) == [321.0]


def test_factors_are_tunable_parameters() -> None:
    total = program(inputs={"wind": 0.5, "drag": -1}, unit="N")
    assert {v.name: v.start for v in total.parameters} == {"factor.wind": 0.5, "factor.drag": -1.0}
    assert all(v.tunable for v in total.parameters)
    assert outputs(total, 10.0, 3.0) == [2.0]


def test_connectors_are_added_up_signal_by_signal() -> None:
    total = program(inputs=["a", "b"], signals={"force_x": "N", "moment_y": "N.m"})
    names = [v.name for v in total.inputs]
    assert names == ["a.force_x", "b.force_x", "a.moment_y", "b.moment_y"]
    assert [(v.name, v.unit) for v in total.outputs] == [
        ("sum.force_x", "N"),
        ("sum.moment_y", "N.m"),
    ]
    assert outputs(total, 1.0, 2.0, 30.0, 40.0) == [3.0, 70.0]


def read(text: str) -> Config:
    """The configuration of a component `c` of a system file."""
    return Document.parse("c:\n" + indent(text, "  ")).validate(Config, at=("c",))


GOOD = "inputs: {a: 1, b: -1}\nunit: N\n"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("unit: N", "unit: Nx", "'Nx' is not a unit known here"),
        ("unit: N\n", "", "in one way"),
        ("unit: N", "unit: N\nsignals: {force_x: N}", "in one way"),
        ("unit: N", "signals: {force_x: Nx}", "'Nx' is not a unit known here"),
        ("unit: N", "signals: {}", "at least 1 item"),
        ("{a: 1, b: -1}", "{}", "at least 1 item"),
        ("a: 1", "sum: 1", "cannot be called sum"),
        ("a: 1", "factor: 1", "cannot be called factor"),
        ("a: 1", "time: 1", "cannot be called time"),
        ("a: 1", "a.b: 1", "pattern"),
        ("a: 1", "a: .nan", "finite number"),
        ("a: 1", "a: x", "expected a number, got 'x'"),
        ("{a: 1, b: -1}", "[a, b, a]", "'a' is named twice"),
    ],
)
def test_mistakes(old: str, new: str, message: str) -> None:
    assert GOOD.count(old) == 1
    with pytest.raises(InputError) as caught:
        read(GOOD.replace(old, new))
    (problem,) = caught.value.problems
    assert message in problem.message
    assert problem.line > 0


def test_several_sources_in_other_units(tmp_path: Path) -> None:
    def source(name: str, unit: str, value: float) -> Component:
        signals = {"f": {"unit": unit, "values": [value, value]}}
        return Component(name, Kind("table", table.Config(times=[0, 1], signals=signals)))  # pyright: ignore

    both = Component("both", Kind("sum", Config(inputs=["wind", "drag"], unit="kN")))  # pyright: ignore
    parts = (source("wind", "N", 1500.0), source("drag", "kN", -0.25), both)
    links = ("wind.f -> both.wind", "drag.f -> both.drag")
    system = System("s", parts, links, Simulation(1.0, 0.5))
    outcome = run(prepare(system, build_directory=tmp_path), results=tmp_path / "r.nc")
    assert outcome.results()["both.sum"].values == pytest.approx([1.25] * 3, rel=1e-15)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "corrector", "implicit"])
def test_a_tunable_parameter_follows_an_output(algorithm: str, tmp_path: Path) -> None:
    """With y the sum of 2 x, x = 3, whose factor a table raises from 2 to 7 at 0.5 s."""
    signals = {"f": {"values": [2, 2, 7, 7]}, "x": {"values": [3, 3, 3, 3]}}
    steps = table.Config(times=[0, 0.5, 0.5, 1], signals=signals)  # pyright: ignore
    total = Component("c", Kind("sum", Config(inputs=["u"], unit="1")))  # pyright: ignore
    parts = (total, Component("t", Kind("table", steps)))
    links = ("t.x -> c.u", "t.f -> c.factor.u")
    system = System("s", parts, links, Simulation(1.0, 0.25, algorithm))  # pyright: ignore
    outcome = run(prepare(system, build_directory=tmp_path), results=tmp_path / "r.nc")
    results = outcome.results()
    expected = np.where(results.time < 0.5, 6.0, 21.0)
    at_jump = np.isclose(results.time, 0.5)  # one row on either side
    np.testing.assert_allclose(results["c.sum"].values[~at_jump], expected[~at_jump], rtol=1e-14)


def test_two_sources_of_one_input_lead_to_the_sum(tmp_path: Path) -> None:
    one = Kind("table", table.Config(times=[0, 1], signals={"f": {"values": [0, 1]}}))  # pyright: ignore
    parts = (
        Component("a", one),
        Component("b", one),
        Component("c", Kind("sum", Config(inputs=["u"], unit="1"))),  # pyright: ignore
    )
    links = ("a.f -> c.u", "b.f -> c.u")
    with pytest.raises(InputError, match=r"c\.u has two sources(.|\n)*kind: sum"):
        prepare(System("s", parts, links, Simulation(1.0, 0.5)), build_directory=tmp_path)


def test_the_energy_of_forces_that_are_added_up(tmp_path: Path) -> None:
    """Two dampers brake a mass by a sum: what they take is what the body gives.

    m v' = -(c1 + c2) v: of 2 J at the start there are 2 exp(-2 (c1 + c2) t/m) J left.
    """
    model = tmp_path / "sled.model.yaml"
    model.write_text(
        "name: sled\ngravity: 0\nbodies: {b: {mass: 4, inertia: 1}}\n"
        "joints: {j: {type: prismatic, child: b, direction: [1, 0], initial: {u: 1}}}\n"
        "points: {end: {body: b, at: [0, 0]}}\n"
    )

    def damper(damping: float) -> Kind:
        keys = {"point": "p", "anchor": [-50, 0], "damping": damping, "rest_length": 50}
        return Kind("linear_pto", linear_pto.Config(**keys, stiffness=0))

    total = Config(inputs=["a", "b"], signals={"force_x": "N", "force_z": "N"})  # pyright: ignore
    parts = (
        Component("sled", ModelFile(model)),
        Component("a", damper(1.0)),
        Component("b", damper(0.5)),
        Component("total", Kind("sum", total)),
    )
    motion = [f"sled.point.end.{x} -> {c}.p.{x}" for c in "ab" for x in ("x", "z", "vx", "vz")]
    links = ("a.p <-> total.a", "b.p <-> total.b", "total.sum <-> sled.end", *motion)
    system = System("s", parts, links, Simulation(2.0, 0.01))
    outcome = run(prepare(system, build_directory=tmp_path), results=tmp_path / "r.nc")
    (bond,) = outcome.energy
    assert bond.adds == ("a", "b")
    taken = 2.0 * (np.exp(-2 * 1.5 * 2.0 / 4.0) - 1.0)
    # trapezoids of a power that falls at the rate 2 c/m: (rate H)²/12
    assert bond.given == pytest.approx(taken, rel=0.75**2 * 0.01**2 / 12 * 1.1)
    results = outcome.results()
    lost = results["a.energy"][-1] + results["b.energy"][-1]
    assert bond.received == pytest.approx(-lost, rel=1e-4)
    text = run_summary(outcome)
    assert "total.sum <-> sled.end" in text
    assert "the sum of the forces of a, b, counted as one" in text
    assert "-1.554 J" in text
