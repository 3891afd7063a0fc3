"""FMUs of FMI 1.0, 2.0 and 3.0 in one system: the same results as with FMI 2.0 alone."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from support.small_systems import Fmus, observed, system, watched
from support.two_masses import EXACT, STATES, errors, orders, two_masses

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, run
from m4e_fmi.fmu import build_fmu
from m4e_fmi.multibody import model_program

EVERY = ["jacobi", "gauss_seidel", "implicit", "corrector"]


@pytest.mark.verifies(
    "two-mass oscillator of an FMI 3.0 FMU and one of FMI 2.0 or 3.0",
    independent="the same of two FMI 2.0 FMUs",
    tolerance="identical",
)
@pytest.mark.parametrize("versions", ["33", "32", "23"])
@pytest.mark.parametrize("algorithm", EVERY)
@pytest.mark.usefixtures("loop")
def test_fmi_3_gives_the_bits_of_fmi_2(c_fmu: Fmus, versions: str, algorithm: str) -> None:
    prefix = {"2": "", "3": "3:"}
    a, b = (prefix[v] + m for v, m in zip(versions, ("mass+state", "partner+state"), strict=True))
    pairs = (two_masses(c_fmu, *names) for names in ((), (a, b)))
    (expected, _), (found, outcome) = (
        observed(pair.changed(stop_time=3.0, algorithm=algorithm), *STATES) for pair in pairs
    )
    assert found == expected
    assert not isinstance(outcome.certificate, str)


@pytest.mark.verifies(
    "two-mass oscillator with an FMI 3.0 FMU, corrector",
    analytic="matrix exponential",
    tolerance="3e-4",
)
def test_the_order_of_the_corrector_with_fmi_3(c_fmu: Fmus) -> None:
    pair = two_masses(c_fmu, "3:mass+state", "3:partner+state")
    found = errors(pair, EXACT, (0.2, 0.1))
    assert found[1] < 3e-4
    assert orders(found).min() > 2.9


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
@pytest.mark.usefixtures("loop")
def test_fmi_1_is_of_second_order(c_fmu: Fmus, pair: tuple[str, str]) -> None:
    coupled = two_masses(c_fmu, *pair)
    assert orders(errors(coupled, EXACT, (0.1, 0.05))).min() > 1.9
    outcome = run(coupled)
    assert outcome.order == 2
    assert any("cannot" in note or "roll back" in note for note in outcome.notes)


@pytest.mark.verifies(
    "two-mass oscillator of FMI 1.0 FMUs under Jacobi",
    independent="the same of FMI 2.0 FMUs",
    tolerance="identical",
)
def test_fmi_1_gives_the_bits_of_fmi_2_under_jacobi(c_fmu: Fmus) -> None:
    expected, found = (
        watched(two_masses(c_fmu, *names).changed(stop_time=3.0, algorithm="jacobi"), *STATES)
        for names in (("mass", "partner"), ("1:mass", "1:partner"))
    )
    assert found == expected


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
    """A mass that floats freely, as native FMUs of FMI 2.0 and 3.0."""
    folder = tmp_path_factory.mktemp("sliders")
    path = folder / "slider.model.yaml"
    path.write_text(MODEL, encoding="utf-8")
    program = model_program(path)
    return {v: build_fmu(program, folder / f"slider{v}.fmu", native=True, fmi=v) for v in "23"}


@pytest.mark.verifies(
    "native FMI 3.0 FMU in a system written for its FMI 2.0 twin",
    independent="the FMI 2.0 twin",
    tolerance="1e-6",
)
@pytest.mark.parametrize("algorithm", EVERY)
@pytest.mark.usefixtures("loop")
def test_a_system_does_not_change_when_a_component_is_rebuilt_as_fmi_3(
    c_fmu: Fmus, sliders: dict[str, Path], algorithm: str
) -> None:
    found = {}
    for version, slider in sliders.items():
        parts = (Component("a", FmuFile(slider)), Component("b", FmuFile(c_fmu("partner+state"))))
        settings = Simulation(3.0, 0.05, algorithm)
        pair = System("pair", parts, ("a.m <-> b.end",), settings)
        found[version] = np.array(watched(pair, *STATES))
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
    alone = system(c_fmu, {"a": name}, start={"a": start}, simulation=Simulation(1.0, 0.125))
    found = np.ravel(watched(alone, "a.body.m.x"))
    expected = fmpy.simulate_fmu(
        c_fmu(name),
        start_values=start,
        output=["body.m.x"],
        stop_time=1.0,
        step_size=0.125,
        output_interval=0.125,
    )
    np.testing.assert_array_equal(found, expected["body.m.x"])
