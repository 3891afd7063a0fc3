"""FMU files: what is read from a good one, and how bad ones are refused before unpacking."""

from __future__ import annotations

import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.errors import InputError
from m4e_fmi.fmu import read_description

Fmus = Callable[[str], Path]
Files = dict[str, bytes]
XML, HERE = "modelDescription.xml", fmpy.platform


def rewritten(fmu: Path, path: Path, change: Callable[[Files], Files]) -> Path:
    """A copy of an FMU at `path` with other files."""
    with zipfile.ZipFile(fmu) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in change(content).items():
            archive.writestr(name, data)
    return path


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


def text(old: str, new: str) -> Callable[[Files], Files]:
    def change(files: Files) -> Files:
        assert old.encode() in files[XML]
        return {**files, XML: files[XML].replace(old.encode(), new.encode())}

    return change


def names(old: str, new: str) -> Callable[[Files], Files]:
    return lambda files: {name.replace(old, new): data for name, data in files.items()}


def more(name: str, content: bytes = b"x") -> Callable[[Files], Files]:
    return lambda files: {**files, name: content}


REFUSED: tuple[tuple[Callable[[Files], Files], str], ...] = (
    (text("<CoSimulation", "<ModelExchange"), "model-exchange"),
    (names(XML, f"folder/{XML}"), "there is no modelDescription.xml"),
    (names(HERE, "amiga68"), f"no binary for this platform, {HERE}"),
    (names(f"{HERE}/mass.", f"{HERE}/heavy."), f"{HERE}/mass"),
    (more("../evil"), "leads out of its folder"),
    (more("/etc/evil"), "leads out of its folder"),
    (more("C:evil"), "leads out of its folder"),
    (more("binaries\\x"), "a path with backslashes"),
    (more("resources/z", bytes(30_000_000)), "would unpack to 30 MB"),
)


@pytest.mark.parametrize(("change", "message"), REFUSED)
def test_bad_content_is_refused(
    c_fmu: Fmus, tmp_path: Path, change: Callable[[Files], Files], message: str
) -> None:
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", change)
    with pytest.raises(InputError) as caught:
        read_description(path)
    (problem,) = caught.value.problems
    assert problem.file in (str(path), f"{path}/{XML}")
    assert message in problem.message
    assert problem.remedy
    if "platform" in message:
        assert "it has: amiga68" in problem.remedy
    if message.endswith("/mass"):
        assert f"it has: {HERE}/heavy." in problem.remedy


@pytest.mark.parametrize("same", [True, False])
def test_a_name_twice(c_fmu: Fmus, tmp_path: Path, same: bool) -> None:
    """With the same content as in archives of CMake's tar that is told a folder twice, or not."""
    path = rewritten(c_fmu("mass"), tmp_path / "x.fmu", dict)
    with warnings.catch_warnings(), zipfile.ZipFile(path, "a") as archive:
        warnings.simplefilter("ignore")  # zipfile warns of what is made here on purpose
        for _ in range(2):
            archive.writestr("extra/", "")
        archive.writestr(XML, archive.read(XML) if same else "<other/>")
    if same:
        assert list(read_description(path).variables) == list(
            read_description(c_fmu("mass")).variables
        )
        run(System("s", (Component("a", FmuFile(path)),), (), Simulation(1, 0.1)))
    else:
        with pytest.raises(InputError, match=r"xml' twice, with different contents"):
            read_description(path)
