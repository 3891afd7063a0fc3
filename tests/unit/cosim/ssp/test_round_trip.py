"""Writing SSP packages: what comes back is what was written, and others can run it."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.cosim import (
    Component,
    FmuFile,
    Simulation,
    System,
    load_system,
    run,
    save_system,
)
from m4e_fmi.errors import InputError
from m4e_fmi.units import parse_quantity

Fmus = Callable[[str], Path]


def unlike(system: System) -> System:
    """The system without what must differ: where its FMUs are, and what reading it told."""
    parts = tuple(replace(c, source=FmuFile(Path(c.name))) for c in system.components)
    return replace(system, components=parts, folder=Path(), notes=())


@pytest.fixture
def pair(c_fmu: Fmus) -> System:
    """Everything that a system can have."""
    parts = (
        Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0, "stiffness": 1}),
        Component("b", FmuFile(c_fmu("mm_spring+state")), {"stiffness": 2e-3}),
        Component("c", FmuFile(c_fmu("stage+state")), {"gain": 0.1}),
        Component("d", FmuFile(c_fmu("stage+state"))),
        Component("e", FmuFile(c_fmu("stage+state"))),
    )
    connections = (
        "a.body.m <-> b.end",
        "c.twice * 0.5 + 0.25 -> d.gain",
        "a.body.m.x * -2.5 + 1.25 -> d.u, units ignored",
        "d.y -> e.u",
    )
    simulation = Simulation(
        2, 0.1, "corrector", output_interval=0.2, start_time=0.5, coupling_tolerance=1e-4
    )
    return System(
        "Paar (2)",
        parts,
        connections,
        simulation,
        description="ein <Paar> & mehr",
        inputs={"wish": ("c.u",)},
        outputs={"last": "e.y"},
    )


def test_a_system_comes_back_as_it_was(pair: System, tmp_path: Path) -> None:
    """The same bytes each time, and results of the same bits."""
    first = save_system(pair, tmp_path / "first.ssp", build_directory=tmp_path)
    assert save_system(pair, tmp_path / "too.ssp", build_directory=tmp_path).read_bytes() == (
        first.read_bytes()
    )
    back = load_system(first)
    assert back.notes == ()
    assert unlike(back) == unlike(pair)
    second = save_system(back, tmp_path / "second.ssp", build_directory=tmp_path)
    with zipfile.ZipFile(first) as one, zipfile.ZipFile(second) as two:
        files = {name: one.read(name) for name in one.namelist()}
        assert len([name for name in files if name.endswith(".fmu")]) == 3  # c, d, e share one
        for name in (name for name in files if name.endswith((".ssv", ".ssd"))):
            assert two.read(name) == files[name]
        assert sorted(files.values()) == sorted(two.read(name) for name in two.namelist())
    plain, again = (
        run(system, results=tmp_path / f"{k}.nc", build_directory=tmp_path).results().series
        for k, system in enumerate((pair, back))
    )
    assert all(np.array_equal(again[name].values, plain[name].values) for name in plain)
    with pytest.raises(InputError, match=r"saved as \.ssp"):
        save_system(pair, tmp_path / "pair.zip")


def test_values_with_units_are_written_in_those_of_the_fmu(c_fmu: Fmus, tmp_path: Path) -> None:
    start = {"body.m.x": "5 mm", "body.m.vx": parse_quantity("36 m/min")}
    system = System("s", (Component("a", FmuFile(c_fmu("mass")), start),), (), Simulation(1, 0.1))
    back = load_system(save_system(system, tmp_path / "s.ssp", build_directory=tmp_path))
    assert dict(back.components[0].start) == pytest.approx({"body.m.x": 5e-3, "body.m.vx": 0.6})


def test_a_changed_package_is_not_taken_for_ours(pair: System, tmp_path: Path) -> None:
    """Another tool drops a connection, and renames nothing: the rest stands alone."""
    path = save_system(pair, tmp_path / "pair.ssp", build_directory=tmp_path)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    text = files.pop("SystemStructure.ssd").decode()
    start = text.index('<ssd:Connection startElement="a" startConnector="body.m.vx"')
    end = text.index("/>", start) + len("/>")
    changed = tmp_path / "changed.ssp"
    with zipfile.ZipFile(changed, "w") as archive:
        archive.writestr("SystemStructure.ssd", text[:start] + text[end:])
        for name, content in files.items():
            archive.writestr(name, content)
    back = load_system(changed)
    assert "a.body.m <-> b.end" not in back.connections
    assert {"b.end.force_x -> a.body.m.force_x", "a.body.m.x -> b.end.x"} <= set(back.connections)
    assert any("each variable is connected alone" in note for note in back.notes)


STOP, STEP = 5.0, 1e-3
LAG = 2 * STEP * STOP
"""Others hold forces that are one step old, by which an amplitude of 1 grows by 5/8 of
STEP·STOP (theory, first order); one step more or less in the last row changes it by up to STEP."""


def written(tmp_path: Path, c_fmu: Fmus, *links: str, **start: float) -> Path:
    """A mass of 2 kg and a spring of 2 N/m."""
    parts = (
        Component("a", FmuFile(c_fmu("mass")), {"mass": 2.0, **start}),
        Component("b", FmuFile(c_fmu("spring")), {"stiffness": 2.0}),
    )
    system = System("pair", parts, links, Simulation(STOP, STEP, "jacobi"))
    return save_system(system, tmp_path / "pair.ssp", build_directory=tmp_path)


def before_a_wall(tmp_path: Path, c_fmu: Fmus) -> Path:
    """The wall is 1 m away: x = 1 - cos t."""
    return written(
        tmp_path,
        c_fmu,
        "a.body.m.x - 1 -> b.end.x",
        "a.body.m.vx -> b.end.vx",
        "b.end.force_x -> a.body.m.force_x",
    )


def test_fmpy_runs_our_package(c_fmu: Fmus, tmp_path: Path) -> None:
    """It knows no factors and offsets, and takes parameters from its caller only."""
    from fmpy.ssp.simulation import simulate_ssp
    from fmpy.ssp.ssd import ParameterSet, read_ssd

    path = written(tmp_path, c_fmu, "a.body.m <-> b.end", **{"body.m.x": 1.0})
    given = ParameterSet(name="all")
    root = read_ssd(path).system
    assert root is not None
    for part in root.elements:
        for parameter in part.parameterBindings[0].parameterValues[0].parameters:
            parameter.name = f"{part.name}.{parameter.name}"
            given.parameters.append(parameter)
    rows = simulate_ssp(path, stop_time=STOP, step_size=STEP, parameter_set=given)
    assert rows["a.body.m.x"][-1] == pytest.approx(np.cos(STOP), abs=LAG)


def test_libcosim_runs_our_package(c_fmu: Fmus, tmp_path: Path) -> None:
    pytest.importorskip("libcosimpy", reason="libcosimpy is not installed")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver

    execution = CosimExecution.from_ssp_file(str(before_a_wall(tmp_path, c_fmu)))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    assert execution.simulate_until(round(STOP * 1e9))
    index = execution.slave_index_from_instance_name("a")
    assert index is not None
    references = {v.name.decode(): v.reference for v in execution.slave_variables(index)}
    (found,) = observer.last_real_values(index, [references["body.m.x"]])
    assert found == pytest.approx(1 - np.cos(STOP), abs=LAG)


def test_ecos_runs_our_package(c_fmu: Fmus, tmp_path: Path) -> None:
    try:
        from ecospy import EcosSimulation
    except (ImportError, OSError) as error:
        pytest.skip(f"ecospy cannot be imported: {error}")
    with EcosSimulation(ssp_path=str(before_a_wall(tmp_path, c_fmu)), step_size=STEP) as simulation:
        simulation.init(parameter_set="parameters")
        simulation.step_until(STOP)
        assert simulation.get_real("a::body.m.x") == pytest.approx(1 - np.cos(STOP), abs=LAG)


def test_an_offset_on_the_way_to_an_input_without_a_unit(c_fmu: Fmus, tmp_path: Path) -> None:
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(c_fmu("stage+state")) as known, zipfile.ZipFile(bare, "w") as made:
        for name in known.namelist():
            made.writestr(name, known.read(name).replace(b'unit="s"', b""))
    parts = Component("a", FmuFile(c_fmu("mass+state"))), Component("b", FmuFile(bare))
    connections = ("a.body.m.x * 2 + 1 -> b.u",)
    system = System("offset", parts, connections, Simulation(1, 0.1, "jacobi"))
    back = load_system(save_system(system, tmp_path / "s.ssp", build_directory=tmp_path))
    assert back.connections == connections
