"""The checks of FMI 3.0 FMUs: nothing in our own, and each fault planted into one is found.

The library stays as it is; what its description says of it is made wrong.
"""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from support.chains import hanging_chain
from support.plane import plane

from m4e_fmi.fmu import build_fmu, validate_fmu
from m4e_fmi.fmu.validation import GROUPS
from m4e_fmi.multibody import model_program

XML = "modelDescription.xml"
FAULTS: dict[str, tuple[str, str, str, set[str]]] = {
    "a dependency is left out": (
        "dependencies",
        '<Output valueReference="17" dependencies="7 9" dependenciesKind="dependent dependent" />',
        '<Output valueReference="17" dependencies="7" dependenciesKind="dependent" />',
        {"dependencies.missing"},
    ),
    "a factor that is not constant": (
        "dependencies",
        '<Output valueReference="11" dependencies="7" dependenciesKind="dependent" />',
        '<Output valueReference="11" dependencies="7" dependenciesKind="constant" />',
        {"dependencies.kind"},
    ),
    "the derivative of another variable": (
        "derivatives",
        'unit="m/s" derivative="11"',
        'unit="m/s" derivative="17"',
        {"derivatives.mismatch"},
    ),
    "states in another order": (
        "derivatives",
        'unit="rad/s" displayUnit="rpm" derivative="7" />\n    <Float64 name="der(joint.j0.u)"',
        'unit="rad/s" displayUnit="rpm" derivative="9" />\n    <Float64 name="der(joint.j0.u)"',
        {"derivatives.order", "derivatives.mismatch"},
    ),
    "a rate in another unit": (
        "description",
        'declaredType="SI.Velocity" unit="m/s" derivative="11"',
        'declaredType="SI.Length" unit="m" derivative="11"',
        {"units.derivative"},
    ),
    "a start value below min": (
        "description",
        'unit="rad/s" displayUnit="rpm" nominal="10.0" start="0.0" derivative="7"',
        'unit="rad/s" displayUnit="rpm" nominal="10.0" min="1.0" start="0.0" derivative="7"',
        {"variables.start"},
    ),
    "another token": (
        "start",
        'instantiationToken="{',
        'instantiationToken="{1',
        {"start.refused"},
    ),
    "inputs that are called fixed parameters": (
        "parameters",
        'causality="input" variability="continuous" intermediateUpdate="true" '
        'declaredType="SI.Torque"',
        'causality="parameter" variability="fixed" intermediateUpdate="true" '
        'declaredType="SI.Torque"',
        {"parameters.settable"},
    ),
}
"""Fault → group that finds it, text in the description, what it becomes, errors and warnings."""


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("chain") / "chain.fmu"
    return build_fmu(model_program(hanging_chain(2)), path, native=True, fmi="3")


def planted(path: Path, changed: Path, old: str, new: str) -> Path:
    """The FMU at `path` with another description, as `changed`."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(changed, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == XML:
                assert old.encode() in content
                content = content.replace(old.encode(), new.encode())
            target.writestr(name, content)
    return changed


def test_the_double_pendulum_has_no_finding(chain: Path) -> None:
    report = validate_fmu(chain)
    assert report.of_severity("error", "warning") == ()
    assert [group.name for group in report.groups] == list(GROUPS)
    assert all(group.passed for group in report.groups)


def test_arrays_and_a_matrix_have_no_finding(tmp_path: Path) -> None:
    report = validate_fmu(build_fmu(plane(), tmp_path / "plane.fmu", native=True, fmi="3"))
    assert report.of_severity("error", "warning") == ()
    assert all(group.passed for group in report.groups)


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_found(name: str, chain: Path, tmp_path: Path) -> None:
    group, old, new, expected = FAULTS[name]
    report = validate_fmu(planted(chain, tmp_path / "faulty.fmu", old, new), only=(group,))
    assert {finding.id for finding in report.of_severity("error", "warning")} == expected
