"""A change of any file that a component is made from builds its FMU again, and changes results."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

from m4e_fmi import code_hash as code_module
from m4e_fmi.code_hash import package_hash
from m4e_fmi.cosim import load_system, run
from m4e_fmi.cosim.preparation import components
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu.export.build_record import read_record

CASES: dict[str, Any] = YAML(typ="safe").load(Path(__file__).with_name("builds.yaml"))
LINES = (Path(__file__).parents[3] / "data/moordyn/moorpy_case1.dat").read_text()
LINES = LINES.replace("900.00    40 ", "900.00    2  ").replace("50.0     TmaxIC", "1.0     TmaxIC")


class Project:
    """A system of one component in `folder`, made from the files of a case of `builds.yaml`."""

    def __init__(self, folder: Path, case: dict[str, Any]) -> None:
        self.folder, self.case = folder, case
        for name, text in case["files"].items():
            self.write(name, text.replace("MOORDYN", LINES))
        times = case.get("simulation", {"stop_time": 1, "step_size": 0.5})
        system = {"name": "s", "components": {"a": case["component"]}, "simulation": times}
        self.write("system.yaml", json.dumps(system))

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def change(self) -> None:
        """What the case changes, or brings."""
        path, new = self.folder / self.case["changed"], self.case["new"]
        if "old" in self.case:
            new = path.read_text().replace(self.case["old"], new)
        path.write_text(new)

    def run(self) -> tuple[bool, float]:
        """True if the FMU was built, and the last value of the output."""
        told: list[str] = []
        outcome = run(
            load_system(self.folder / "system.yaml"),
            results=self.folder / "r.nc",
            build_directory=self.folder / "build",
            tell=told.append,
        )
        value = outcome.results()[self.case["output"]].values[-1]
        return any("building" in line for line in told), float(value)


@pytest.fixture(scope="module")
def opened() -> Iterator[set[str]]:
    """Names of all files that are opened from here on."""
    found: set[str] = set()
    listening = [found]

    def listen(event: str, arguments: tuple) -> None:
        if event == "open" and listening and isinstance(arguments[0], (str, os.PathLike)):
            found.add(os.fspath(arguments[0]))

    sys.addaudithook(listen)  # there is no way to remove it
    yield found
    listening.clear()


@pytest.mark.parametrize("name", CASES)
def test_a_change_of_a_file_builds_again_and_changes_the_result(
    name: str, tmp_path: Path, opened: set[str]
) -> None:
    """Also where size and time stamp stay, and in a project that was moved, and not built again."""
    case = CASES[name]
    project = Project(tmp_path / "here", case)
    built, first = project.run()
    assert built
    assert project.run() == (False, first)
    record = read_record(project.folder / "build/s/a.fmu")
    assert record is not None
    told = {p: content for p, content in record.files.items() if Path(p).is_relative_to(tmp_path)}
    read = {path for path, content in told.items() if content is not None}
    own = {str(project.folder / name) for name in (*case["files"], case["changed"])}
    assert read <= opened & own <= set(told)  # a reader that forgets to tell is found
    (tmp_path / "far").mkdir()
    shutil.move(tmp_path / "here", tmp_path / "far/there")
    moved = Project(tmp_path / "far/there", case)
    assert moved.run() == (False, first)
    path = moved.folder / case["changed"]
    before = path.stat() if path.exists() else None
    moved.change()
    if before:
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    built, second = moved.run()
    assert built
    assert second != first
    if not before:
        path.unlink()
        assert moved.run() == (True, first)


@pytest.fixture
def table(tmp_path: Path) -> Project:
    return Project(tmp_path, CASES["file of a table"])


def test_a_link_to_another_file_is_a_change(table: Project) -> None:
    """Of a file, and of the folder it is in."""
    folder, link = table.folder, table.folder / "tables/level.csv"
    shutil.move(link, folder / "one.csv")
    table.write("two.csv", (folder / "one.csv").read_text().replace("10,2", "10,9"))
    link.symlink_to(folder / "one.csv")
    _, first = table.run()
    link.unlink()
    link.symlink_to(folder / "two.csv")
    built, second = table.run()
    assert (built, second) == (True, pytest.approx(1.8))
    shutil.move(folder / "tables", folder / "old")
    shutil.copytree(folder / "old", folder / "new", symlinks=False)
    shutil.copy(folder / "one.csv", folder / "new/level.csv")
    (folder / "tables").symlink_to(folder / "new")
    assert table.run() == (True, first)


FORCE = """\
import numpy
from gauge_tools import GAIN

class Force:
    inputs = {"x": "m"}
    outputs = {"force": "N"}

    def calculate(self, t, v):
        return {"force": GAIN * v.x + GAIN}
"""


def test_what_a_python_file_imports_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module that its module imports, by content, and an installed package, by version."""
    site = tmp_path / "site"
    site.mkdir()
    monkeypatch.syspath_prepend(str(site))
    (site / "gauge_tools.py").write_text("from gauge_basis import GAIN\n")
    component = {"kind": "python", "file": "force.py"}
    case = {"component": component, "files": {"force.py": FORCE}, "output": "a.force"}
    project = Project(tmp_path / "project", case)

    def result(gain: float) -> tuple[bool, float]:
        (site / "gauge_basis.py").write_text(f"GAIN = {gain}\n")
        for name in ("gauge_tools", "gauge_basis"):  # as in another process
            sys.modules.pop(name, None)
        package_hash.cache_clear()
        return project.run()

    assert result(2.0) == (True, 2.0)
    assert result(2.0) == (False, 2.0)
    assert result(3.0) == (True, 3.0)
    system = load_system(project.folder / "system.yaml")

    def missing() -> list[str]:
        _, places = components._places(system, project.folder / "build")
        return [name for name, place in places.items() if not place.record]

    assert not missing()
    usual = code_module.version
    monkeypatch.setattr(
        code_module, "version", lambda name: "99" if name == "numpy" else usual(name)
    )
    assert missing() == ["a"]
    for name in ("gauge_tools", "gauge_basis"):
        sys.modules.pop(name, None)


def test_a_record_belongs_to_the_fmu_beside_it(table: Project) -> None:
    """A build is known by its record and content; a damaged one of either is built again."""
    table.run()
    fmu = table.folder / "build/s/a.fmu"
    record = fmu.with_name("a.build.json")
    content, told = fmu.read_bytes(), record.read_bytes()
    damages: list[Callable[[], object]] = [
        lambda: fmu.write_bytes(content[:-1]),
        fmu.unlink,
        record.unlink,
        *(
            lambda wrong=wrong: record.write_bytes(wrong)
            for wrong in (told[:-3], b"[" * 100_000, b"\xff", b'{"fmu": 1}')
        ),
    ]
    for damage in damages:
        assert read_record(fmu) is not None
        damage()
        assert read_record(fmu) is None
        assert table.run()[0]
        assert fmu.read_bytes() == content


def test_a_disk_that_is_full_before_the_record_is_written(
    table: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next run builds again."""

    def full(path: Path, *_: object, **__: object) -> int:
        raise OSError(28, "No space left on device", str(path))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        with pytest.raises(RunError, match="free disk space"):
            table.run()
    assert [path.name for path in (table.folder / "build/s").iterdir()] == ["a.fmu"]
    assert table.run()[0]
    assert not table.run()[0]


def test_a_mesh_in_several_files_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a reader would find that looks for a second file beside the first."""
    import capytaine

    from m4e_adapters.hydrodynamics.config import Body
    from m4e_adapters.hydrodynamics.geometry.mesh import make_hull

    monkeypatch.setattr(
        capytaine, "load_mesh", lambda path: Path(path).with_name("points.h5").read_bytes()
    )
    for name in ("hull.xdmf", "points.h5"):
        (tmp_path / name).write_text("x")
    body = Body.model_validate({"shape": {"mesh": "hull.xdmf"}, "center_of_gravity": [0, -1]})
    with pytest.raises(InputError, match="all of a mesh must be in one file"):
        make_hull("hull", body, tmp_path)
