"""A change of any file that a component is made from builds its FMU again, and changes results."""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest

from m4e_fmi import code_hash as code_module
from m4e_fmi.code_hash import package_hash
from m4e_fmi.cosim import load_system, read_parameters, run
from m4e_fmi.cosim.preparation import components
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.fmu.export.build_record import read_record

PULLED = """\
name: pulled
bodies: {mass: {mass: 2.0, inertia: 1.0}}
joints: {slide: {type: prismatic, child: mass, direction: [1, 0]}}
tables: {pull: {file: pull.csv, unit: N}}
loads: {pull: {type: joint_effort, joint: slide, effort: pull}}
"""
LISTS: dict[str, Any] = {
    "joints": [[0, 1]],
    "types": ["R"],
    "parent_cg_to_joint": [[0, 0]],
    "joint_to_child_cg": [[0, -1]],
    "m0": [2],
    "J0": [1],
    "ic": [0.5, 0],
    "g": 9.81,
}
CHRONO = json.dumps({
    "chrono-version": "10.0",
    "model": {
        "name": "rod",
        "bodies": [
            {"name": "ground", "location": [0, 0, 0], "fixed": True},
            {"name": "rod", "location": [1, 0, 0], "mass": 2, "inertia": {"moments": [7, 3, 7]}},
        ],
        "joints": [
            {"name": "hinge", "type": "REVOLUTE", "body1": "ground", "body2": "rod",
             "location": [0, 0, 0], "axis": [0, 1, 0]},
        ],
    },
})  # fmt: skip
LINES = (Path(__file__).parents[3] / "data/moordyn/moorpy_case1.dat").read_text()
LINES = LINES.replace("900.00    40 ", "900.00    2  ").replace("50.0     TmaxIC", "1.0     TmaxIC")
TABLE = "time,level\n0,1\n10,2\n"


def gravity(value: float) -> str:
    return json.dumps({"chrono-version": "10.0", "simulation": {"gravity": [0, 0, -value]}})


def box(length: float) -> str:
    """Four walls and a floor, one panel each, in WAMIT's form."""
    x, y, z = length / 2, 2.0, -2.0
    panels = [
        [(-x, -y, z), (-x, y, z), (x, y, z), (x, -y, z)],
        [(-x, -y, 0), (-x, -y, z), (x, -y, z), (x, -y, 0)],
        [(x, y, 0), (x, y, z), (-x, y, z), (-x, y, 0)],
        [(x, -y, 0), (x, -y, z), (x, y, z), (x, y, 0)],
        [(-x, y, 0), (-x, y, z), (-x, -y, z), (-x, -y, 0)],
    ]
    rows = [" ".join(map(str, corner)) for panel in panels for corner in panel]
    return "\n".join(["box", "1.0 9.81", "0 0", str(len(panels)), *rows]) + "\n"


@dataclass(frozen=True)
class Case:
    """A component `a` made from `files`; `changed` is the one that then gets `content`."""

    component: dict[str, Any]
    files: dict[str, str]
    changed: str
    content: str
    output: str
    settings: dict[str, float] = field(default_factory=lambda: {"stop_time": 1, "step_size": 0.5})


SHORT = {"stop_time": 0.01, "step_size": 0.005}
ROD = {"model": "rod.model.yaml"}
CASES = {
    "table of a model": Case(
        {"model": "pulled.model.yaml"},
        {"pulled.model.yaml": PULLED, "pull.csv": "time,force\n0,1\n10,1\n"},
        "pull.csv",
        "time,force\n0,9\n10,9\n",
        "a.body.mass.x",
    ),
    "file of a table": Case(
        {"kind": "table", "file": "tables/level.csv", "signals": {"level": "m"}},
        {"tables/level.csv": TABLE},
        "tables/level.csv",
        TABLE.replace("10,2", "10,9"),
        "a.level",
    ),
    "lists in JSON": Case(
        {"model": "lists.model.json"},
        {"lists.model.json": json.dumps(LISTS)},
        "lists.model.json",
        json.dumps(LISTS | {"g": 1.62}),
        "a.body.body_1.x",
    ),
    "model of a Chrono simulation": Case(
        {"model": "run.yaml"},
        {
            "run.yaml": json.dumps({**json.loads(gravity(9.81)), "model": "rod.yaml"}),
            "rod.yaml": CHRONO,
        },
        "rod.yaml",
        CHRONO.replace("[7, 3, 7]", "[7, 5, 7]"),
        "a.body.rod.z",
    ),
    "simulation beside a Chrono model": Case(
        ROD,
        {"rod.model.yaml": CHRONO, "rod.simulation.yaml": gravity(9.81)},
        "rod.simulation.yaml",
        gravity(1.62),
        "a.body.rod.z",
    ),
    "simulation that comes beside a Chrono model": Case(
        ROD, {"rod.model.yaml": CHRONO}, "rod.simulation.yaml", gravity(1.62), "a.body.rod.z"
    ),
    "MoorDyn file": Case(
        {"kind": "mooring", "file": "lines.txt", "fairleads": ["bow"]},
        {"lines.txt": LINES},
        "lines.txt",
        LINES.replace("900.00    2", "880.00    2"),
        "a.bow.force_x",
        SHORT,
    ),
    "mesh": Case(
        {
            "kind": "hydrodynamics",
            "bodies": {"hull": {"shape": {"mesh": "hull.gdf"}, "center_of_gravity": [0, -1]}},
            "frequencies": {"count": 12, "maximum": 2.0},
            "radiation": {"order": 4},
        },
        {"hull.gdf": box(4.0)},
        "hull.gdf",
        box(4.5),
        "a.hull.force_z",
        SHORT,
    ),
}


class Project:
    """A system of one component in `folder`."""

    def __init__(self, folder: Path, case: Case) -> None:
        self.folder, self.case = folder, case
        for name, text in case.files.items():
            self.write(name, text)
        system = {"name": "s", "components": {"a": case.component}, "simulation": case.settings}
        self.write("system.yaml", json.dumps(system))

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def run(self) -> tuple[bool, float]:
        """True if the FMU was built, and the last value of the output."""
        told: list[str] = []
        outcome = run(
            load_system(self.folder / "system.yaml"),
            results=self.folder / "r.nc",
            build_directory=self.folder / "build",
            tell=told.append,
        )
        value = outcome.results()[self.case.output].values[-1]
        return any("building" in line for line in told), float(value)


@pytest.fixture(scope="module")
def opened() -> Iterator[set[str]]:
    """Names of all files that are opened from here on."""
    found: set[str] = set()
    listening = [found]

    def listen(event: str, arguments: tuple) -> None:
        if event == "open" and listening and isinstance(arguments[0], str | os.PathLike):
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
    own = {str(project.folder / name) for name in (*case.files, case.changed)}
    assert read <= opened & own <= set(told)  # a reader that forgets to tell is found
    (tmp_path / "far").mkdir()
    shutil.move(tmp_path / "here", tmp_path / "far/there")
    moved = Project(tmp_path / "far/there", case)
    assert moved.run() == (False, first)
    path = moved.folder / case.changed
    before = path.stat() if path.exists() else None
    moved.write(case.changed, case.content)
    if before:
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    built, second = moved.run()
    assert built
    assert second != first
    if case.changed not in case.files:
        path.unlink()
        assert moved.run() == (True, first)


@pytest.fixture
def table(tmp_path: Path) -> Project:
    return Project(tmp_path, CASES["file of a table"])


def test_a_link_to_another_file_is_a_change(table: Project) -> None:
    """Of a file, and of the folder it is in."""
    folder, link = table.folder, table.folder / "tables/level.csv"
    shutil.move(link, folder / "one.csv")
    table.write("two.csv", TABLE.replace("10,2", "10,9"))
    link.symlink_to(folder / "one.csv")
    _, first = table.run()
    link.unlink()
    link.symlink_to(folder / "two.csv")
    built, second = table.run()
    assert (built, second) == (True, pytest.approx(1.8))
    shutil.move(folder / "tables", folder / "old")
    table.write("new/level.csv", TABLE)
    (folder / "tables").symlink_to(folder / "new")
    assert table.run() == (True, first)


def test_a_copy_of_a_project_has_files_of_its_own(table: Project, tmp_path: Path) -> None:
    table.run()
    shutil.copytree(tmp_path, tmp_path / "copy", ignore=shutil.ignore_patterns("copy"))
    copy = Project(tmp_path / "copy", table.case)
    copy.write(table.case.changed, table.case.content)
    assert copy.run()[1] != table.run()[1]


def test_a_parameter_set_is_read_each_time(table: Project) -> None:
    case = CASES["table of a model"]
    text = PULLED.replace("mass: 2.0", "mass: m") + "parameters: {m: {value: 2, unit: kg}}\n"
    project = Project(table.folder, replace(case, files=case.files | {"pulled.model.yaml": text}))
    system = load_system(project.folder / "system.yaml")

    def result(mass: float) -> float:
        file = project.write("set.yaml", f"values: {{a.m: {mass}}}")
        changed = system.changed(start=read_parameters(file))
        outcome = run(changed, results=table.folder / "r.nc", build_directory=table.folder)
        return float(outcome.results()[case.output].values[-1])

    assert result(2.0) == pytest.approx(2 * result(4.0))


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
    case = Case({"kind": "python", "file": "force.py"}, {"force.py": FORCE}, "", "", "a.force")
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
    assert not components.missing_fmus(system, project.folder / "build")
    usual = code_module.version
    monkeypatch.setattr(
        code_module, "version", lambda name: "99" if name == "numpy" else usual(name)
    )
    assert components.missing_fmus(system, project.folder / "build") == ("a",)
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
