"""Reprs of objects: some lines that say what they are. Names and units of results."""

from __future__ import annotations

import enum
import inspect
import pickle
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from support.planar_trees import random_tree

import m4e_fmi
from m4e_fmi import analysis, cosim, fmu, model, multibody, program
from m4e_fmi.errors import InputError, UnknownNameError
from m4e_fmi.files.document import Section
from m4e_fmi.fmu.export.from_program import python_slave
from m4e_fmi.fmu.export.options import Options
from m4e_fmi.model import Body, Joint, Model, load_model
from m4e_fmi.model.loads import LOAD_TYPES
from m4e_fmi.program import Program, Recorder, Tape, Variable
from m4e_fmi.results.series import Series
from m4e_fmi.simulate import Watch, simulate

EXAMPLES = Path(__file__).parents[2] / "examples"
SPIDERFLOAT = EXAMPLES / "paper_cases" / "spiderfloat.model.yaml"
SIMULATING = import_module("m4e_fmi.simulate")
PACKAGES = (model, multibody, program, SIMULATING, analysis, cosim, fmu)
WITHOUT_OBJECTS = {program.Solution, program.LocalLaw, program.ScalarLike, program.AnyScalar}
"""Protocols, and any type of scalar."""
MOST_LINES, MOST_CHARACTERS = 20, 2000

SYSTEM = """\
name: coupled
components:
  one: {model: block.model.yaml}
  two: {model: block.model.yaml}
connections:
  - one.body.block.x * -3.0 -> two.joint.rail.effort, units ignored
simulation: {stop_time: 0.2, step_size: 0.02}
"""
MODEL = """\
name: block
bodies: {block: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: block, direction: [1, 0], initial: {q: 0.5}}}
"""


def of_the_coupling(folder: Path) -> Iterator[Any]:
    """Objects of a run with two coupled FMUs."""
    (folder / "block.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "s.system.yaml").write_text(SYSTEM, encoding="utf-8")
    system = cosim.load_system(folder / "s.system.yaml")
    prepared = cosim.prepare(system, build_directory=folder / "build")
    yield from (system, prepared, *cosim.Timing)
    whole = cosim.system_program(system)
    yield from (whole, *whole.parts)
    yield from (program.Connection(("a", "y"), ("b", "u"), 2.0), program.Loop(("a.u",), (3,)))
    yield from (cosim.Bond("b", ()), cosim.BondEnergy("b", 1.0, 1.0, 1.0))
    yield from (cosim.Kind("sum", Section()), cosim.FmuFile(Path("x.fmu")))
    yield cosim.Action(at=1.0, offset={"a.y": 0.5})
    with cosim.start(prepared, results=folder / "s.nc") as run:
        yield from (run, run.step(), run.save(), run._master.network)
    yield from (run.outcome, run.outcome.results(), *prepared.descriptions.values())
    yield cosim.reference(run.outcome, whole)
    yield cosim.CouplingError("a -> b", cosim.Port("a", "y"), 0.1, 0.05, 2.0, "m")
    yield cosim.FmuMessage("one", "warning", "near its limit", 3, 0.1, 0.5)
    found = tuple(fmu.Finding(f"id.{k}", "error", "text " * 40) for k in range(100))
    yield from (fmu.Report(folder / "x.fmu", (fmu.Group("archive", found),)), Options())


def of_models() -> Iterator[Any]:
    """Objects that follow from a model of 40 bodies with all loads, and from a small one."""
    large = random_tree(3, size=25)
    yield from (large, multibody.Equations(large), multibody.topology(large))
    yield from (load for seed in range(8) for load in random_tree(seed, size=6).loads.values())
    yield model.Table(range(5000), range(5000))  # type: ignore[arg-type]
    yield from (model.Box(1, 1, 1), model.Cylinder(1, 1), model.Sphere(1))
    with TemporaryDirectory() as folder:
        (mesh := Path(folder, "a.obj")).write_text("v 0 0 0\nf 1 1 1\n" * 9, encoding="ascii")
        yield model.Mesh(mesh)
    small = load_model(SPIDERFLOAT)
    made = multibody.model_program(large)
    yield from (
        made,
        made.tape,
        program.jacobian(multibody.model_program(small)),
        Recorder("r", ""),
    )
    yield from (Tape().constant(1.0), made.states[0], Watch("x"))
    motion = simulate(small, stop_time=2.0, events=[Watch("body.float.vz")])
    yield from (motion, motion["body.float.z"], motion.time, motion.energy)
    linear = analysis.linearize(small, inputs=["k"])
    yield from (linear, analysis.Linearizer(small))
    yield analysis.frequency_response(linear, np.linspace(0.1, 1, 300))
    yield analysis.Sensitivities(small, of=["body.float.z"], by=["k"])
    yield analysis.sensitivity(small, of=["body.float.z"], by=["k"])
    yield analysis.eigenvalue_sensitivity(small, by=["k"])
    yield analysis.trajectory_sensitivity(small, of=["body.float.z"], by=["k"], stop_time=0.1)
    yield from (fmu.describe(made), python_slave(made, fmu.describe(made)))


def parts(found: Any, seen: set[int]) -> Iterator[Any]:
    """An object and what it holds, as far as dataclasses, mappings and sequences go."""
    if id(found) in seen:
        return
    seen.add(id(found))
    yield found
    inner: Any = ()
    if is_dataclass(found) and not isinstance(found, type):
        inner = [getattr(found, field.name) for field in fields(found)]
    elif isinstance(found, Mapping):
        inner = list(found.values())
    elif isinstance(found, list | tuple):
        inner = found[:50]
    for part in inner:
        yield from parts(part, seen)


def test_every_public_type_says_what_it_is_in_few_lines(tmp_path: Path) -> None:
    kinds = {getattr(p, name) for p in PACKAGES for name in p.__all__}
    kinds = {k for k in kinds if inspect.isclass(k)} - WITHOUT_OBJECTS
    kinds = {k for k in kinds if not issubclass(k, Exception)}
    seen: set[int] = set()
    kept = []  # so that no id is used twice
    found: dict[type, int] = dict.fromkeys(kinds, 0)
    for root in (*of_models(), *of_the_coupling(tmp_path)):
        kept.append(root)
        for one in parts(root, seen):
            if type(one) in kinds:
                found[type(one)] += 1
                text = repr(one)
                assert len(text.splitlines()) <= MOST_LINES, text
                assert len(text) <= MOST_CHARACTERS, text[:200]
                assert " object at 0x" not in text, text
                name = type(one).__name__
                assert isinstance(one, enum.Enum | Series | program.Scalar) or name in text
    assert {kind.__name__ for kind, count in found.items() if not count} == set()
    assert set(LOAD_TYPES.values()) <= kinds


def test_a_series_is_an_array_that_knows_its_name_and_unit() -> None:
    run = simulate(SPIDERFLOAT, stop_time=1.0)
    heave = run["body.float.z"]
    assert (heave.name, heave.unit) == ("body.float.z", "m")
    assert heave.long_name == "Coordinate Z_1 of body float"
    assert run.time.unit == "s"
    assert repr(heave).startswith("body.float.z [m]: 101 values")
    for kept in (heave[10:], heave.copy(), pickle.loads(pickle.dumps(heave))):
        assert (kept.name, kept.unit) == ("body.float.z", "m")
    for other in (
        2 * heave,
        heave**2,
        np.diff(heave),
        np.gradient(heave),
        np.column_stack([heave]),
    ):
        assert type(other) is np.ndarray
    assert isinstance(heave[0], float)
    assert isinstance(heave.max(), float)
    np.testing.assert_array_equal(heave.values, np.asarray(heave))
    total = np.zeros(101)
    total += heave
    np.testing.assert_array_equal(total, heave)


def test_matplotlib_draws_a_series() -> None:
    from matplotlib.figure import Figure

    run = simulate(SPIDERFLOAT, stop_time=1.0)
    (line,) = Figure().subplots().plot(run.time, run["body.float.z"])
    np.testing.assert_array_equal(line.get_ydata(), run["body.float.z"].values)


def wrong_names(folder: Path) -> Iterator[Any]:
    """Things to look names up in, and a name that is nearly there."""
    run = simulate(SPIDERFLOAT, stop_time=0.1)
    yield from ((run, "body.float.zz"), (run.values, "body.float.zz"))
    point = analysis.linearize(load_model(SPIDERFLOAT)).point
    yield point, "body.float.zz"
    (folder / "block.model.yaml").write_text(MODEL, encoding="utf-8")
    text = "name: s\ncomponents: {one: {model: block.model.yaml}}\nconnections: []\n"
    text += "simulation: {stop_time: 0.1, step_size: 0.02}\n"
    (folder / "s.system.yaml").write_text(text, encoding="utf-8")
    with cosim.start(cosim.load_system(folder / "s.system.yaml"), results=folder / "s.nc",
                     build_directory=folder / "build") as execution:  # fmt: skip
        yield from ((execution, "one.body.blok.x"), (execution.point, "one.body.blok.x"))
        with pytest.raises(KeyError, match=r"did you mean 'one\.body\.block\.x'"):
            execution._master.network.read("one.body.blok.x")
    loaded = execution.outcome.results()
    yield from ((loaded, "one.body.blok.x"), (loaded.series, "one.body.blok.x"))
    yield from ((loaded.components, "on"), (loaded.components["one"], "body.blok.x"))


def test_a_misspelt_name_is_told_with_the_nearest(tmp_path: Path) -> None:
    for where, name in wrong_names(tmp_path):
        with pytest.raises(UnknownNameError, match="did you mean '") as caught:
            where[name]
        assert isinstance(caught.value, KeyError)
        assert isinstance(caught.value, InputError)
        assert name in str(caught.value)
        assert not str(caught.value).startswith(("'", '"'))


def test_programs_tell_unknown_names_with_the_nearest() -> None:
    made = multibody.model_program(SPIDERFLOAT)
    attempts = (
        lambda: made.with_start({"kk": 1.0}),
        lambda: program.jacobian(made, by=["kk"]),
        lambda: program.with_feedback(made, {"body.float.force_y": lambda _: 0.0}),
        lambda: program.with_feedback(made, {"body.float.force_z": lambda x: x["body.float.vv"]}),
        lambda: simulate(made, stop_time=1.0, start_values={"kk": 1.0}),
    )
    for attempt in attempts:
        with pytest.raises(KeyError, match="did you mean"):
            attempt()


def test_the_package_has_the_verbs() -> None:
    for name in m4e_fmi.__all__:
        assert callable(getattr(m4e_fmi, name)), name
        assert name in dir(m4e_fmi)
    assert m4e_fmi.linearize is analysis.linearize
    alone = Model("a", {"b": Body(1.0, 1.0)}, {"j": Joint("revolute", "b")})
    assert m4e_fmi.simulate(alone, stop_time=0.1).time[-1] == 0.1
    assert SIMULATING(alone, stop_time=0.1).time[-1] == 0.1  # type: ignore[operator]
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        m4e_fmi.simulat  # noqa: B018


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import m4e_fmi, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.splitlines()[0].split()
    assert not {"numpy", "sympy", "pydantic", "netCDF4", "fmpy", "m4e_fmi.model"} & set(loaded)


def test_a_program_of_many_variables_is_shown_in_few_lines() -> None:
    recorder = Recorder("r", "")
    for k in range(500):
        recorder.rate(f"x{k}", recorder.state(Variable(f"x{k}", "m", "position")))
    text = repr(recorder.program())
    assert isinstance(recorder.program(), Program)
    assert text.count("\n") < 5
    assert "states (500): x0, x1" in text
