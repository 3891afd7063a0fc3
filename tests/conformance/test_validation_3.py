"""The checks of FMI 3.0 FMUs: nothing in our own, and each fault planted into one is found.

The library stays as it is: what its description says of it is made wrong, or the file with the
derivatives that it computes.
"""

from __future__ import annotations

import re
import struct
import zipfile
import zlib
from pathlib import Path

import pytest
from support.chains import hanging_chain
from support.defects import XML, planted
from support.plane import plane

from m4e_fmi.fmu import build_fmu, validate_fmu
from m4e_fmi.fmu.validation import GROUPS
from m4e_fmi.multibody import model_program

TANGENT = "resources/tangent.m4e"
CHECKSUM = 12
"""Where the checksum of what follows it stands in a program's binary form."""
FAULTS: dict[str, tuple[str, str, str, set[str]]] = {
    "a dependency is left out": (
        "dependencies",
        '<Output valueReference="15" dependencies="9 10" dependenciesKind="dependent dependent" />',
        '<Output valueReference="15" dependencies="9" dependenciesKind="dependent" />',
        {"dependencies.missing"},
    ),
    "states in another order": (
        "start",
        'unit="rad/s" displayUnit="rpm" derivative="9" />\n    <Float64 name="der(joint.j0.u)"',
        'unit="rad/s" displayUnit="rpm" derivative="11" />\n    <Float64 name="der(joint.j0.u)"',
        {"start.order"},
    ),
    "a rate in another unit": (
        "description",
        'declaredType="SI.Velocity" unit="m/s" derivative="13"',
        'declaredType="SI.Length" unit="m" derivative="13"',
        {"units.derivative"},
    ),
    "another start value of a state": (
        "start",
        'start="0.0" derivative="9"',
        'start="0.5" derivative="9"',
        {"start.values"},
    ),
    "another token": (
        "start",
        'instantiationToken="{',
        'instantiationToken="{1',
        {"start.refused"},
    ),
}
"""Fault → group that finds it, text in the description, what it becomes, errors and warnings."""


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("chain") / "chain.fmu"
    return build_fmu(model_program(hanging_chain(2)), path, native=True, fmi="3")


def test_the_double_pendulum_has_no_finding(chain: Path) -> None:
    report = validate_fmu(chain)
    assert report.of_severity("error", "warning") == ()
    assert [group.name for group in report.groups] == list(GROUPS)
    assert all(group.passed for group in report.groups)


def test_a_ball_on_a_plane_has_no_finding(tmp_path: Path) -> None:
    report = validate_fmu(build_fmu(plane(), tmp_path / "plane.fmu", native=True, fmi="3"))
    assert report.of_severity("error", "warning") == ()
    assert all(group.passed for group in report.groups)


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_found(name: str, chain: Path, tmp_path: Path) -> None:
    group, old, new, expected = FAULTS[name]
    path = planted(chain, tmp_path / "faulty.fmu", old.encode(), new.encode())
    report = validate_fmu(path, only=(group,))
    assert {finding.id for finding in report.of_severity("error", "warning")} == expected


def test_wrong_directional_derivatives_are_found(chain: Path, tmp_path: Path) -> None:
    """The derivatives are those of a pendulum on another planet."""
    with zipfile.ZipFile(chain) as archive:
        old = archive.read(TANGENT)
    new = bytearray(old.replace(struct.pack("<d", -9.81), struct.pack("<d", -3.73)))
    assert new != old
    struct.pack_into("<I", new, CHECKSUM, zlib.crc32(new[CHECKSUM + 4 :]))
    path = planted(chain, tmp_path / "faulty.fmu", old, bytes(new), TANGENT)
    report = validate_fmu(path, only=("directional",))
    found = report.of_severity("error", "warning")
    assert {finding.id for finding in found} == {"directional.mismatch"}
    assert all(finding.basis.startswith("FMI 3.0") for finding in found)
    assert not any("fmi2" in finding.message + finding.basis for finding in found)


ENERGY = r'<Float64 name="energy.total"[^>]*/>'


def test_an_alias_is_not_missed_in_model_structure(chain: Path, tmp_path: Path) -> None:
    """It lists the variable, a calculated output, and not its alias."""
    with zipfile.ZipFile(chain) as archive:
        (old,) = re.findall(ENERGY, archive.read(XML).decode())
    new = f'{old[:-2]}><Alias name="energy_of_all" description="Another name"/></Float64>'
    path = planted(chain, tmp_path / "faulty.fmu", old.encode(), new.encode())
    report = validate_fmu(path, only=("description", "start", "dependencies"))
    assert report.complete
    assert report.of_severity("error", "warning") == ()
