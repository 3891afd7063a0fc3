"""Python FMUs: their files, and what their description says."""

from __future__ import annotations

import hashlib
import math
import os
import stat
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.validation import validate_fmu
from support.fmu_instance import Instance
from support.python_programs import (
    ODD,
    algebraic,
    autonomous,
    tunable,
)
from support.python_programs import PYTHON_PROGRAMS as PROGRAMS

from m4e_fmi.errors import InputError
from m4e_fmi.fmu import build_fmu, describe
from m4e_fmi.fmu.export.from_program import python_slave
from m4e_fmi.model import Body, Joint, Model, Parameter
from m4e_fmi.multibody import model_program
from m4e_fmi.program import Recorder, Variable

EXAMPLES = Path(__file__).parents[2] / "examples"
Load = Callable[..., Instance]


class TestArchive:
    @pytest.mark.parametrize("name", PROGRAMS)
    def test_no_findings(self, python_fmus: dict[str, Path], name: str) -> None:
        assert validate_fmu(str(python_fmus[name])) == []

    @pytest.mark.parametrize("name", PROGRAMS)
    def test_built_twice_the_bytes_are_the_same(
        self, python_fmus: dict[str, Path], tmp_path: Path, name: str
    ) -> None:
        again = build_fmu(PROGRAMS[name](), tmp_path / "elsewhere" / "again.fmu")
        assert again.read_bytes() == python_fmus[name].read_bytes()
        with zipfile.ZipFile(again) as archive:  # not in the order of some file system
            assert archive.namelist() == sorted(archive.namelist())

    def test_built_in_another_process_the_bytes_are_the_same(
        self, python_fmus: dict[str, Path]
    ) -> None:
        """Whatever the hash seed: nothing depends on the order of a set."""
        script = (
            "import sys, hashlib, pathlib\n"
            "from m4e_fmi.fmu import build_fmu\n"
            "from m4e_fmi.multibody import model_program\n"
            "path = build_fmu(model_program(sys.argv[1]), sys.argv[2])\n"
            "print(hashlib.sha256(path.read_bytes()).hexdigest())\n"
        )
        model = EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"
        target = python_fmus["double_pendulum"].with_name("other_process.fmu")
        digest = subprocess.run(
            [sys.executable, "-c", script, str(model), str(target)],
            env={**os.environ, "PYTHONHASHSEED": "17"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.strip()
        expected = hashlib.sha256(python_fmus["double_pendulum"].read_bytes()).hexdigest()
        assert digest == expected

    def test_another_program_has_another_guid(self, tmp_path: Path) -> None:
        guids = set()
        for rate in (2.0, 3.0):
            path = build_fmu(tunable(rate=rate), tmp_path / "one.fmu")
            description: Any = fmpy.read_model_description(str(path))
            guids.add(description.guid)
        assert len(guids) == 2

    def test_the_file_is_replaced_as_a_whole_and_readable_by_others(self, tmp_path: Path) -> None:
        path = tmp_path / "a.fmu"
        path.write_bytes(b"old")
        mask = os.umask(0o022)
        try:
            build_fmu(algebraic(), path)
        finally:
            os.umask(mask)
        assert {file.name for file in tmp_path.iterdir()} == {"a.fmu", "a.build.json"}
        assert stat.S_IMODE(path.stat().st_mode) == 0o644

    @pytest.mark.parametrize(
        "name", ["lambda", "ProgramSlave", "M4eSlave", "None", "a b-c", "json"]
    )
    def test_any_name_that_starts_with_a_letter(
        self, load_python: Load, tmp_path: Path, name: str
    ) -> None:
        path = build_fmu(tunable(name), tmp_path / "named.fmu")
        assert validate_fmu(str(path)) == []
        instance = load_python(path).initialise()
        instance.step(0.0, 1.0)
        assert instance["x"] == pytest.approx(1 - math.exp(-2.0), abs=1e-7)

    @pytest.mark.parametrize("name", ["", "2d", "été", "_a"])
    def test_other_names_are_refused(self, tmp_path: Path, name: str) -> None:
        with pytest.raises(InputError, match="cannot name an FMU"):
            build_fmu(tunable(name), tmp_path / "named.fmu")
        assert not list(tmp_path.iterdir())

    def test_a_variable_called_last_error_is_refused(self, tmp_path: Path) -> None:
        r = Recorder("taken", "")
        r.parameter(Variable("last_error", "1", ""))
        with pytest.raises(InputError, match="every FMU has a variable 'last_error'"):
            build_fmu(r.program(), tmp_path / "taken.fmu")

    def test_an_unknown_unit_is_refused(self, tmp_path: Path) -> None:
        r = Recorder("unit", "")
        r.output(Variable("y", "furlong", ""), 1.0)
        with pytest.raises(ValueError, match="'furlong' is not a unit"):
            build_fmu(r.program(), tmp_path / "unit.fmu")


class TestDescription:
    def test_variables(self, python_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(python_fmus["tunable"]))
        found = {
            v.name: (v.causality, v.variability, v.initial, v.start, v.unit)
            for v in description.modelVariables
        }
        assert found == {
            "k": ("parameter", "tunable", "exact", "2.0", "1/s"),
            "scale": ("parameter", "fixed", "exact", "1.0", "kN"),
            "time_constant": ("calculatedParameter", "tunable", "calculated", None, "s"),
            "u": ("input", "continuous", "exact", "1.0", "1"),  # FMI's default for an input
            "x": ("output", "continuous", "exact", "0.0", "1"),
            "hidden": ("local", "continuous", "exact", "0.0", "1"),
            "y": ("output", "continuous", "calculated", None, "kN"),
            "der(x)": ("local", "continuous", "calculated", None, "1/s"),
            "der(hidden)": ("local", "continuous", "calculated", None, "1/s"),
            "last_error": ("local", "discrete", "calculated", None, None),
        }

    def test_texts_arrive_as_they_were_written(self, python_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(python_fmus["tunable"]))
        written = [v for v in description.modelVariables if v.causality != "local"]
        texts = {v.description for v in written}
        assert texts == {ODD}
        assert description.description == ODD

    def test_characters_that_xml_cannot_hold_are_replaced(self, tmp_path: Path) -> None:
        program = replace(tunable(), description="a\x07b\x01c\ufffe")
        path = build_fmu(program, tmp_path / "bell.fmu")
        description: Any = fmpy.read_model_description(str(path))
        assert description.description == "a\ufffdb\ufffdc\ufffd"

    def test_units(self, python_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(python_fmus["tunable"]))
        units = {unit.name: unit for unit in description.unitDefinitions}
        assert set(units) == {"1", "1/s", "kN", "s"}
        force = units["kN"].baseUnit
        assert (force.kg, force.m, force.s, force.factor) == (1, 1, -2, 1000.0)
        (display,) = units["kN"].displayUnits
        # value in the display unit = factor · value in the unit
        assert (display.name, display.factor) == ("N", 1000.0)

    def test_display_unit_of_a_model_parameter(self, tmp_path: Path) -> None:
        model = Model(
            name="heavy",
            parameters={"m": Parameter(148, "t")},
            bodies={"body": Body("m", 1.0)},
            joints={"sea": Joint("floating", "body")},
        )
        path = build_fmu(model_program(model), tmp_path / "heavy.fmu")
        description: Any = fmpy.read_model_description(str(path))
        mass = next(v for v in description.modelVariables if v.name == "m")
        assert (mass.start, mass.unit, mass.displayUnit) == ("148000.0", "kg", "t")
        kilogram = next(unit for unit in description.unitDefinitions if unit.name == "kg")
        assert [(d.name, d.factor) for d in kilogram.displayUnits] == [("t", 0.001)]

    def test_derivatives(self, python_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(python_fmus["double_pendulum"]))
        found = {v.name: v.derivative.name for v in description.modelVariables if v.derivative}
        assert found["joint.elbow.u"] == "joint.elbow.q"
        assert found["body.upper.alpha"] == "body.upper.omega"
        assert found["point.tip.vx"] == "point.tip.x"
        assert found["der(joint.elbow.u)"] == "joint.elbow.u"
        rates = [name for name in found if name.endswith("_rate")]
        assert len(found) == 2 + 2 * 6 + 4 + 4 + len(rates)

    def test_default_experiment(self, python_fmus: dict[str, Path], tmp_path: Path) -> None:
        program = autonomous()
        source = python_slave(program, describe(program, stop_time=3.5, step_size=0.25), "rk4")
        paths = (python_fmus["autonomous"], build_fmu(source, tmp_path / "long.fmu"))
        found = []
        for path in paths:
            description: Any = fmpy.read_model_description(str(path))
            experiment = description.defaultExperiment
            found.append((experiment.startTime, experiment.stopTime, experiment.stepSize))
        assert found == [("0.0", "10.0", "0.01"), ("0.0", "3.5", "0.25")]

    def test_capabilities(self, python_fmus: dict[str, Path]) -> None:
        description: Any = fmpy.read_model_description(str(python_fmus["autonomous"]))
        cosimulation = description.coSimulation
        assert cosimulation.canGetAndSetFMUstate
        assert cosimulation.canSerializeFMUstate
        assert cosimulation.canHandleVariableCommunicationStepSize
        assert cosimulation.needsExecutionTool
        assert not cosimulation.canBeInstantiatedOnlyOncePerProcess

    @pytest.mark.parametrize("name", ["double_pendulum", "floating_body", "algebraic", "tunable"])
    def test_declared_dependencies_are_those_measured(self, load_python: Load, name: str) -> None:
        """At a general state, an output moves with an input exactly if it says so."""
        instance = load_python(name)
        states = {v: 0.3 + 0.1 * k for k, v in enumerate(instance.reals("output", "local"))}
        inputs = {v: 0.7 + 0.2 * k for k, v in enumerate(instance.reals("input"))}
        instance.initialise({**states, **inputs})
        outputs = instance.reals("output")
        declared = {
            unknown.variable.name: {v.name for v in unknown.dependencies}
            for unknown in instance.description.outputs
        }
        assert set(declared) == set(outputs)
        before = instance.get(outputs)
        measured: dict[str, set[str]] = {output: set() for output in outputs}
        for moved, value in inputs.items():
            instance.set({moved: value + 1.0})
            after = instance.get(outputs)
            instance.set({moved: value})
            for output in outputs:
                if after[output] != before[output]:
                    measured[output].add(moved)
        assert measured == declared
        assert instance.get(outputs) == before

    @pytest.mark.parametrize("name", ["double_pendulum", "floating_body", "algebraic", "tunable"])
    def test_declared_initial_dependencies_are_those_measured(
        self, load_python: Load, name: str
    ) -> None:
        instance = load_python(name)
        known = {
            v.name: float(v.start) + 0.05 * (k + 1)
            for k, v in enumerate(instance.description.modelVariables)
            if v.start is not None
        }
        declared = {
            unknown.variable.name: {v.name for v in unknown.dependencies}
            for unknown in instance.description.initialUnknowns
        }
        exact = {v.name for v in instance.description.modelVariables if v.initial == "exact"}
        assert set(declared) == set(instance.reals("output", "calculatedParameter")) - exact
        instance.set(known)
        instance.fmu.setupExperiment(startTime=0.0)
        instance.fmu.enterInitializationMode()
        before = instance.get(declared)
        measured: dict[str, set[str]] = {unknown: set() for unknown in declared}
        for moved, value in known.items():
            instance.set({moved: value + 0.25})
            after = instance.get(declared)
            instance.set({moved: value})
            for unknown in declared:
                if after[unknown] != before[unknown]:
                    measured[unknown].add(moved)
        instance.fmu.exitInitializationMode()
        assert measured == declared
