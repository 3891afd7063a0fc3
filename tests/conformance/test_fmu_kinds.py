"""The same questions of FMUs of every kind: what their files say, what they compute.

Kinds: in Python and native, of FMI 2.0 and 3.0, for co-simulation and model exchange. States that
are saved, errors and refusals: test_fmu_kinds_calls.py.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.fmu_instances import FILES, KINDS, Instance, dependency_kinds, opened
from support.fmu_programs import ODD, PROGRAMS, pendulum, tunable

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.cosim import load as load_results
from m4e_fmi.fmu import build_fmu
from m4e_fmi.fmu.export.selection import with_outputs
from m4e_fmi.simulate import simulate

LARGEST = 300_000
"""Bytes of a native FMU."""
NATIVE = [name for name, kind in FILES.items() if kind.native]
Load = Callable[..., Instance]
Fmu = Callable[..., Path]
files = pytest.mark.parametrize("kind", FILES)
kinds = pytest.mark.parametrize("kind", KINDS)


class TestFiles:
    @files
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_fmpy_finds_nothing_wrong(self, fmu: Fmu, kind: str, name: str) -> None:
        path = fmu(kind, name)
        assert validate_fmu(str(path)) == []
        assert not FILES[kind].native or path.stat().st_size < LARGEST
        with zipfile.ZipFile(path) as archive:  # not in the order of some file system
            assert archive.namelist() == sorted(archive.namelist())

    @files
    def test_variables(self, fmu: Fmu, kind: str) -> None:
        description: Any = fmpy.read_model_description(str(fmu(kind, "tunable")))
        found = {
            v.name: (
                v.causality,
                v.variability,
                v.start,
                v.unit,
                v.derivative and v.derivative.name,
            )
            for v in description.modelVariables
        }
        found.pop("time", None)  # of FMI 3.0
        assert found.pop("last_error")[:2] == ("local", "discrete")
        assert found == {
            "k": ("parameter", "tunable", "2.0", "1/s", None),
            "scale": ("parameter", "fixed", "1.0", "kN", None),
            "time_constant": ("calculatedParameter", "tunable", None, "s", None),
            "u": ("input", "continuous", "1.0", "1", None),
            "x": ("output", "continuous", "0.0", "1", None),
            "hidden": ("local", "continuous", "0.0", "1", None),
            "y": ("output", "continuous", None, "kN", None),
            "der(x)": ("local", "continuous", None, "1/s", "x"),
            "der(hidden)": ("local", "continuous", None, "1/s", "hidden"),
        }
        initial = {v.name: v.initial for v in description.modelVariables}
        exact = [name for name, (*_, start, _, _) in found.items() if start]
        assert {initial[name] for name in exact} == {"exact"}
        assert {initial[name] for name in set(found) - set(exact)} == {"calculated"}
        written = {
            v.description
            for v in description.modelVariables
            if v.causality not in ("local", "independent")
        }
        assert {*written, description.description} == {ODD}
        units = {unit.name: unit for unit in description.unitDefinitions}
        assert set(units) == {"1", "1/s", "kN", "s"}
        force = units["kN"].baseUnit
        assert (force.kg, force.m, force.s, force.factor) == (1, 1, -2, 1000.0)
        (display,) = units["kN"].displayUnits
        # value in the display unit = factor · value in the unit
        assert (display.name, display.factor) == ("N", 1000.0)

    @pytest.mark.parametrize("kind", NATIVE)
    def test_dependencies_and_their_kinds(self, fmu: Fmu, kind: str) -> None:
        description: Any = fmpy.read_model_description(str(fmu(kind)))
        outputs = dependency_kinds(description.outputs)
        assert outputs["x"] == {"x": "constant"}
        assert outputs["a"] == {"force": "fixed", "x": "tunable", "v": "fixed"}
        assert outputs["height"] == {"x": "constant", "lift": "constant"}
        assert outputs["pull"] == {"x": "tunable"}
        assert outputs["energy"] == {"x": "dependent"}
        swing = {"x": "constant", "lift": "dependent"}
        assert outputs["swing"] == (swing | {"time": "dependent"} if "3" in kind else swing)
        assert "momentum" not in outputs
        rates = dependency_kinds(description.derivatives)
        assert list(rates) == ["der(x)", "a"]
        assert rates["der(x)"] == {"v": "constant"}
        first = dependency_kinds(description.initialUnknowns)
        assert first["frequency"] == {"stiffness": "dependent", "mass": "dependent"}
        assert first["height"] == {"x": "constant", "lift": "constant"}
        assert first["pull"] == {"x": "dependent", "stiffness": "dependent"}

    @files
    @pytest.mark.parametrize("name", ["pendulum", "floating", "algebraic", "tunable"])
    def test_declared_dependencies_are_those_measured(
        self, load: Load, kind: str, name: str
    ) -> None:
        """At a general state an unknown moves with an input, or start value, if it says so."""
        instance = load(kind, name)
        known = {
            name: _moved(v.start, 0.05 * (k + 1))
            for k, (name, v) in enumerate(instance.variables.items())
            if v.start is not None
        }
        instance.set(known)
        instance.enter()
        unknowns = instance.description.initialUnknowns
        assert _declared(unknowns) == _measured(instance, _declared(unknowns), known)
        instance.fmu.exitInitializationMode()
        outputs = _declared(instance.description.outputs, among=instance.reals("input"))
        assert set(outputs) == set(instance.reals("output"))
        inputs = {name: known[name] for name in instance.reals("input")}
        assert outputs == _measured(instance, outputs, inputs)

    @files
    def test_the_same_bytes_every_time(self, fmu: Fmu, kind: str, tmp_path: Path) -> None:
        """Also in another process, whatever the hash seed: no order of a set matters."""
        script = (
            "import sys; from m4e_fmi.fmu import build_fmu\n"
            "from support.fmu_programs import pendulum\n"
            "build_fmu(pendulum(), sys.argv[1], native=sys.argv[2] == 'True', fmi=sys.argv[3])\n"
        )
        path, of = tmp_path / "again.fmu", FILES[kind]
        subprocess.run(
            [sys.executable, "-c", script, str(path), str(of.native), of.fmi],
            cwd=Path(__file__).parents[1],
            env={**os.environ, "PYTHONHASHSEED": "17"},
            check=True,
        )
        assert path.read_bytes() == fmu(kind, "pendulum").read_bytes()
        guids = {
            fmpy.read_model_description(str(build_fmu(tunable(rate=k), path, **of.build))).guid
            for k in (2.0, 3.0)
        }
        assert len(guids) == 2

    @files
    def test_default_experiment_and_capabilities(self, fmu: Fmu, kind: str) -> None:
        asked = {"stop_time": 3.5, "step_size": 0.25, "tolerance": 1e-6}
        for options, expected in (
            (asked, ["3.5", "0.25", "1e-06"]),
            ({}, ["10.0", "0.01", "1e-08"]),
        ):
            description: Any = fmpy.read_model_description(str(fmu(kind, **options)))
            found = description.defaultExperiment
            assert [found.stopTime, found.stepSize, found.tolerance] == expected
        able = description.coSimulation
        assert able.canHandleVariableCommunicationStepSize
        assert able.canGetAndSetFMUstate
        assert able.canSerializeFMUstate
        assert not able.canBeInstantiatedOnlyOncePerProcess
        assert able.needsExecutionTool != FILES[kind].native
        assert (description.modelExchange is not None) == FILES[kind].native

    @files
    def test_licenses_of_what_is_inside(self, fmu: Fmu, kind: str) -> None:
        with zipfile.ZipFile(fmu(kind)) as archive:
            names, place = archive.namelist(), "documentation/licenses/"
            texts = {n: archive.read(place + n).decode() for n in _below(place, names)}
        overview = texts.pop("license.txt")
        assert all(f"see {name}" in overview for name in texts)
        assert overview.count("see ") == len(texts)
        assert "BSD 3-Clause License" in texts.pop("m4e_fmi.txt")
        if not FILES[kind].native:
            assert "MIT License" in texts.pop("pythonfmu.txt")
        elif any(name.endswith(".dll") for name in names):
            assert "Zope Public License" in texts.pop("mingw-w64.txt")
        assert texts == {}

    @pytest.mark.parametrize("kind", [k for k, kind in KINDS.items() if kind.native])
    @pytest.mark.parametrize("change", [lambda g: g + " 1", lambda g: g[:-2] + "x}"])
    def test_another_guid_is_refused(self, load: Load, kind: str, change: Any) -> None:
        """Also one that goes on where that in the FMU's own file has ended."""
        instance = load(kind)
        component, instance.fmu.guid = instance.fmu.component, change(instance.fmu.guid)
        with pytest.raises(Exception, match="nstantiate"):
            instance.instantiate()
        instance.fmu.component = component


def _below(place: str, names: list[str]) -> list[str]:
    return [name.removeprefix(place) for name in names if name.startswith(place)]


def _moved(start: str, by: float) -> list[float]:
    return [float(one) + by for one in start.split()]


def _declared(unknowns: Any, among: list[str] | None = None) -> dict[str, set[str]]:
    return {
        u.variable.name: {v.name for v in u.dependencies if among is None or v.name in among}
        - {"time"}
        for u in unknowns
    }


def _measured(
    instance: Instance, unknowns: dict[str, set[str]], known: dict[str, list[float]]
) -> dict[str, set[str]]:
    before = {name: instance.get([name]) for name in unknowns}
    found: dict[str, set[str]] = {name: set() for name in unknowns}
    for moved, values in known.items():
        instance.set({moved: [value + 0.25 for value in values]})
        for name in unknowns:
            if instance.get([name]) != before[name]:
                found[name].add(moved)
        instance.set({moved: values})
    assert {name: instance.get([name]) for name in unknowns} == before
    return found


def oscillation(t: float) -> float:
    """Place [m] of `driven`, x' = v, v' = −15 x − 0.2 v + 1/2 from rest at 0.1 m."""
    decay, speed, rest = 0.1, math.sqrt(15.0 - 0.01), 1.0 / 30.0
    c, s = 0.1 - rest, decay * (0.1 - rest) / speed
    return rest + math.exp(-decay * t) * (c * math.cos(speed * t) + s * math.sin(speed * t))


class TestRuns:
    @kinds
    def test_parts_of_a_step(self, load: Load, kind: str) -> None:
        """Steps of any size follow the exact solution; outputs are those of the states."""
        instance, t = load(kind).initialise(), 0.0
        for h in (0.3, 0.001, 0.7, 1e-6, 0.998999):
            instance.step(t, h)
            t += h
            assert instance["x"] == pytest.approx(oscillation(t), abs=1e-7)
            x, v = instance.get(["x", "v"])
            assert instance["a"] == pytest.approx((1.0 - 30.0 * x - 0.4 * v) / 2.0, rel=1e-14)

    def test_the_same_bits_in_all_kinds(self, load: Load) -> None:
        """The same library runs them, also with a tolerance and after a restart."""
        instances = [load(kind) for kind in FILES]
        states = []
        for instance in instances:
            instance.initialise({"stiffness": 80.0}, tolerance=1e-6)
        names = instances[0].reals()

        def values() -> list[list[float]]:
            return [instance.get(names) for instance in instances]

        for k in range(40):
            if k == 20:
                states = [instance.save() for instance in instances]
            for instance in instances:
                instance.set({"force": math.sin(k), "lift": 0.01 * k, "stiffness": 80.0 + k})
                instance.step(0.05 * k, 0.05 if k % 3 else 0.02)
                if k % 3 == 0:
                    instance.step(0.05 * k + 0.02, 0.03)
            assert all(found == values()[0] for found in values())
        for instance, state in zip(instances, states, strict=True):
            instance.restore(state)
            instance.step(1.0, 0.4)
        assert all(found == values()[0] for found in values())

    @files
    @pytest.mark.parametrize("method", ["rk45", "dop853", "rodas", "rk4"])
    def test_the_bits_of_simulate(self, load: Load, kind: str, method: str) -> None:
        """By each method, where no step is cut; fixed steps in equal parts of each step."""
        how: dict[str, Any] = {"method": method}
        if method == "rk4":
            how["step_size"] = 0.03
        motion = with_outputs(pendulum(), ["body.*"])  # no powers: FMUs integrate no works
        expected = simulate(motion, stop_time=1.0, output_interval=0.5, **how)
        instance = load(kind, "pendulum", built=how).initialise(tolerance=1e-8)
        for t in (0.0, 0.5) if method == "rk4" else (0.0,):
            instance.step(t, 0.5 if method == "rk4" else 1.0)
        if method != "rk4":
            expected = simulate(motion, stop_time=1.0, output_interval=1.0, **how)
        assert instance["body.lower.theta"] == expected["body.lower.theta"][-1]

    def test_in_the_master(self, fmu: Fmu, tmp_path: Path) -> None:
        """Two coupled oscillators with held inputs, of any kind: the same bits."""
        found = []
        for kind in FILES:
            parts = tuple(Component(c, FmuFile(fmu(kind)), {}) for c in ("first", "second"))
            links = ("first.x -> second.lift", "second.swing -> first.lift")
            system = System("s", parts, links, Simulation(2.0, 0.05, algorithm="gauss_seidel"))
            run(system, results=tmp_path / f"{kind}.nc")
            series = load_results(tmp_path / f"{kind}.nc").series
            found.append({name: one.values.tolist() for name, one in series.items()})
        assert len(found[0]) > 10
        assert all(one == found[0] for one in found)

    @kinds
    def test_start_time(self, load: Load, kind: str) -> None:
        instance = load(kind, "algebraic").initialise(startTime=5.0)
        assert instance["clock"] == 5.0
        instance.step(5.0, 0.5)
        assert instance["clock"] == 5.5

    @files
    def test_tolerance(self, load: Load, kind: str) -> None:
        """The one that is asked for; else that with which the FMU was built."""
        errors, found = [], []
        for built, given in (({}, 1e-4), ({"tolerance": 1e-4}, None), ({}, 1e-12)):
            experiment: dict[str, Any] = {} if given is None else {"tolerance": given}
            instance = load(kind, "autonomous", built=built).initialise(**experiment)
            instance.step(0.0, 2.0)
            found.append(instance["x"])
            errors.append(abs(found[-1] - math.cos(4) - 0.3 * math.sin(4) + 0.2 * math.sin(6)))
        assert found[0] == found[1]
        assert errors[0] > 1e-8
        assert errors[2] < 1e-10

    @kinds
    def test_start_values(self, load: Load, kind: str) -> None:
        """Before initialization and in it, where outputs may be read and more be set."""
        instance = load(kind, "tunable")
        instance.set({"x": 0.25, "scale": 3.0, "u": 0.0})
        instance.enter()
        assert instance.get(["time_constant", "y"]) == [0.5, 0.75]
        instance.set({"k": 0.5, "x": 0.5})
        assert instance.get(["time_constant", "y", "der(x)"]) == [2.0, 1.5, -0.25]
        instance.fmu.exitInitializationMode()
        if KINDS[kind].exchange:
            instance.settle()
            instance.fmu.enterContinuousTimeMode()
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(0.5 * math.exp(-0.5), abs=1e-7)

    @kinds
    def test_added_mass_set_at_initialisation_counts(self, load: Load, kind: str) -> None:
        rows = (0.0, 0.0, 0.0), (0.0, 5.0, 0.0), (0.0, 0.0, 0.0)
        for added, expected in ((0.0, -9.81), (5.0, -9.81 * 5 / (5 + 5))):
            matrix = [value if value == 0.0 else added for row in rows for value in row]
            instance = load(kind, "floating")
            names = [f"added_mass[{i},{j}]" for i in (1, 2, 3) for j in (1, 2, 3)]
            instance.initialise(dict(zip(names, matrix, strict=True)))
            assert instance["body.hull.az"] == pytest.approx(expected, rel=1e-14)

    @kinds
    def test_a_tunable_parameter_may_change_between_steps(self, load: Load, kind: str) -> None:
        instance = load(kind, "tunable").initialise()
        instance.step(0.0, 0.5)
        x = instance["x"]
        instance.change({"k": 10.0})
        assert instance["time_constant"] == 0.1
        instance.step(0.5, 0.1)
        assert instance["x"] == pytest.approx(1 - (1 - x) * math.exp(-1.0), abs=1e-7)

    @kinds
    def test_inputs_set_after_a_step_change_what_they_feed_through_to(
        self, load: Load, kind: str
    ) -> None:
        instance = load(kind).initialise()
        instance.step(0.0, 0.01)
        before = dict(zip(instance.reals(), instance.get(instance.reals()), strict=True))
        instance.set({"force": 100.0})
        after = dict(zip(instance.reals(), instance.get(instance.reals()), strict=True))
        assert {name for name in before if before[name] != after[name]} == {"a", "force"}
        assert after["a"] - before["a"] == pytest.approx(99.0 / 2.0, rel=1e-14)

    @kinds
    def test_reset(self, load: Load, kind: str) -> None:
        instance, fresh = load(kind).initialise({"stiffness": 50.0, "x": 0.3}), load(kind)
        instance.step(0.0, 0.5)
        instance.fmu.reset()
        for one in (instance, fresh):
            one.initialise()
            one.step(0.0, 0.5)
        assert instance.get(instance.reals()) == fresh.get(fresh.reals())

    @kinds
    def test_instances_side_by_side(self, load: Load, kind: str, tmp_path: Path) -> None:
        """Of one FMU, and of another version of the same name; one after the other, too."""
        other = build_fmu(tunable(rate=3.0), tmp_path / "tunable.fmu", **KINDS[kind].build)
        instances = {1.0: load(kind, "tunable"), 2.0: load(kind, "tunable"), 3.0: load(kind, other)}
        for instance, start in zip(instances.values(), ({"k": 1.0}, {}, {}), strict=True):
            instance.initialise(start)
        for t, end in pairwise((0.0, 0.5, 1.0)):
            for instance in instances.values():
                instance.step(t, end - t)
        for k, instance in instances.items():
            assert instance["x"] == pytest.approx(1 - math.exp(-k), abs=1e-7)
            assert instance["time_constant"] == 1.0 / k

    @kinds
    def test_folders_of_any_name(self, fmu: Fmu, kind: str, tmp_path: Path) -> None:
        """But for PythonFMU's binary, which decodes spaces only."""
        odd = "a b é # % [x] &+,;=' 100%25" if KINDS[kind].native else "a b"
        for _ in range(2):  # it is deleted in between
            folder = tmp_path / "of today" / odd
            with opened(fmu(kind), folder, KINDS[kind]) as instance:
                instance.initialise().step(0.0, 0.1)
                assert instance["x"] == pytest.approx(oscillation(0.1), abs=1e-7)
                assert instance.last_error == ""
            assert not folder.exists()
