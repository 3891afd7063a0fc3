"""Objects in notebooks: equations, figures, animations, datasets."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from support.html_pages import Page
from support.planar_trees import random_tree

import m4e_fmi as m4e
from m4e_fmi import cosim
from m4e_fmi.errors import InputError
from m4e_fmi.results.results_file import Results
from m4e_fmi.results.series import Recorded, Series

EXAMPLES = Path(__file__).parents[3] / "examples"
PENDULUM = EXAMPLES / "double_pendulum" / "double_pendulum.model.yaml"
SYSTEM = """\
name: coupled
description: A <b>bold</b> claim
components:
  one: {model: block.model.yaml}
  two: {model: block.model.yaml, start: {k: 30}}
connections:
  - one.body.block.x -> two.joint.rail.effort, units ignored
simulation: {stop_time: 0.2, step_size: 0.02}
"""
MODEL = """\
name: block
parameters: {k: {value: 20, unit: N/m, description: <i>stiff</i>}}
bodies: {block: {mass: 2, inertia: 1}}
joints: {rail: {type: prismatic, child: block, direction: [1, 0], initial: {q: 0.5}}}
points: {end: {body: block, at: [0, 0]}}
loads: {spring: {type: joint_effort, joint: rail, effort: -k*joint.rail.q}}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> cosim.Outcome:
    folder = tmp_path_factory.mktemp("run")
    (folder / "block.model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "s.system.yaml").write_text(SYSTEM, encoding="utf-8")
    system = cosim.load_system(folder / "s.system.yaml")
    prepared = cosim.prepare(system, build_directory=folder / "build")
    return cosim.run(prepared, results=folder / "s.nc")


def test_equations_are_latex_unless_they_are_long():
    assert m4e.Equations(random_tree(3, size=25))._repr_latex_() is None
    text = m4e.Equations(PENDULUM)._repr_latex_()
    assert text is not None
    assert r"& J + \frac{L^{2} \, m}{4} \end{bmatrix}" in text


def test_results_become_a_dataset_with_units(run):
    results = run.results()
    found = results.to_xarray()
    x = found["one.body.block.x"]
    assert (x.attrs["units"], x.dims) == ("m", ("time",))
    assert x.attrs["long_name"] == results["one.body.block.x"].long_name
    np.testing.assert_array_equal(x.values, results["one.body.block.x"].values)
    assert found["time"].attrs["units"] == "s"
    assert len(found.data_vars) == len(results.series)
    assert "scene" not in found.attrs
    assert found.attrs["title"] == "coupled"
    half = found.sel(time=slice(0.1, None))
    assert float(half["time"][0]) == pytest.approx(0.1)
    columns = {
        "mode": Series("", "", "", np.array([1, 2]), Recorded("Enumeration", "i4", {"on now": 2})),
        "open": Series("", "", "", np.array([True, False]), Recorded("Boolean", "i1")),
        "text": Series("", "", "", np.array(["a", "b"], object), Recorded("String", "str")),
    }
    odd = Results(Path("x.nc"), np.array([0.0, 1.0]), {"c": columns}, {})
    found = odd.to_xarray()
    assert found["c.mode"].attrs["flag_meanings"] == "on_now"
    assert found["c.open"].dtype == bool
    assert list(found["c.text"].values) == ["a", "b"]
    motion = m4e.simulate(PENDULUM, stop_time=0.1)
    dataset = motion.to_xarray()
    assert dataset["body.lower.z"].attrs["units"] == "m"
    assert set(dataset.data_vars) == set(motion.values)


def test_a_plot_is_a_figure_with_units(run):
    figure = run.results().plot("one.body.block.x", "two.joint.rail.u")
    assert [axis.get_ylabel() for axis in figure.axes] == ["[m]", "[m/s]"]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    assert figure._repr_png_().startswith(b"\x89PNG")
    motion = m4e.simulate(PENDULUM, stop_time=0.1)
    assert len(motion.plot().axes) > 1
    for one in (run.results(), motion):
        with pytest.raises(InputError, match="there is no variable 'z'"):
            one.plot("z")


def test_an_animation_is_shown_in_a_frame(run, tmp_path):
    made = run.results().animate()
    ((tag, given),) = Page(made._repr_html_()).tags
    assert tag == "iframe"
    assert given["srcdoc"] == made.save(tmp_path / "a.html").read_text("utf-8")
    assert "animation(" in str(given["srcdoc"])
    assert re.fullmatch(r"Animation of '.*s\.nc': \d+ kB of HTML", repr(made))
    with pytest.raises(InputError, match=r"use \.html"):
        made.save(tmp_path / "a.gif")


def test_a_simulation_of_a_model_is_animated(tmp_path):
    motion = m4e.simulate(PENDULUM, stop_time=0.1)
    path = m4e.report.animate(m4e.load_model(PENDULUM), motion, tmp_path / "a.html")
    assert motion.animate().page == path.read_text("utf-8")
    alone = m4e.simulate(m4e.model_program(PENDULUM), stop_time=0.1)
    with pytest.raises(InputError, match="no bodies to be shown"):
        alone.animate()


def test_a_figure_is_pickled(run):
    figure = pickle.loads(pickle.dumps(run.results().plot()))
    assert figure.axes[-1].get_xlabel() == "time [s]"
