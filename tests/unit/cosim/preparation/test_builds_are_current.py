"""A change of any file that a component is made from builds its FMU again, and changes results."""

from __future__ import annotations

import errno
import json
import os
import shutil
import sys
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from m4e_fmi import code_hash as code_module
from m4e_fmi.code_hash import code_hash, package_hash
from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Kind,
    Simulation,
    System,
    load_system,
    prepare,
    read_parameters,
    run,
    start,
)
from m4e_fmi.cosim.preparation import components
from m4e_fmi.cosim.system import component as component_module
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.files_read import files_read
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
CHRONO = {
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
}  # fmt: skip
LINES = (Path(__file__).parents[3] / "data/moordyn/moorpy_case1.dat").read_text()
LINES = LINES.replace("900.00    40 ", "900.00    2  ").replace("50.0     TmaxIC", "1.0     TmaxIC")


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


TABLE = "time,level\n0,1\n10,2\n"
CASES = {
    "table of a model": Case(
        {"model": "pulled.model.yaml"},
        {"pulled.model.yaml": PULLED, "pull.csv": "time,force\n0,1\n10,1\n"},
        "pull.csv",
        "time,force\n0,9\n10,9\n",
        "a.body.mass.x",
    ),
    "model": Case(
        {"model": "pulled.model.yaml"},
        {"pulled.model.yaml": PULLED, "pull.csv": "time,force\n0,1\n10,1\n"},
        "pulled.model.yaml",
        PULLED.replace("2.0", "4.0"),
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
            "rod.yaml": json.dumps(CHRONO),
        },
        "rod.yaml",
        json.dumps(CHRONO).replace("[7, 3, 7]", "[7, 5, 7]"),
        "a.body.rod.z",
    ),
    "simulation beside a Chrono model": Case(
        {"model": "rod.model.yaml"},
        {"rod.model.yaml": json.dumps(CHRONO), "rod.simulation.yaml": gravity(9.81)},
        "rod.simulation.yaml",
        gravity(1.62),
        "a.body.rod.z",
    ),
    "simulation that comes beside a Chrono model": Case(
        {"model": "rod.model.yaml"},
        {"rod.model.yaml": json.dumps(CHRONO)},
        "rod.simulation.yaml",
        gravity(1.62),
        "a.body.rod.z",
    ),
    "MoorDyn file": Case(
        {"kind": "mooring", "file": "lines.txt", "fairleads": ["bow"]},
        {"lines.txt": LINES},
        "lines.txt",
        LINES.replace("900.00    2", "880.00    2"),
        "a.bow.force_x",
        {"stop_time": 0.01, "step_size": 0.005},
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
        {"stop_time": 0.01, "step_size": 0.005},
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
        system = load_system(self.folder / "system.yaml")
        outcome = run(
            system,
            results=self.folder / "r.nc",
            build_directory=self.folder / "build",
            tell=told.append,
        )
        value = outcome.results()[self.case.output].values[-1]
        return any("building" in line for line in told), float(value)


@pytest.mark.parametrize("name", CASES)
def test_a_change_of_a_file_builds_again_and_changes_the_result(name: str, tmp_path: Path) -> None:
    """Also where size and time stamp stay; and what did not change is not built again."""
    case = CASES[name]
    project = Project(tmp_path, case)
    built, first = project.run()
    assert built
    assert project.run() == (False, first)
    path = tmp_path / case.changed
    before = path.stat() if path.exists() else None
    project.write(case.changed, case.content)
    if before:
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    built, second = project.run()
    assert built
    assert second != first
    if case.changed not in case.files:
        path.unlink()
        assert project.run() == (True, first)


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


@pytest.mark.parametrize("name", CASES)
def test_a_project_that_is_moved_is_not_built_again(name: str, tmp_path: Path) -> None:
    """Unless a file changes there; the FMUs that checkpoints name stay what they are."""
    case = CASES[name]
    Project(tmp_path / "here", case).run()
    (tmp_path / "far").mkdir()
    shutil.move(tmp_path / "here", tmp_path / "far/there")
    moved = Project(tmp_path / "far/there", case)
    assert moved.run()[0] is False
    moved.write(case.changed, case.content)
    assert moved.run()[0] is True


def test_every_file_that_a_build_opens_is_in_its_record(tmp_path: Path) -> None:
    """So that a reader that forgets to tell is found."""
    opened: list[set[str]] = []

    def listen(event: str, arguments: tuple) -> None:
        if event == "open" and opened and isinstance(arguments[0], str | os.PathLike):
            opened[-1].add(os.fspath(arguments[0]))

    sys.addaudithook(listen)  # there is no way to remove it
    for name, case in CASES.items():
        folder = tmp_path / name
        Project(folder, case)
        system = load_system(folder / "system.yaml")
        opened.append(set())
        (fmu,) = components.fmu_files(system, tmp_path / "build" / name).values()
        record = read_record(fmu)
        assert record is not None
        seen = {path for path in opened[-1] if Path(path).is_relative_to(folder)}
        told = {p: content for p, content in record.files.items() if Path(p).is_relative_to(folder)}
        read = {path for path, content in told.items() if content is not None}
        assert read
        assert read <= seen <= set(told)
    opened.clear()


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


@pytest.fixture
def brought(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., list[str]]]:
    """`brought(kind)` builds a component of a kind from a package of somebody else."""
    site = tmp_path / "site"
    for name, text in {
        "gauge_kind/__init__.py": "",
        "gauge_kind/one.py": KIND_CODE.format(factor=1),
        "gauge_kind/two.py": KIND_CODE.format(factor=2),
        "gauge_kind/zero.json": "0.0",
        "gauge_tools.py": "import gauge_basis\n",
        "gauge_basis.py": "",
    }.items():
        (site / name).parent.mkdir(parents=True, exist_ok=True)
        (site / name).write_text(text)
    monkeypatch.syspath_prepend(str(site))
    found = {name: SimpleNamespace(value=f"gauge_kind.{name}") for name in ("one", "two")}
    for place in (component_module, components):
        monkeypatch.setattr(place, "kinds", lambda: found)

    def build(kind: str, **config: object) -> list[str]:
        code_hash.cache_clear()
        package_hash.cache_clear()
        made = component_module.kind_module(kind).Config(**config)
        parts = (Component("a", Kind(kind, made)),)
        told: list[str] = []
        system = System("s", parts, (), Simulation(1.0, 0.5), folder=tmp_path)
        components.fmu_files(system, tmp_path / "build", tell=told.append)
        return told

    yield build
    for name in [n for n in sys.modules if n.startswith("gauge_")]:
        del sys.modules[name]


KIND_CODE = """\
from typing import Any
from m4e_fmi.files.document import Section
from m4e_fmi.program import Recorder, Variable
import gauge_tools

class Config(Section):
    limit: float = 1.0
    anything: Any = None

def make(config, *, name, folder, progress):
    progress("warning: not calibrated")
    progress("recording")
    r = Recorder(name, "a constant")
    r.output(Variable("y", "1", "the constant"), r.time * 0.0 + {factor})
    return r.program()
"""


def test_all_code_of_a_kind_counts(brought: Callable[..., list[str]], tmp_path: Path) -> None:
    """Its package with its data, what it imports from elsewhere, and which kind it is."""
    again = ["a: warning: not calibrated"]
    assert any("building" in line for line in brought("one"))
    assert brought("one") == again
    assert any("building" in line for line in brought("two"))
    assert brought("two") == again
    for name in ("gauge_kind/__init__.py", "gauge_kind/zero.json", "gauge_tools.py",
                 "gauge_basis.py"):  # fmt: skip
        with (tmp_path / "site" / name).open("a") as file:
            file.write("\n")
        assert any("building" in line for line in brought("two")), name
    assert brought("two") == again


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


@pytest.mark.parametrize(
    ("one", "two"),
    [
        ({"limit": float("inf")}, {"limit": float("-inf")}),
        ({"limit": 0.1}, {"limit": 0.1 + 2**-55}),
        ({"anything": np.arange(5000.0)}, {"anything": np.arange(5000.0) + (np.arange(5000) == 9)}),
    ],
)
def test_every_bit_of_a_configuration_counts(
    brought: Callable[..., list[str]], one: dict[str, Any], two: dict[str, Any]
) -> None:
    brought("one", **one)
    assert len(brought("one", **one)) == 1
    assert any("building" in line for line in brought("one", **two))


def test_code_that_changed_after_the_process_began_is_not_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may not be what runs here: another process does not take what is built from it."""
    module = tmp_path / "late_kind.py"
    module.write_text("")
    monkeypatch.syspath_prepend(str(tmp_path))
    os.utime(module, (1e9, 1e9))

    def hash_in_another_process() -> str:
        monkeypatch.setattr(code_module, "_PROCESS", os.urandom(16))
        package_hash.cache_clear()
        return package_hash("late_kind")

    assert hash_in_another_process() == hash_in_another_process()
    os.utime(module)
    assert hash_in_another_process() != hash_in_another_process()


def test_versions_of_libraries_count(monkeypatch: pytest.MonkeyPatch) -> None:
    def of(name: str, found: str) -> str:
        code_hash.cache_clear()
        with monkeypatch.context() as patch:
            patch.setattr(code_module, "_version", lambda n: found if n == name else "1.0")
            return code_hash()

    for name in ("capytaine", "moordyn", "numpy", "pythonfmu", "scipy", "sympy"):
        assert of(name, "1.0") != of(name, "1.1")
    code_hash.cache_clear()


def test_two_names_that_differ_in_capitals_are_two_files(tmp_path: Path) -> None:
    section = {"kind": "table", "file": "level.csv", "signals": {"level": "m"}}
    project = Project(tmp_path, Case(section, {"level.csv": TABLE}, "", "", "a.level"))
    system = load_system(project.folder / "system.yaml")
    (part,) = system.components
    system = replace(system, components=(part, replace(part, name="A")))
    files = components.fmu_files(system, tmp_path / "build")
    assert len({path.name.casefold() for path in files.values()}) == 2


def test_an_fmu_that_is_replaced_after_it_was_read_is_not_used(c_fmu, tmp_path: Path) -> None:
    fmu = tmp_path / "a.fmu"
    shutil.copy(c_fmu("mass"), fmu)
    system = System("s", (Component("a", FmuFile(fmu)),), (), Simulation(1.0, 0.5))
    prepared = prepare(system)
    shutil.copy(c_fmu("spring"), fmu)
    for use in (lambda: run(prepared), lambda: start(prepared).__enter__()):
        with pytest.raises(RunError, match="was replaced by another FMU meanwhile"):
            use()
    run(system)


def test_members_of_one_name_in_packages_are_two_files(c_fmu, tmp_path: Path) -> None:
    for package, model in (("one", "mass"), ("two", "spring")):
        with zipfile.ZipFile(tmp_path / f"{package}.ssp", "w") as archive:
            archive.writestr("SystemStructure.ssd", "")
            archive.write(c_fmu(model), "resources/a.fmu")
            archive.write(c_fmu("mm_spring"), "resources/b/a.fmu")
            archive.write(c_fmu("stage"), "resources/b_a.fmu")
    members = [("one", "a.fmu"), ("two", "a.fmu"), ("two", "b/a.fmu"), ("two", "b_a.fmu")]
    parts = tuple(
        Component(f"c{k}", FmuFile(tmp_path / f"{package}.ssp", f"resources/{member}"))
        for k, (package, member) in enumerate(members)
    )
    files = components.fmu_files(System("s", parts, (), Simulation(1.0, 0.5)), tmp_path / "build")
    wanted = [c_fmu(name).read_bytes() for name in ("mass", "spring", "mm_spring", "stage")]
    assert [path.read_bytes() for path in files.values()] == wanted


def test_a_record_belongs_to_the_fmu_beside_it(table: Project) -> None:
    """A build is known by its record and content; a damaged one of either is built again."""
    table.run()
    fmu = table.folder / "build/s/a.fmu"
    record = fmu.with_name("a.build.json")
    content, told = fmu.read_bytes(), record.read_bytes()
    for damage in (
        lambda: fmu.write_bytes(content[:-1]),
        lambda: fmu.write_bytes(b""),
        fmu.unlink,
        record.unlink,
        lambda: record.write_bytes(told[:-3]),
        lambda: record.write_bytes(b"[" * 100_000),
        lambda: record.write_bytes(b"\xff"),
        lambda: record.write_bytes(b'{"fmu": 1}'),
    ):
        assert read_record(fmu) is not None
        damage()
        assert read_record(fmu) is None
        assert table.run()[0]
        assert fmu.read_bytes() == content


def test_a_disk_that_is_full_before_the_record_is_written(
    table: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The FMU is whole, and built again by the next run."""

    def full(path: Path, *_: object, **__: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        with pytest.raises(RunError, match="free disk space"):
            table.run()
    (fmu,) = (table.folder / "build/s").iterdir()
    assert zipfile.ZipFile(fmu).testzip() is None
    assert table.run()[0]
    assert not table.run()[0]


def test_files_of_readings_that_differ_are_never_current(tmp_path: Path) -> None:
    from m4e_fmi.files.files_read import are_unchanged, depends_on, read_bytes

    path = tmp_path / "x"
    path.write_text("one")
    with files_read() as files, files_read() as inner:
        read_bytes(path)
        depends_on(tmp_path / "none")
        assert files == inner
        assert are_unchanged(files)
        path.write_text("two")
        assert not are_unchanged(files)
        depends_on(path)
    for content in ("one", "two"):
        path.write_text(content)
        assert not are_unchanged(files)
    assert files[str(tmp_path / "none")] is None


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
