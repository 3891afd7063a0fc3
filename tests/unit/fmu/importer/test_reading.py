"""FMU files: what is read from a good one, and how bad ones are refused before unpacking."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, prepare, run
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import read_description

Fmus = Callable[[str], Path]
XML = "modelDescription.xml"


def rewritten(
    fmu: Path, path: Path, change: Callable[[dict[str, bytes]], dict[str, bytes]]
) -> Path:
    """A copy of an FMU at `path` with other content."""
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in change(content).items():
            archive.writestr(name, data)
    return path


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_description(path)
    (problem,) = caught.value.problems
    assert problem.file in (str(path), f"{path}/{XML}")
    assert problem.remedy
    return problem.message


def test_a_good_fmu_tells_variables_units_and_dependencies(c_fmu: Fmus) -> None:
    mass = read_description(c_fmu("mass"))
    force = mass.variables["body.m.force_x"]
    assert (force.causality, force.unit, force.value_reference) == ("input", "N", 3)
    assert force.dimension is not None
    assert force.dimension.si_text == "kg.m/s2"
    assert mass.dependencies["body.m.ax"] == {"body.m.force_x"}
    assert mass.dependencies["body.m.x"] == frozenset()
    assert mass.output_derivatives == {"body.m.x": "body.m.vx", "body.m.vx": "body.m.ax"}
    assert read_description(c_fmu("line")).input_derivatives == {"end.x": "end.vx"}
    assert not mass.undeclared


def test_where_nothing_is_declared_everything_may_matter(c_fmu: Fmus) -> None:
    blind = read_description(c_fmu("blind_spring"))
    assert blind.dependencies["end.force_x"] == {"end.x", "end.vx"}
    assert blind.initial_dependencies["end.force_x"] >= {"end.x", "end.vx", "stiffness"}
    assert blind.undeclared == {"end.force_x"}


def test_not_there(c_fmu: Fmus) -> None:
    fmu = c_fmu("mass")
    with pytest.raises(InputError, match=r"did you mean 'mass\.fmu'"):
        read_description(fmu.with_name("maas.fmu"))


def test_not_a_zip(tmp_path: Path) -> None:
    path = tmp_path / "x.fmu"
    path.write_text("<html>404</html>")
    assert "not a readable ZIP archive" in refusal(path)


def test_truncated(c_fmu: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "x.fmu"
    path.write_bytes(c_fmu("mass").read_bytes()[:-200])
    assert "not a readable ZIP archive" in refusal(path)


def test_no_model_description(c_fmu: Fmus, tmp_path: Path) -> None:
    path = rewritten(
        c_fmu("mass"), tmp_path / "x.fmu", lambda c: {f"folder/{n}": d for n, d in c.items()}
    )
    assert "there is no modelDescription.xml" in refusal(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"<fmiModelDescription", b"<!DOCTYPE x><fmiModelDescription", "has a DOCTYPE"),
        (b'fmiVersion="2.0"', b'fmiVersion="4.0"', "Unsupported FMI version: 4.0"),
        (b"<CoSimulation", b"<ModelExchange", "model-exchange"),
        (b"</ModelStructure>", b"", "cannot be understood"),
        (b'derivative="5"', b'derivative="99"', "derivative has 99, the index of no variable"),
        (b"<CoSimulation", b'<CoSimulation maxOutputDerivativeOrder="x"', "is no number"),
        (
            b'valueReference="2"',
            b'valueReference="-1"',
            'valueReference="-1" is no value reference',
        ),
        (b'valueReference="2"', b'valueReference="4294967296"', "is no value reference"),
        (b'modelName="mass"', b'modelName="x&#10;error: y"', "has an end of line in it"),
        (b'modelName="mass"', b'modelName="x&#x2028;y"', "has an end of line in it"),
    ],
)
def test_bad_model_description(
    c_fmu: Fmus, tmp_path: Path, old: bytes, new: bytes, message: str
) -> None:
    def change(content: dict[str, bytes]) -> dict[str, bytes]:
        assert old in content[XML]
        return {**content, XML: content[XML].replace(old, new)}

    assert message in refusal(rewritten(c_fmu("mass"), tmp_path / "x.fmu", change))


def test_no_binary_for_this_platform(c_fmu: Fmus, tmp_path: Path) -> None:
    def change(content: dict[str, bytes]) -> dict[str, bytes]:
        return {n.replace(fmpy.platform, "amiga68"): d for n, d in content.items()}

    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", change)
    assert f"no binary for this platform, {fmpy.platform}" in refusal(path)
    with pytest.raises(InputError, match="it has: amiga68"):
        read_description(path)


def test_a_binary_of_another_name(c_fmu: Fmus, tmp_path: Path) -> None:
    def change(content: dict[str, bytes]) -> dict[str, bytes]:
        return {n.replace(f"{fmpy.platform}/mass.", f"{fmpy.platform}/heavy."): d
                for n, d in content.items()}  # fmt: skip

    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", change)
    with pytest.raises(InputError, match=f"{fmpy.platform}/mass") as caught:
        read_description(path)
    assert f"it has: {fmpy.platform}/heavy." in caught.value.problems[0].remedy
    assert "of the name that its modelIdentifier says" in caught.value.problems[0].remedy


@pytest.mark.parametrize("name", ["../evil", "/etc/evil", "C:evil"])
def test_path_that_leads_out(c_fmu: Fmus, tmp_path: Path, name: str) -> None:
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", lambda c: {**c, name: b"x"})
    assert "leads out of its folder" in refusal(path)


def test_path_with_backslashes(c_fmu: Fmus, tmp_path: Path) -> None:
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", lambda c: {**c, "binaries\\x": b""})
    assert "a path with backslashes" in refusal(path)


def test_name_twice(c_fmu: Fmus, tmp_path: Path) -> None:
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", dict)
    with warnings.catch_warnings(), zipfile.ZipFile(path, "a") as archive:
        warnings.simplefilter("ignore")  # zipfile warns of what is made here on purpose
        archive.writestr(XML, "<other/>")
    assert "'modelDescription.xml' twice, with different contents" in refusal(path)


def test_the_same_content_twice(c_fmu: Fmus, tmp_path: Path) -> None:
    """As in archives of CMake's tar that is told a folder twice."""
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", dict)
    with warnings.catch_warnings(), zipfile.ZipFile(path, "a") as archive:
        warnings.simplefilter("ignore")
        for _ in range(2):
            archive.writestr("extra/", "")
            archive.writestr("extra/notes.txt", "some")
        archive.writestr(XML, archive.read(XML))
    assert (
        read_description(path).variables.keys() == read_description(c_fmu("mass")).variables.keys()
    )
    run(System("s", (Component("a", FmuFile(path)),), (), Simulation(1, 0.1)))


def test_zip_bomb(c_fmu: Fmus, tmp_path: Path) -> None:
    path = rewritten(
        c_fmu("mass"), tmp_path / "x.fmu", lambda c: {**c, "resources/z": bytes(30_000_000)}
    )
    assert "would unpack to 30 MB" in refusal(path)


def test_all_bad_files_of_a_system_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "a.fmu").write_text("no")
    components = tuple(Component(n, FmuFile(tmp_path / f"{n}.fmu")) for n in ("a", "b"))
    with pytest.raises(InputError) as caught:
        prepare(System("s", components, (), Simulation(1, 0.1)))
    assert len(caught.value.problems) == 2
