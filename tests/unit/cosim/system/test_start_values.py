"""Start values in the range that an FMU declares."""

import math
import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from m4e_fmi.cosim import System, load_system, run
from m4e_fmi.cosim.input_checks.inputs import checked_inputs
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


def test_values_within_the_range_are_taken() -> None:
    for given in (7.2, 9, 11.25, "8000 ms"):
        assert value_of(variable(7.2, 11.25), given) == pytest.approx(
            8.0 if isinstance(given, str) else given, rel=1e-15
        )


@pytest.mark.parametrize(
    ("low", "high", "given", "told"),
    [
        (7.2, 11.25, 16.0, "the FMU's range is 7.2 to 11.25 s (made for 9 s)"),
        (7.2, 11.25, "7000 ms", "the FMU's range is 7.2 to 11.25 s (made for 9 s)"),
        (0.0, math.inf, -1, "the FMU's range is 0 s or more (made for 9 s)"),
        (-math.inf, 0.0, 1.0, "the FMU's range is 0 s or less (made for 9 s)"),
    ],
)
def test_values_outside_are_an_error_with_both_numbers(
    low: float, high: float, given: float | str, told: str
) -> None:
    with pytest.raises(ValueError, match="the FMU's range is") as caught:
        value_of(variable(low, high), given)
    assert str(caught.value) == told


@pytest.mark.parametrize(
    ("kind", "given", "taken"),
    [
        ("Real", np.float32(0.5), 0.5),
        ("Real", np.int64(9), 9),
        ("Real", Fraction(1, 2), 0.5),
        ("Integer", np.int32(9), 9),
        ("Boolean", np.bool_(True), True),
    ],
)
def test_numbers_of_other_libraries_are_taken(kind: str, given: Any, taken: float) -> None:
    found = value_of(replace(variable(-math.inf, math.inf), type=kind), given)
    assert found == taken
    assert type(found) is type(taken)


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("Integer", np.float64(9)),
        ("Integer", np.bool_(True)),
        ("Real", np.bool_(True)),
        ("Real", np.float32("nan")),
        ("Real", Fraction(10**400)),
        ("Boolean", np.int64(1)),
    ],
)
def test_numbers_of_another_type_are_not_taken(kind: str, given: Any) -> None:
    with pytest.raises(ValueError, match=r"it is of type|finite"):
        value_of(replace(variable(-math.inf, math.inf), type=kind), given)


MODEL = """
name: ship
dimensions: 3
gravity: 0
parameters:
  tilt: {value: 1, unit: "1"}
bodies: {ship: {mass: 1, inertia: [1, 1, 1]}, arm: {mass: 1, inertia: [1, 1, 1]}}
joints:
  free: {type: floating, child: ship, initial: {phi: 0.1}}
  pin: {type: revolute, child: arm, parent: ship, axis: [0, tilt, 0]}
"""
SYSTEM = """
name: sea
components:
  a: {model: ship.model.yaml, start: {START}}
simulation: {stop_time: 0.2, step_size: 0.1}
"""


def system_with(folder: Path, start: str) -> System:
    (folder / "ship.model.yaml").write_text(MODEL)
    (folder / "sea.yaml").write_text(SYSTEM.replace("START", start))
    return load_system(folder / "sea.yaml")


def test_attitudes_start_at_angles(tmp_path: Path) -> None:
    """Also after the FMU was built: it is described by itself then."""
    system = system_with(tmp_path, "body.ship.theta: 20 deg")
    for _ in range(2):
        result = run(system, results=tmp_path / "r.nc", build_directory=tmp_path).results()
        assert result["a.body.ship.theta"][0] == pytest.approx(0.3490658503988659, abs=1e-15)
        assert result["a.body.ship.phi"][0] == pytest.approx(0.1, abs=1e-15)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ("tilt: 0", r"ship\.model\.yaml:10:\d+: the axis has no length \(with tilt = 0\)"),
        ("body.ship.e0: 0, body.ship.e1: 0", r"sea\.yaml:4:\d+: a\.body\.ship\.e0 to e3 are all 0"),
        ("body.ship.psi: 1, body.ship.e1: 0", r"sea\.yaml:4:\d+: an attitude of a is given twice"),
        ("body.ship.psi: 1 m", r"sea\.yaml:4:\d+: start value .* it is in rad"),
        ("body.arm.psi: 1", r"a\.body\.arm\.psi \(output\) takes no start value"),
    ],
)
def test_wrong_attitudes_and_axes(tmp_path: Path, start: str, message: str) -> None:
    problems, _ = checked_inputs(system_with(tmp_path, start))
    assert len(problems) == 1
    assert re.search(message, f"{problems[0]} {problems[0].remedy}".replace("\n", " "))


@pytest.mark.parametrize("given", [5, math.nan, True])
def test_a_text_that_looks_like_a_number_is_to_be_quoted(given: Any) -> None:
    text = replace(variable(-math.inf, math.inf), type="String")
    with pytest.raises(ValueError, match=f"""of type String, to be quoted: '"{given}"'"""):
        value_of(text, given)
