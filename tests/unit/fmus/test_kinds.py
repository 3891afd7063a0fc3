"""What every kind of FMU does, whatever it computes. A new one is tested by its section in `KINDS`.

A kind that is a program is built for Python and native, in FMI 2.0 and 3.0, for co-simulation and
model exchange; one that is Python code is a Python FMU.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import pytest
from support.fmu_instances import Instance, Instance3

from m4e_fmi.errors import InputError
from m4e_fmi.files.document import Document
from m4e_fmi.fmu import PythonSource, build_fmu
from m4e_fmi.program import Program

WAVES = "waves: {spectrum: regular, height: 1, period: 6, ramp_time: 0}\n"
KINDS = {
    "hull_pressure": "bodies: {ball: {shape: {sphere: {radius: 2}}, center_of_gravity: [0, -0.5], "
    f"panels: 50}}}}\n{WAVES}",
    "hydrodynamics": "bodies: {ball: {shape: {sphere: {radius: 2}}, center_of_gravity: [0, -0.5], "
    f"panels: 50}}}}\n{WAVES}frequencies: {{count: 16}}\nradiation: {{order: 4}}\n",
    "joint_pid": "duration: 1\njoints: {elbow: {target: 0.8, proportional: 400, integral: 9}}\n",
    "linear_pto": "point: rod\nanchor: [0, -50]\ndamping: 7\nstiffness: 3\nrest_length: 48\n",
    "mooring": "water: {density: 1025, depth: 60}\nfairleads: {bow: [-5, -3]}\n"
    "line_types: {chain: {diameter: 0.1, mass_per_length: 150, axial_stiffness: 1e8, "
    "axial_damping_ratio: 1, drag_coefficient: 1.2, added_mass_coefficient: 1}}\n"
    "anchors: {left: [-150, -60]}\n"
    "lines: {l: {type: chain, from: left, to: bow, unstretched_length: 165, segments: 4}}\n",
    "morison": f"members: {{leg: {{ends: [[0, -9], [0, 2]], diameter: 1, drag: 1}}}}\n{WAVES}",
    "python": "file: delay.py\n",
    "sea": f"points: {{probe: [3, -1]}}\nmoving_points: {{buoy: [0, 0]}}\n{WAVES}",
    "sum": "inputs: {one: 1, other: -2}\nunit: kN\n",
    "table": "times: [0, 0.3, 0.3, 9]\nsignals: {f: {unit: kN, values: [0.5, 1.5, 5, 9]}}\n",
    "wind": "speed: 14\npoints: {mast: {area: 25, coefficient: 1.1, at: [0, 12]}}\n",
}
OF_PYTHON = ("hull_pressure", "mooring", "python")
"""Kinds that are Python code."""
DELAY = """\
class Delay:
    inputs = {"u": "m"}
    outputs = {"y": "m"}

    def start(self, v):
        self.past = [v.u, v.u]

    def step(self, t, h, v):
        self.past = [self.past[1], v.u]
        return {"y": self.past[0]}
"""
STEP = 0.1
Fmu = Callable[..., Path]


def points() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group="m4e_fmi.fmus")}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Fmu:
    """`fmu(kind, build)` is the FMU of a kind, `build` being python, 2 or 3 (native)."""
    folder = tmp_path_factory.mktemp("kinds")
    (folder / "delay.py").write_text(DELAY, encoding="utf-8")

    @cache
    def source(kind: str) -> Program | PythonSource:
        found = points()[kind].load()
        config = Document.parse(KINDS[kind]).validate(found.config)
        return found.build(config, name=kind, folder=folder, progress=lambda _: None)

    @cache
    def built(kind: str, build: str) -> Path:
        keys: dict[str, Any] = {"native": True, "fmi": build} if build != "python" else {}
        return build_fmu(source(kind), folder / f"{kind}_{build}.fmu", **keys)

    return built


def test_every_kind_is_asked() -> None:
    assert KINDS.keys() == points().keys()


def rows(instance: Instance, first: int, last: int, size: float = 0.1) -> list[list[float]]:
    """Steps with inputs that change by `size` about their start, and the outputs after each."""
    variables = instance.description.modelVariables
    start = {v.name: float(v.start) for v in variables if v.causality == "input"}
    found = []
    for k in range(first, last):
        places = enumerate(start.items())
        instance.set({name: value + size * math.sin(k + j) for j, (name, value) in places})
        instance.step(k * STEP, STEP)
        found.append(instance.get(instance.reals("output")))
    return found


def numbers(instance: Instance) -> list[float]:
    """All outputs after five steps, by size."""
    for k in range(5):
        instance.step(k * STEP, STEP)
    return sorted(instance.get(instance.reals("output")))


@pytest.mark.parametrize("kind", KINDS)
def test_a_saved_state_replays_to_the_bit(kind: str, fmu: Fmu, tmp_path: Path) -> None:
    """In this instance, and in another one."""
    path = fmu(kind, "python")
    with Instance(path, tmp_path / "one") as one, Instance(path, tmp_path / "other") as other:
        one.initialise()
        rows(one, 0, 3)
        state = one.save()
        saved = one.pack(state)
        expected = rows(one, 3, 6)
        assert expected[0] != expected[-1]
        one.restore(state)
        assert rows(one, 3, 6) == expected
        other.initialise()
        rows(other, 0, 1)
        other.restore(other.unpack(saved))
        assert rows(other, 3, 6) == expected


@pytest.mark.parametrize("kind", KINDS)
def test_builds_give_the_same_to_the_bit(kind: str, fmu: Fmu, tmp_path: Path) -> None:
    if kind in OF_PYTHON:
        with pytest.raises(InputError, match="native"):
            fmu(kind, "2")
        return
    with Instance(fmu(kind, "python"), tmp_path / "p") as python:
        expected = rows(python.initialise(), 0, 5)
    with Instance(fmu(kind, "2"), tmp_path / "n") as native:
        outputs = native.initialise().reals("output")
        start = native.get(outputs)
        assert rows(native, 0, 5) == expected
    with (
        Instance(fmu(kind, "2"), tmp_path / "n") as native,
        Instance3(fmu(kind, "3"), tmp_path / "three") as third,
    ):
        *_, last = rows(native.initialise(), 0, 5, size=0.0)
        assert numbers(third.initialise()) == sorted(last)
    with Instance(fmu(kind, "2"), tmp_path / "exchange", exchange=True) as model:
        assert model.initialise().get(outputs) == start
