"""Reprs of objects: some lines that say what they are. Names and units of results."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.planar_trees import random_tree

import m4e_fmi
from m4e_fmi import analysis, cosim, fmu, model, multibody, program
from m4e_fmi.errors import InputError, UnknownNameError
from m4e_fmi.model import Body, Joint, Model, load_model
from m4e_fmi.results.series import Series
from m4e_fmi.simulate import Watch, simulate

EXAMPLES = Path(__file__).parents[2] / "examples"
SPIDERFLOAT = EXAMPLES / "paper_cases" / "spiderfloat.model.yaml"
SIMULATING = import_module("m4e_fmi.simulate")
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


def objects(folder: Path) -> Iterator[Any]:
    """What people print: models, motions, analyses, a coupled run; some of them large."""
    large = random_tree(3, size=25)
    made = multibody.model_program(large)
    yield from (large, multibody.Equations(large), multibody.topology(large), made, made.tape)
    yield from (*large.loads.values(), model.Table(range(5000), range(5000)))
    small = load_model(SPIDERFLOAT)
    motion = simulate(small, stop_time=2.0, events=[Watch("body.float.vz")])
    yield from (motion, motion["body.float.z"], motion.time, motion.energy)
    linear = analysis.linearize(small, inputs=["k"])
    yield from (linear, analysis.frequency_response(linear, np.linspace(0.1, 1, 300)))
    yield analysis.sensitivity(small, of=["body.float.z"], by=["k"])
    found = tuple(fmu.Finding(f"id.{k}", "error", "text " * 40) for k in range(100))
    yield from (fmu.describe(made), fmu.Report(folder / "x.fmu", (fmu.Group("archive", found),)))
    (folder / "block.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "s.system.yaml").write_text(SYSTEM, encoding="utf-8")
    system = cosim.load_system(folder / "s.system.yaml")
    prepared = cosim.prepare(system, build_directory=folder / "build")
    yield from (system, prepared, cosim.system_program(system))
    with cosim.start(prepared, results=folder / "s.nc") as run:
        yield from (run, run.step())
    yield from (run.outcome, run.outcome.results(), *prepared.descriptions.values())


def test_what_people_print_says_what_it_is_in_few_lines(tmp_path: Path) -> None:
    for one in objects(tmp_path):
        text = repr(one)
        assert len(text.splitlines()) <= MOST_LINES, text
        assert len(text) <= MOST_CHARACTERS, text[:200]
        assert " object at 0x" not in text, text
        assert isinstance(one, Series) or type(one).__name__ in text


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
            execution._run.network.read("one.body.blok.x")
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
    assert SIMULATING(alone, stop_time=0.1).time[-1] == 0.1  # pyrefly: ignore[not-callable]
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        m4e_fmi.simulat  # noqa: B018


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import m4e_fmi, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.splitlines()[0].split()
    assert not {"numpy", "sympy", "pydantic", "netCDF4", "fmpy", "m4e_fmi.model"} & set(loaded)
