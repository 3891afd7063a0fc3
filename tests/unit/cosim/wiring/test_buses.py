"""Buses: one source per signal, units from end to end, packages without loss."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.described import described

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, load_system, run, save_system
from m4e_fmi.cosim.wiring.connect import connect
from m4e_fmi.cosim.wiring.links import Wiring

Fmus = Callable[[str], Path]

SEA = {"sea": {"height": "cm", "wind.speed": "m/s", "depth": "m"}}
PARTS = {
    "waves": described(
        "waves", ("elevation", "output", "m"), ("water_depth", "calculatedParameter", "m")
    ),
    "gusts": described("gusts", ("air.speed", "output", "m/s")),
    "control": described(
        "control", ("wave", "input", "mm"), ("depth", "parameter", "cm"), ("gust", "input", "m/s")
    ),
    "log": described("log", ("sea.height", "input", "m")),
}


def wired(*connections: str) -> Wiring:
    components = tuple(Component(name, FmuFile(Path(f"{name}.fmu"))) for name in PARTS)
    return connect(System("s", components, connections, Simulation(1.0, 0.1), buses=SEA), PARTS)


def test_a_signal_goes_from_its_source_to_all_that_take_it() -> None:
    wiring = wired(
        "sea.height * 2 + 5 -> control.wave",  # 5 mm
        "waves.elevation * 10 + 1 -> sea.height",  # 1 cm
        "sea.height -> log.sea.height",
        "waves.water_depth -> sea.depth",
        "sea.depth -> control.depth",
    )
    # 1 m is 1001 cm in the bus: 20020 mm + 5 mm, and 10.01 m
    assert {str(k): (k.factor, k.offset, k.connection) for k in wiring.links} == {
        "waves.elevation -> control.wave": (pytest.approx(2e4), pytest.approx(25.0), 0),
        "waves.elevation -> log.sea.height": (pytest.approx(10.0), pytest.approx(0.01), 2),
    }
    (constant,) = wiring.initial_links
    assert (str(constant), constant.factor) == ("waves.water_depth -> control.depth", 100.0)


def test_a_whole_bus_is_a_connector() -> None:
    wiring = wired("waves.elevation -> sea.height", "sea <-> log.sea")
    assert [str(link) for link in wiring.links] == ["waves.elevation -> log.sea.height"]
    wiring = wired("gusts.air <-> sea.wind", "sea.wind.speed -> control.gust")
    assert [str(link) for link in wiring.links] == ["gusts.air.speed -> control.gust"]


@pytest.fixture
def pair(c_fmu: Fmus) -> System:
    """A mass of 2 kg on a spring whose end is moved in mm, over a bus that is in cm."""
    parts = (
        Component("a", FmuFile(c_fmu("mass+state")), {"body.m.x": 1.0, "mass": 2.0}),
        Component("b", FmuFile(c_fmu("mm_spring+state")), {"stiffness": 2e-3}),
        Component("c", FmuFile(c_fmu("integrator+state"))),
    )
    texts = ("a.body.m <-> deck", "deck <-> b.end", "deck.x * -2.5 + 1.25 -> c.u, units ignored")
    buses = {"deck": {"x": "cm", "vx": "m/s", "force_x": "kN", "ax": "m/s2"}}
    settings = Simulation(2.0, 0.1, coupling_tolerance=1e-4, output_interval=0.2)
    return System("pair", parts, texts, settings, buses=buses)


def values(system: System, folder: Path) -> np.ndarray:
    found = run(system, results=folder / "r.nc", build_directory=folder).results()
    return np.array([found[name].values for name in ("a.body.m.x", "b.end.force_x", "c.y")])


def content(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def changed(path: Path, old: bytes, new: bytes) -> System:
    """The system of the package with another structure, as another tool might leave it."""
    files = content(path)
    structure = files["SystemStructure.ssd"]
    assert structure.count(old) == 1
    files["SystemStructure.ssd"] = structure.replace(old, new)
    other = path.with_name("changed.ssp")
    with zipfile.ZipFile(other, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return load_system(other)


def test_a_bus_is_what_its_connections_are(pair: System, tmp_path: Path) -> None:
    """In a run, in a package, and in a package that other tools have changed."""
    over_bus = values(pair, tmp_path)
    # deck.x is in cm: a bare -2.5 · 100 x + 1.25
    direct = ("a.body.m <-> b.end", "a.body.m.x * -250 + 1.25 -> c.u, units ignored")
    plain = values(replace(pair, connections=direct, buses={}), tmp_path)
    # m → cm → mm is rounded once more than m → mm
    np.testing.assert_allclose(over_bus, plain, rtol=1e-12, atol=1e-13)
    path = save_system(pair, tmp_path / "pair.ssp", build_directory=tmp_path)
    back = load_system(path)
    assert (back.connections, back.buses) == (pair.connections, pair.buses)
    np.testing.assert_array_equal(values(back, tmp_path), over_bus)
    again = save_system(back, tmp_path / "again.ssp", build_directory=tmp_path)
    assert content(again)["SystemStructure.ssd"] == content(path)["SystemStructure.ssd"]
    # to other tools they are plain connections
    told = json.dumps({"deck": dict(pair.buses["deck"])})[1:-1].encode()
    back = changed(path, told, b"")
    assert back.buses == {}
    assert set(back.connections) == {
        "b.end.force_x -> a.body.m.force_x",
        "a.body.m.x -> b.end.x",
        "a.body.m.vx -> b.end.vx",
        "a.body.m.x * -250.0 + 1.25 -> c.u, units ignored",
    }
    np.testing.assert_allclose(values(back, tmp_path), over_bus, rtol=1e-12, atol=1e-13)
    back = changed(path, b'factor="-250.0"', b'factor="-200.0"')
    assert back.buses == {}
    assert "a.body.m.x * -200.0 + 1.25 -> c.u, units ignored" in back.connections
    assert any("each variable is connected alone, without buses" in note for note in back.notes)
