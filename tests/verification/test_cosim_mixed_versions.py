"""FMUs of FMI 1.0, 2.0 and 3.0 in one system: the same results as with FMI 2.0 alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program

Fmus = Callable[[str], Path]
PAIR = ("a.m <-> b.end",)
EXACT = np.array([-0.39866759, 1.13728136, -0.44040394, -0.59326024])
"""x1, v1, x2, v2 after 10 s of the undamped oscillator: matrix exponential, 8 digits."""
WATCHED = ("a.body.m.x", "a.body.m.vx", "b.x", "b.vx")


def without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("m4e_fmi.cosim.exchange.step_loop.library", lambda: None)


def oscillator(
    first: Path, second: Path, algorithm: str, size: float = 0.1, stop: float = 10.0
) -> tuple[np.ndarray, Outcome]:
    """x1, v1, x2, v2 at all points."""
    parts = (
        Component("a", FmuFile(first), {"stiffness": 1.0, "body.m.x": 1.0}),
        Component("b", FmuFile(second)),
    )
    found: list[list[float]] = []

    def observe(_: float, network: Network) -> None:
        found.append([network.read(name) for name in WATCHED])

    system = System("pair", parts, PAIR, Simulation(stop, size, algorithm))
    outcome = run(system, observers=[observe])
    return np.array(found), outcome


@pytest.mark.verifies(
    "two-mass oscillator of an FMI 3.0 FMU and one of FMI 2.0 or 3.0",
    independent="the same of two FMI 2.0 FMUs",
    tolerance="identical",
)
@pytest.mark.parametrize("versions", ["33", "32", "23"])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "implicit", "corrector"])
@pytest.mark.parametrize("by_python", [False, True])
def test_fmi_3_gives_the_bits_of_fmi_2(
    c_fmu: Fmus,
    monkeypatch: pytest.MonkeyPatch,
    versions: str,
    algorithm: str,
    by_python: bool,
) -> None:
    if by_python:
        without_the_library(monkeypatch)
    prefix = {"2": "", "3": "3:"}
    a, b = (prefix[v] + m for v, m in zip(versions, ("mass+state", "partner+state"), strict=True))
    expected, _ = oscillator(c_fmu("mass+state"), c_fmu("partner+state"), algorithm, stop=3.0)
    found, outcome = oscillator(c_fmu(a), c_fmu(b), algorithm, stop=3.0)
    np.testing.assert_array_equal(found, expected)
    assert not isinstance(outcome.certificate, str)


@pytest.mark.verifies(
    "two-mass oscillator with an FMI 3.0 FMU, corrector",
    analytic="matrix exponential",
    tolerance="3e-4",
)
def test_the_order_of_the_corrector_with_fmi_3(c_fmu: Fmus) -> None:
    pair = c_fmu("3:mass+state"), c_fmu("3:partner+state")
    errors = [
        np.abs(oscillator(*pair, "corrector", size)[0][-1] - EXACT).max() for size in (0.2, 0.1)
    ]
    assert errors[1] < 3e-4
    assert np.log2(errors[0] / errors[1]) > 2.9


@pytest.mark.verifies(
    "two-mass oscillator with FMUs of FMI 1.0, which step once",
    analytic="matrix exponential",
    tolerance="1.9 (observed order)",
)
@pytest.mark.parametrize(
    "pair",
    [
        ("1:mass", "1:partner"),
        ("1:mass", "partner+state"),
        ("3:mass+state", "1:partner+inputs"),
    ],
)
@pytest.mark.parametrize("by_python", [False, True])
def test_fmi_1_is_of_second_order(
    c_fmu: Fmus, monkeypatch: pytest.MonkeyPatch, pair: tuple[str, str], by_python: bool
) -> None:
    if by_python:
        without_the_library(monkeypatch)
    a, b = map(c_fmu, pair)
    found = [oscillator(a, b, "corrector", size) for size in (0.1, 0.05)]
    errors = [np.abs(points[-1] - EXACT).max() for points, _ in found]
    assert np.log2(errors[0] / errors[1]) > 1.9
    outcome = found[0][1]
    assert outcome.order == 2
    assert any("cannot" in note or "roll back" in note for note in outcome.notes)


@pytest.mark.verifies(
    "two-mass oscillator of FMI 1.0 FMUs under Jacobi",
    independent="the same of FMI 2.0 FMUs",
    tolerance="identical",
)
def test_fmi_1_gives_the_bits_of_fmi_2_under_jacobi(c_fmu: Fmus) -> None:
    expected, _ = oscillator(c_fmu("mass"), c_fmu("partner"), "jacobi", stop=3.0)
    found, _ = oscillator(c_fmu("1:mass"), c_fmu("1:partner"), "jacobi", stop=3.0)
    np.testing.assert_array_equal(found, expected)


MODEL = """\
name: slider
gravity: 0
parameters:
  m: {value: 1, unit: kg, description: Mass}
bodies:
  m: {mass: m, inertia: 1}
joints:
  free: {type: floating, child: m, initial: {x: 1}}
"""


@pytest.fixture(scope="module")
def sliders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A mass that floats freely, as native FMUs of FMI 2.0 and 3.0, where vectors are arrays."""
    folder = tmp_path_factory.mktemp("sliders")
    path = folder / "slider.model.yaml"
    path.write_text(MODEL, encoding="utf-8")
    program = model_program(path)
    return {v: build_fmu(program, folder / f"slider{v}.fmu", native=True, fmi=v) for v in "23"}


@pytest.mark.verifies(
    "native FMI 3.0 FMU with arrays in a system written for its FMI 2.0 twin",
    independent="the FMI 2.0 twin",
    tolerance="1e-6",
)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss_seidel", "implicit", "corrector"])
@pytest.mark.parametrize("by_python", [False, True])
def test_a_system_does_not_change_when_a_component_is_rebuilt_as_fmi_3(
    c_fmu: Fmus,
    sliders: dict[str, Path],
    monkeypatch: pytest.MonkeyPatch,
    algorithm: str,
    by_python: bool,
) -> None:
    if by_python:
        without_the_library(monkeypatch)
    found = {}
    for version, slider in sliders.items():
        parts = (Component("a", FmuFile(slider)), Component("b", FmuFile(c_fmu("partner+state"))))
        points: list[list[float]] = []

        def observe(_: float, network: Network, points: list[list[float]] = points) -> None:
            points.append([network.read(name) for name in WATCHED])

        settings = Simulation(3.0, 0.05, algorithm)
        run(System("pair", parts, PAIR, settings), observers=[observe])
        found[version] = np.array(points)
    assert np.abs(found["2"][-1] - found["2"][0]).max() > 0.1
    if algorithm in ("jacobi", "gauss_seidel"):
        np.testing.assert_array_equal(found["3"], found["2"])
    elif algorithm == "corrector":
        # both are of third order or better: their errors at this step are below 1e-6
        np.testing.assert_allclose(found["3"], found["2"], rtol=0, atol=1e-6)
    else:
        # lines that are followed, and held values of the same means: second order both, (H/2)^2
        np.testing.assert_allclose(found["3"], found["2"], rtol=0, atol=0.05**2 / 4)


@pytest.mark.verifies(
    "FMUs of FMI 1.0 and 3.0 alone",
    independent="FMPy's simulate_fmu",
    tolerance="identical",
)
@pytest.mark.parametrize("name", ["1:mass", "3:mass+state", "mass"])
def test_what_fmpy_makes_of_the_same_fmu(c_fmu: Fmus, name: str) -> None:
    start = {"stiffness": 2.0, "body.m.x": 0.5}
    system = System("s", (Component("a", FmuFile(c_fmu(name)), start),), (), Simulation(1.0, 0.125))
    found: list[float] = []
    run(system, observers=[lambda _, network: found.append(network.read("a.body.m.x"))])
    expected = fmpy.simulate_fmu(
        c_fmu(name),
        start_values=start,
        output=["body.m.x"],
        stop_time=1.0,
        step_size=0.125,
        output_interval=0.125,
    )
    np.testing.assert_array_equal(found, expected["body.m.x"])
