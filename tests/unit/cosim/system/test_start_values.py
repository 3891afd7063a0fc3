"""Start values in the range that an FMU declares."""

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import load_system, run
from m4e_fmi.cosim.system.start_values import value_of
from m4e_fmi.fmu.importer.reading import Variable
from m4e_fmi.units import parse_unit


def variable(low: float, high: float) -> Variable:
    return Variable(
        name="period",
        value_reference=0,
        type="Real",
        offset=0.0,
        derivative_of=None,
        causality="parameter",
        variability="fixed",
        initial="exact",
        unit="s",
        dimension=parse_unit("s"),
        description="made for 9 s",
        minimum=low,
        maximum=high,
    )


@pytest.mark.parametrize(
    ("kind", "given", "taken"),
    [
        ("Real", 7.2, 7.2),
        ("Real", "8000 ms", pytest.approx(8.0, rel=1e-15)),
        ("Real", np.float32(8.5), 8.5),
        ("Real", np.int64(9), 9),
        ("Real", Fraction(17, 2), 8.5),
        ("Integer", np.int32(9), 9),
        ("Boolean", np.bool_(True), True),
    ],
)
def test_values_that_are_taken(kind: str, given: Any, taken: Any) -> None:
    """Of the own types of Python, also where another library gives them."""
    low, high = (-math.inf, math.inf) if kind == "Boolean" else (7.2, 11.25)
    found = value_of(replace(variable(low, high), type=kind), given)
    assert found == taken
    assert type(found) in (int, float, bool)


@pytest.mark.parametrize(
    ("low", "high", "kind", "given", "told"),
    [
        (7.2, 11.25, "Real", 16.0, r"the FMU's range is 7.2 to 11.25 s \(made for 9 s\)"),
        (7.2, 11.25, "Real", "7000 ms", r"the FMU's range is 7.2 to 11.25 s \(made for 9 s\)"),
        (0.0, math.inf, "Real", -1, r"the FMU's range is 0 s or more \(made for 9 s\)"),
        (-math.inf, 0.0, "Real", 1.0, r"the FMU's range is 0 s or less \(made for 9 s\)"),
        (-math.inf, math.inf, "Integer", np.float64(9), "it is of type"),
        (-math.inf, math.inf, "Integer", np.bool_(True), "it is of type"),
        (-math.inf, math.inf, "Integer", 2**40, "-2147483648 to 2147483647"),
        (-math.inf, math.inf, "Real", np.bool_(True), "it is of type"),
        (-math.inf, math.inf, "Real", np.float32("nan"), "finite"),
        (-math.inf, math.inf, "Real", Fraction(10**400), "finite"),
        (-math.inf, math.inf, "Boolean", np.int64(1), "it is of type"),
        (-math.inf, math.inf, "String", 5, "to be quoted: '\"5\"'"),
        (-math.inf, math.inf, "String", math.nan, "to be quoted: '\"nan\"'"),
        (-math.inf, math.inf, "String", True, "to be quoted: '\"True\"'"),
    ],
)
def test_values_that_are_refused(low: float, high: float, kind: str, given: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        value_of(replace(variable(low, high), type=kind), given)


MODEL = """
name: ship
dimensions: 3
gravity: 0
bodies: {ship: {mass: 1, inertia: [1, 1, 1]}}
joints: {free: {type: floating, child: ship, initial: {phi: 0.1}}}
"""
SYSTEM = """
name: sea
components:
  a: {model: ship.model.yaml, start: {body.ship.theta: 20 deg}}
simulation: {stop_time: 0.2, step_size: 0.1}
"""


def test_attitudes_start_at_angles(tmp_path: Path) -> None:
    """Also after the FMU was built: it is described by itself then."""
    (tmp_path / "ship.model.yaml").write_text(MODEL)
    (tmp_path / "sea.yaml").write_text(SYSTEM)
    for _ in range(2):
        system = load_system(tmp_path / "sea.yaml")
        result = run(system, results=tmp_path / "r.nc", build_directory=tmp_path).results()
        assert result["a.body.ship.theta"][0] == pytest.approx(0.3490658503988659, abs=1e-15)
        assert result["a.body.ship.phi"][0] == pytest.approx(0.1, abs=1e-15)
