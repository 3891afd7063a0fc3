"""Our FMUs in other tools, each as its page in docs/importers shows: the page's code is what runs.

A tool that is not installed is skipped: `pip install .[importers]` brings those that are packages.
"""

from __future__ import annotations

import importlib
import math
import os
import sys
import sysconfig
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from doc_tools.run_page import run_page
from support.chains import sprung_chain
from support.crane import crane

from m4e_fmi.analysis import linearize
from m4e_fmi.cosim import Component, FmuFile, Network, Simulation, System
from m4e_fmi.cosim import run as run_system
from m4e_fmi.fmu import build_fmu
from m4e_fmi.model import Model, load_model
from m4e_fmi.multibody import model_program
from m4e_fmi.simulate import simulate

ROOT = Path(__file__).parents[2]
STOP, STEP = 2.0, 0.01
TOLERANCE = 1e-8
# each step of an integrator may be off by TOLERANCE (nominal + |x|), where nominal is 1 but for
# FMPy's CVODE, which takes the FMU's: 10 rad/s; neither motion amplifies that much
CO_SIMULATION = TOLERANCE * STOP / STEP  # one step of DOP853 for each communication step
CVODE = TOLERANCE * 3000  # steps that CVODE and IDA take at most: counted once, up to 2,600
MODELS: dict[str, tuple[Callable[[], Model], dict[str, float]]] = {
    "chain": (lambda: sprung_chain(3), {"joint.j0.effort": 3.0, "joint.j2.effort": -0.5}),
    "double_pendulum": (
        lambda: load_model(ROOT / "examples/double_pendulum/double_pendulum.model.yaml"),
        {"k": 40.0, "joint.elbow.effort": 2.0},
    ),
    "crane": (crane, {"joint.swing.effort": 1.0, "body.hull.force_y": 0.5}),
}
MODULES = {
    "libcosimpy": "libcosimpy",
    "ecospy": "ecospy",
    "casadi": "casadi",
    "fmu_toolbox": "fmu_manipulation_toolbox",
}
CO_SIMULATING = ["fmpy", "libcosimpy", "ecospy", "fmu_toolbox", "c_host"]


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, bool], str]:
    """`fmus(model, native)` is the path of an FMU."""
    folder = tmp_path_factory.mktemp("fmus")

    @cache
    def build(model: str, native: bool) -> str:
        program = model_program(MODELS[model][0]())
        return str(build_fmu(program, folder / f"{model}_{native}.fmu", native=native))

    return build


@pytest.fixture(scope="module")
def expected() -> Callable[[str], dict[str, float]]:
    """`expected(model)`: the states at STOP, by name, as `simulate` has them to 1e-12."""

    @cache
    def states(model: str) -> dict[str, float]:
        make, start = MODELS[model]
        found = simulate(
            make(), stop_time=STOP, output_interval=STOP, tolerance=1e-12, start_values=start
        )
        names = [v.name for v in found.program.states]
        return {name: float(found[name][-1]) for name in names}

    return states


@pytest.fixture(scope="module")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, Any]]:
    """`tool(name)`: what the page of that name defines, once it has run as it says."""

    @cache
    def page(name: str) -> dict[str, Any]:
        if name in MODULES:
            _installed(name)
        folder = tmp_path_factory.mktemp(name) / "page"
        return run_page(ROOT / "docs" / "importers" / f"{name}.md", folder)

    return page


def _installed(page: str) -> None:
    try:
        importlib.import_module(MODULES[page])
    except (ImportError, OSError) as error:  # OSError: a library that the module needs
        pytest.skip(f"{error}; see docs/importers/{page}.md")


def agrees(
    found: list[float], expected: dict[str, float], limit: float, nominal: float = 1.0
) -> None:
    for value, (name, true) in zip(found, expected.items(), strict=True):
        assert math.isclose(value, true, abs_tol=limit * (nominal + abs(true)), rel_tol=0), name


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("name", CO_SIMULATING)
def test_co_simulation(name: str, model: str, tool: Any, fmus: Any, expected: Any) -> None:
    run, start = tool(name)["run"], MODELS[model][1]
    native = run(fmus(model, True), start, list(expected(model)), STOP, STEP)
    agrees(native, expected(model), CO_SIMULATION)
    if name != "c_host":  # a host without Python
        python = run(fmus(model, False), start, list(expected(model)), STOP, STEP)
        assert python == native
    else:  # the others round times differently, and so the lengths of their steps
        assert native == ours(fmus(model, True), start, list(expected(model)))


def test_python_in_a_c_host(tool: Any, fmus: Any, expected: Any) -> None:
    """As the page says: libpython preloaded, and its python3 first on the path."""
    folder, name = sysconfig.get_config_vars("LIBDIR", "INSTSONAME")
    library = Path(folder) / name
    if ".so" not in name or not library.exists():
        pytest.skip("this Python has no shared library")
    environment = {
        "LD_PRELOAD": str(library),
        "PATH": f"{sys.base_prefix}/bin:{os.environ['PATH']}",
    }
    run, start, names = tool("c_host")["run"], MODELS["chain"][1], list(expected("chain"))
    native = run(fmus("chain", True), start, names, STOP, STEP)
    assert run(fmus("chain", False), start, names, STOP, STEP, environment) == native
    with pytest.raises(RuntimeError, match=r"undefined symbol: _?Py"):
        run(fmus("chain", False), start, names, STOP, STEP)


def ours(fmu: str, start: dict[str, float], names: list[str]) -> list[float]:
    """The same by our own master."""
    part = Component("model", FmuFile(Path(fmu)), start)
    last: dict[str, float] = {}

    def observe(_: float, network: Network) -> None:
        last.update({name: network.read(f"model.{name}") for name in names})

    run_system(System("one", (part,), (), Simulation(STOP, STEP)), observers=[observe])
    return list(last.values())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(
    ("name", "solver", "nominal"),
    [("fmpy", "ModelExchange", 10.0), ("casadi", "cvodes", 1.0), ("casadi", "idas", 1.0)],
)
def test_model_exchange(
    name: str, solver: str, nominal: float, model: str, tool: Any, fmus: Any, expected: Any
) -> None:
    run, start = tool(name)["run"], MODELS[model][1]
    found = run(fmus(model, True), start, list(expected(model)), STOP, STEP, solver)
    agrees(found, expected(model), CVODE, nominal)


@pytest.mark.parametrize("model", ["chain", "double_pendulum"])
def test_jacobian_in_casadi(model: str, tool: Any, fmus: Any) -> None:
    """Exact, so from the FMU's derivatives: differences would be off by 1e-8 and more.

    Of models whose states `linearize` has, too: free attitudes have three numbers there.
    """
    make, start = MODELS[model]
    dae = tool("casadi")["imported"](fmus(model, True), start)
    jacobian = dae.create("jacobian", ["x", "u"], ["jac_ode_x"])
    found = np.array(jacobian(dae.get(dae.x()), dae.get(dae.u())))
    exact = linearize(make(), at=start)
    order = [dae.x().index(v.name) for v in exact.states]
    limit = 1e-12 * np.abs(exact.A).max()
    np.testing.assert_allclose(found[np.ix_(order, order)], exact.A, rtol=0, atol=limit)
