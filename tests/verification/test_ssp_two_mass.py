"""SSP packages of the two-mass oscillator, written by hand as other tools write them.

Unit masses and springs, undamped, x1(0) = 1 m. Other masters read the first kind rightly, some the
second, one the third (the reference of support/two_masses.py).
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.packages import (
    component,
    connection,
    description,
    package,
    parameter_mapping,
    parameter_set,
)
from support.small_systems import Fmus, watched
from support.two_masses import MOTION, TIME

from m4e_fmi.cosim import load_system

BODY = ("input body.m.force_x Real N", "output body.m.x Real m", "output body.m.vx Real m/s")
MM_BODY = ("input body.m.force_x Real", "output body.m.x Real", "output body.m.vx Real")
PARTNER = ("input end.x Real m", "input end.vx Real m/s", "output end.force_x Real N")
CONNECTIONS = (
    "<ssd:Connections>"
    + connection("a/body.m.x", "b/end.x")
    + connection("a/body.m.vx", "b/end.vx")
    + connection("b/end.force_x", "a/body.m.force_x")
    + "</ssd:Connections>"
)
EXPERIMENT = '<ssd:DefaultExperiment startTime="0" stopTime="10"/>'


def binding(inside: str = "", attributes: str = "") -> str:
    return (
        f"<ssd:ParameterBindings><ssd:ParameterBinding {attributes}>{inside}"
        "</ssd:ParameterBinding></ssd:ParameterBindings>"
    )


def two_mass(bindings: str, body: tuple[str, ...] = BODY) -> str:
    elements = component("a", "a.fmu", *body) + component("b", "b.fmu", *PARTNER)
    return description(
        f"{bindings}<ssd:Elements>{elements}</ssd:Elements>{CONNECTIONS}", EXPERIMENT
    )


def values(path: Path, length: float = 1.0) -> list[float]:
    """x1, v1, x2, v2 at the end of a run at steps of 0.1 s; `length` is the body's unit [m]."""
    system = load_system(path)
    assert system.simulation.stop_time == TIME
    names = ("a.body.m.x", "a.body.m.vx", "b.x", "b.vx")
    build = path.parent / "build"
    settings = {"step_size": 0.1, "algorithm": "corrector"}
    x, v, *other = watched(system.changed(**settings), *names, build_directory=build)[-1]
    return [length * x, length * v, *other]


@pytest.mark.verifies(
    "SSP package of the two-mass oscillator, parameters in an SSV file",
    analytic="exact solution",
    tolerance="3e-4 m",
)
def test_parameters_in_a_file(c_fmu: Fmus, tmp_path: Path) -> None:
    given = {"a.body.m.x": 'Real value="1"', "a.stiffness": 'Real value="1"'}
    files = {
        "resources/a.fmu": c_fmu("mass+state"),
        "resources/b.fmu": c_fmu("partner+state"),
        "resources/set.ssv": parameter_set(given),
    }
    ssd = two_mass(binding(attributes='source="resources/set.ssv"'))
    found = values(package(tmp_path / "pair.ssp", ssd, files))
    assert found == pytest.approx(MOTION, abs=3e-4)


@pytest.mark.verifies(
    "SSP package of the two-mass oscillator, SSV mapped by SSM",
    analytic="exact solution",
    tolerance="3e-4 m",
)
def test_parameters_by_a_mapping(c_fmu: Fmus, tmp_path: Path) -> None:
    # lengths in mm with a unit of the set's own; a spring given by half its stiffness
    units = """<ssd:Units><ssc:Unit name="Milli-Meter"><ssc:BaseUnit m="1" factor="0.001"/>
               </ssc:Unit></ssd:Units>"""
    given = {
        "pull": 'Real value="1000" unit="Milli-Meter"',
        "half": 'Real value="0.5"',
        "less": 'Real value="3"',
    }
    double = '<ssc:LinearTransformation factor="2"/>'
    minus = '<ssc:LinearTransformation factor="1" offset="-2"/>'
    mapping = {
        "a.body.m.x": "pull",
        "a.stiffness": ("half", double),
        "b.stiffness": ("half", double),
        "b.coupling": ("less", minus),
    }
    files = {
        "resources/a.fmu": c_fmu("mass+state"),
        "resources/b.fmu": c_fmu("partner+state"),
        "resources/set.ssv": parameter_set(given, units),
        "resources/set.ssm": parameter_mapping(mapping),
    }
    inside = '<ssd:ParameterMapping source="resources/set.ssm"/>'
    ssd = two_mass(binding(inside, 'source="resources/set.ssv"'))
    found = values(package(tmp_path / "pair.ssp", ssd, files))
    assert found == pytest.approx(MOTION, abs=3e-4)


@pytest.mark.verifies(
    "SSP package of the two-mass oscillator, a connection from mm to m",
    analytic="exact solution",
    tolerance="3e-4 m",
)
def test_a_connection_from_mm_to_m(c_fmu: Fmus, tmp_path: Path) -> None:
    # 0.001 N.s2/mm is 1 kg, 0.001 N/mm is 1 N/m
    given = {
        "body.m.x": 'Real value="1000"',
        "mass": 'Real value="0.001"',
        "stiffness": 'Real value="0.001"',
    }
    inline = f"<ssd:ParameterValues>{parameter_set(given)}</ssd:ParameterValues>"
    files = {
        "resources/a.fmu": c_fmu("mm_mass+state"),
        "resources/b.fmu": c_fmu("partner+state"),
    }
    ssd = two_mass(binding(inline, 'prefix="a."'), MM_BODY)
    found = values(package(tmp_path / "pair.ssp", ssd, files), length=1e-3)
    assert found == pytest.approx(MOTION, abs=3e-4)
