"""Time tables that jump: steps meet the jumps, and coupling keeps its order across them.

Two masses of 1 kg with springs of 1 N/m to the walls and between them; a square wave of 1 N, whose
half period is no multiple of any step, drives the first.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from support.small_systems import Fmus, observed
from support.two_masses import STATES

from m4e_fmi.cosim import Component, FmuFile, Outcome, Simulation, System
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program
from m4e_fmus import sum as sum_kind
from m4e_fmus import table

STOP, HALF_PERIOD = 4.0, 0.7071
JUMPS = [round(k * HALF_PERIOD, 9) for k in range(1, 6)]
RATES = np.array([[0, 1, 0, 0, 0], [-2, 0, 1, 0, 1], [0, 0, 0, 1, 0], [1, 0, -2, 0, 0], [0] * 5])
NANOSECOND = 1e-9


def exact() -> np.ndarray:
    state, force, time = np.array([1.0, 0.0, 0.0, 0.0]), 1.0, 0.0
    for end in (*JUMPS, STOP):
        state = (expm(RATES * (end - time)) @ np.append(state, force))[:4]
        force, time = -force, end
    return state


def made(kind: Any, **keys: Any) -> Program:
    return kind.KIND.build(
        kind.KIND.config(**keys), name=kind.__name__.rpartition(".")[2], folder=Path()
    )


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """FMUs of the square wave, which announces its jumps or does not, and of the sum of forces."""
    folder = tmp_path_factory.mktemp("tables")
    times = [0.0, *(t for jump in JUMPS for t in (jump, jump)), STOP]
    values = [(-1.0) ** (k // 2) for k in range(len(times))]
    signals = {"force": {"unit": "N", "values": values}}
    wave = made(table, times=times, signals=signals)
    both = made(sum_kind, inputs=["spring", "wave"], unit="N")
    return {
        "wave": build_fmu(wave, folder / "wave.fmu", native=True),
        "silent": build_fmu(wave, folder / "silent.fmu", native=True, outputs=["force"]),
        "both": build_fmu(both, folder / "both.fmu", native=True),
    }


def driven(
    fmus: dict[str, Path], c_fmu: Fmus, settings: Simulation, *, wave: str = "wave"
) -> tuple[float, Outcome, list[float]]:
    """The largest error of the states at the end, and all communication points."""
    start = {"stiffness": 1.0, "body.m.x": 1.0}
    parts = (
        Component("wave", FmuFile(fmus[wave])),
        Component("both", FmuFile(fmus["both"])),
        Component("a", FmuFile(c_fmu("mass+state+inputs")), start),
        Component("b", FmuFile(c_fmu("partner+state+inputs"))),
    )
    links = (
        "wave.force -> both.wave",
        "b.end.force_x -> both.spring",
        "both.sum -> a.body.m.force_x",
        "a.body.m.x -> b.end.x",
        "a.body.m.vx -> b.end.vx",
    )
    rows, outcome = observed(System("s", parts, links, settings), *STATES)
    times, *found = zip(*rows, strict=True)
    return float(np.abs([y[-1] for y in found] - exact()).max()), outcome, [*times]


@pytest.mark.verifies(
    "two masses driven by a square wave whose jumps are announced, by fixed steps",
    analytic="matrix exponential from jump to jump",
    tolerance="0.1 of the order",
)
@pytest.mark.parametrize(
    ("algorithm", "order"), [("corrector", 3), ("gauss_seidel", 2), ("implicit", 2), ("jacobi", 1)]
)
def test_order_is_kept_across_jumps(
    fmus: dict[str, Path], c_fmu: Fmus, algorithm: str, order: int
) -> None:
    steps = (0.1, 0.05)
    errors = [driven(fmus, c_fmu, Simulation(STOP, h, algorithm))[0] for h in steps]
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > order - 0.1
    if order > 1:  # a jump that is not announced is off by a part of a step of 2 N
        silent = driven(fmus, c_fmu, Simulation(STOP, steps[-1], algorithm), wave="silent")[0]
        assert silent > 10 * errors[-1]


def test_a_shortened_step_is_followed_by_the_regular_ones(
    fmus: dict[str, Path], c_fmu: Fmus
) -> None:
    _, outcome, times = driven(fmus, c_fmu, Simulation(STOP, 0.1))
    regular = [round(0.1 * k, 9) for k in range(41)]
    around = [t for jump in JUMPS for t in (jump - NANOSECOND, jump)]
    assert sorted({round(t, 9) for t in [*regular, *around]}) == [round(t, 9) for t in times]
    assert outcome.steps == 40 + 2 * len(JUMPS)
    assert outcome.rejected == 0


@pytest.mark.parametrize(
    ("algorithm", "step"),
    [
        *((name, 0.05) for name in ("corrector", "gauss_seidel", "implicit", "jacobi")),
        ("corrector", 2 * HALF_PERIOD),  # all steps end at jumps: shorter ones certify
    ],
)
def test_the_certificate_holds_across_jumps(
    fmus: dict[str, Path], c_fmu: Fmus, algorithm: str, step: float
) -> None:
    error, outcome, _ = driven(fmus, c_fmu, Simulation(STOP, step, algorithm))
    assert not isinstance(outcome.certificate, str)
    # the mass moves by about 3 m and 3 m/s; outputs of a unit are measured by their range
    assert error < 3 * outcome.certificate.errors[0].error * 6
    assert outcome.certificate.errors[0].error < 10 * error


@pytest.mark.verifies(
    "two masses driven by a square wave whose jumps are announced, by adaptive steps",
    analytic="matrix exponential from jump to jump",
    tolerance="1e-6",
)
def test_adaptive_steps_meet_the_jumps_without_looking_for_them(
    fmus: dict[str, Path], c_fmu: Fmus
) -> None:
    settings = Simulation(STOP, 0.1, coupling_tolerance=1e-4)
    error, outcome, times = driven(fmus, c_fmu, settings)
    silent_error, silent, _ = driven(fmus, c_fmu, settings, wave="silent")
    assert {round(t, 9) for t in JUMPS} <= {round(t, 9) for t in times}
    assert outcome.steps + outcome.rejected < 0.5 * (silent.steps + silent.rejected)
    # the tolerance times the steps' share of time; what passing over jumps costs is far below
    assert max(error, silent_error) < 1e-6


def test_a_jump_late_in_a_run_is_met_too(tmp_path: Path, c_fmu: Fmus) -> None:
    # at 1e6 s a time is rounded to 1e-10 s
    late = 1e6
    times, values = [late, late + 0.25, late + 0.25, late + 1], [0.0, 0.0, 1.0, 1.0]
    step = made(table, times=times, signals={"u": {"values": values}}, beyond="held")
    parts = (
        Component("t", FmuFile(build_fmu(step, tmp_path / "t.fmu", native=True))),
        Component("i", FmuFile(c_fmu("integrator+state"))),
    )
    settings = Simulation(late + 1, 0.1, "gauss_seidel", start_time=late)
    rows, _ = observed(System("s", parts, ("t.u -> i.u",), settings), "i.y")
    assert rows[-1] == [late + 1, pytest.approx(0.75, abs=2e-9)]
