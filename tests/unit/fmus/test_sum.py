"""The kind `sum`: one input for each source, for one signal or for connectors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import Component, Kind, ModelFile, Simulation, System, prepare, run
from m4e_fmi.program import Program
from m4e_fmi.program.python_form import load_python
from m4e_fmi.report import run_summary
from m4e_fmus import linear_pto, table
from m4e_fmus.sum import KIND, Config


def program(**keys: Any) -> Program:
    return KIND.build(Config(**keys), name="total", folder=Path())


@pytest.mark.parametrize(
    ("keys", "inputs", "sums", "values", "expected"),
    [
        ({"inputs": ["a", "b", "c"], "unit": "kN"}, "a b c", "sum", (1, 20, 300), [321]),
        ({"inputs": {"a": 0.5, "b": -1}, "unit": "N"}, "a b", "sum", (10, 3), [2]),
        (
            {"inputs": ["a", "b"], "signals": {"force_x": "N", "moment_y": "N.m"}},
            "a.force_x b.force_x a.moment_y b.moment_y",
            "sum.force_x sum.moment_y",
            (1, 2, 30, 40),
            [3, 70],
        ),
    ],
    ids=["a list", "with factors", "connectors, signal by signal"],
)
def test_sums(keys: dict, inputs: str, sums: str, values: tuple, expected: list[float]) -> None:
    total = program(**keys)
    assert [v.name for v in total.inputs] == inputs.split()
    assert [v.name for v in total.outputs] == sums.split()
    assert {v.unit for v in (*total.inputs, *total.outputs)} == {
        *keys.get("signals", {}).values(),
        *([keys["unit"]] if "unit" in keys else []),
    }
    assert all(v.tunable and v.name.startswith("factor.") for v in total.parameters)
    parameters = [v.start for v in total.parameters]
    assert load_python(total).outputs(0.0, [], [*map(float, values)], parameters, []) == expected


@pytest.mark.parametrize("algorithm", ["jacobi", "implicit"])
def test_a_tunable_parameter_follows_an_output(algorithm: str, tmp_path: Path) -> None:
    """With y the sum of 2 x, x = 3, whose factor a table raises from 2 to 7 at 0.5 s."""
    signals = {"f": {"values": [2, 2, 7, 7]}, "x": {"values": [3, 3, 3, 3]}}
    steps = table.Config(times=[0, 0.5, 0.5, 1], signals=signals)
    total = Component("c", Kind("sum", Config(inputs=["u"], unit="1")))
    parts = (total, Component("t", Kind("table", steps)))
    links = ("t.x -> c.u", "t.f -> c.factor.u")
    system = System("s", parts, links, Simulation(1.0, 0.25, algorithm))
    outcome = run(prepare(system, build_directory=tmp_path), results=tmp_path / "r.nc")
    results = outcome.results()
    expected = np.where(results.time < 0.5, 6.0, 21.0)
    at_jump = np.isclose(results.time, 0.5)  # one row on either side
    np.testing.assert_allclose(results["c.sum"].values[~at_jump], expected[~at_jump], rtol=1e-14)


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
        return Kind("linear_pto", linear_pto.KIND.config(**keys, stiffness=0))

    total = Config(inputs=["a", "b"], signals={"force_x": "N", "force_z": "N"})
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
    assert "the sum of the forces of a, b, counted as one" in run_summary(outcome)
