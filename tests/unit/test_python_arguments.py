"""Arguments from Python of a wrong kind are told; numbers and arrays of NumPy are taken."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import m4e_fmi
from m4e_fmi import (
    InputError,
    build_fmu,
    load,
    load_model,
    load_system,
    model_program,
    modes,
    simulate,
)
from m4e_fmi.cosim import FmuFile, ModelFile, Simulation, System
from m4e_fmi.fmu import read_description
from m4e_fmi.model import Body, Joint, Model, Point
from m4e_fmi.report import animate, draw_model, plot_simulation, write_simulation
from m4e_fmi.results.results_file import load_results
from m4e_fmi.simulate import Watch

SYSTEM = System("s", (), (), Simulation(1.0, 0.1))
PENDULUM = Model(
    "pendulum",
    bodies={"rod": Body(2.0, 1.0)},
    joints={"pin": Joint("revolute", "rod", joint_to_child=(0.0, -1.0))},
    points={"tip": Point("rod", (0.0, -1.0))},
)
SWING = partial(simulate, PENDULUM, stop_time=1.0)
MISTAKES: tuple[tuple[Callable[..., Any], dict, str, str], ...] = (
    (SYSTEM.changed, {"stepsize": 0.1}, "unknown setting 'stepsize'", "'step_size'"),
    (SYSTEM.changed, {"step_size": np.array([0.1])}, "step_size: expected a number", "10 ms"),
    (SYSTEM.changed, {"step_size": "5 cm"}, "is not a valid duration", "10 ms"),
    (SYSTEM.changed, {"tolerance": "small"}, "tolerance: expected a number", "1e-6"),
    (SYSTEM.changed, {"start": [("a.b", 3)]}, "values by name, got list", "start={"),
    (SYSTEM.changed, {"start": {5: 3}}, "expected COMPONENT.VARIABLE", ""),
    (load_system, {"path": 3}, "path of a file, got int", "name"),
    (load_model, {"path": None}, "path of a file, got NoneType", "name"),
    (load, {"path": 3}, "path of a file, got int", "name"),
    (modes, {"linear": PENDULUM}, "expected a Linearization, got Model", "linearize(model)"),
    (simulate, {"system": PENDULUM, "stop_time": "1 s"}, "stop time must be a number", "seconds"),
    (SYSTEM.changed, {"stop_time": 1e9, "step_size": 0.01}, "at most", "shorter run"),
    (simulate, {"system": PENDULUM, "stop_time": 1e300}, "up to 4e+09", "shorten"),
    (SWING, {"output_interval": 1e-9}, "at most", "take 1e-08 s"),
    (SWING, {"method": "rk4", "step_size": 0.0}, "step size must be positive", ""),
    (SWING, {"method": "rk45", "step_size": 0.1}, "rk45 chooses its steps", ""),
    (SWING, {"method": "dop854"}, "dop854", "did you mean 'dop853'"),
    (SWING, {"start_values": {"joint.pin.qq": 1.0}}, "joint.pin.qq", "did you mean"),
    (SWING, {"events": [Watch("joint.pin.qq")]}, "joint.pin.qq", "did you mean"),
    (
        Model,
        {"name": "m", "bodies": [Body(1, 1)], "joints": []},
        "bodies: expected elements by name, got list",
        "bodies={",
    ),
)


@pytest.mark.parametrize(("call", "given", "message", "remedy"), MISTAKES)
def test_a_wrong_kind_of_argument(
    call: Callable[..., Any], given: dict, message: str, remedy: str
) -> None:
    with pytest.raises(InputError) as caught:
        call(**given)
    assert message in caught.value.problems[0].message
    assert remedy in caught.value.problems[0].remedy


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"outputs": "body.*"}, "expected a list"),
        ({"method": 3}, "there is no method 3"),
        ({"fmi": 4}, "there is no FMI version '4'"),
        ({"stop_time": "1 s"}, "the stop time must be positive, got '1 s'"),
    ],
)
def test_options_of_an_fmu(option: dict, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        build_fmu(model_program(PENDULUM), tmp_path / "a.fmu", **option)


def test_the_version_of_fmi_may_be_a_number(tmp_path: Path) -> None:
    path = build_fmu(model_program(PENDULUM), tmp_path / "a.fmu", native=True, fmi=3)
    assert read_description(path).version == "3.0"


def test_settings_are_numbers_of_any_library_or_texts_with_a_unit() -> None:
    changed = SYSTEM.changed(step_size="50 ms", stop_time=np.array(2), tolerance=np.float32(0.5))
    assert changed.simulation == Simulation(2.0, 0.05, tolerance=0.5)
    assert type(changed.simulation.stop_time) is float


def test_arrays_of_numpy_in_a_model() -> None:
    mass: Any = np.array(2.0)
    inertia: Any = np.float32(1.0)
    end: Any = np.array([0, -1])
    model = Model(
        "pendulum",
        bodies={"rod": Body(mass, inertia)},
        joints={"pin": Joint("revolute", "rod", joint_to_child=end)},
        points={"tip": Point("rod", end)},
    )
    assert model_program(model) == model_program(PENDULUM)


@pytest.mark.parametrize("name", ["simulate", "run", "study", "linearize", "equilibrium"])
def test_verbs_have_the_signature_of_their_function(name: str) -> None:
    first = next(iter(inspect.signature(getattr(m4e_fmi, name)).parameters))
    assert first == ("given" if name == "study" else "system")


def test_paths_of_reports_may_be_texts(tmp_path: Path) -> None:
    motion = simulate(PENDULUM, stop_time=0.1)
    made = [
        animate(PENDULUM, motion, f"{tmp_path}/a.html"),
        plot_simulation(motion, f"{tmp_path}/a.svg"),
        draw_model(PENDULUM, f"{tmp_path}/b.svg"),
        *write_simulation(motion, f"{tmp_path}/a.nc"),
    ]
    assert all(isinstance(path, Path) and path.is_file() for path in made)


def test_results_of_studies_are_loaded_as_datasets(tmp_path: Path) -> None:
    xarray.Dataset({"y": 2.0}, attrs={"study": "name: s"}).to_netcdf(tmp_path / "s.nc")
    found = load(tmp_path / "s.nc")
    assert isinstance(found, xarray.Dataset)
    assert found["y"] == 2.0
    with pytest.raises(InputError, match=r"result of a study: `m4e_fmi\.load` reads it"):
        load_results(tmp_path / "s.nc")


def test_paths_of_components_may_be_texts() -> None:
    folder: Any = "somewhere"
    assert FmuFile(folder).path == ModelFile(folder).path == Path("somewhere")
    assert replace(SYSTEM, folder=folder).folder == Path("somewhere")
    with pytest.raises(InputError, match="path of a file, got int"):
        FmuFile(3)  # pyrefly: ignore[bad-argument-type]


MADE = {"FmuFile", "ModelFile", "System"}
MADE |= {"Comparison", "Outcome", "Results", "Description", "Report", "StudyOutcome"}
"""Classes that make a Path of a text, and those whose objects are results."""


@pytest.mark.parametrize("package", ["", ".cosim", ".fmu", ".model", ".report", ".simulate"])
def test_what_takes_a_path_takes_a_text(package: str) -> None:
    module = importlib.import_module(f"m4e_fmi{package}")
    found = [getattr(module, name) for name in module.__all__ if name not in MADE]
    found += [f for one in found if inspect.isclass(one) for f in vars(one).values()]
    for one in (one for one in found if inspect.isfunction(one)):
        for parameter in inspect.signature(one).parameters.values():
            annotation = str(parameter.annotation)
            assert "Path" not in annotation or "str" in annotation, (one, parameter)


@pytest.mark.parametrize("name", ["simulate", "study"])
def test_help_on_verbs_that_are_packages(name: str) -> None:
    found = inspect.getdoc(getattr(m4e_fmi, name))
    assert found == inspect.getdoc(getattr(m4e_fmi, name).__call__)
