"""Comparison of a linearised response with a simulation of the equations themselves.

The independent reference of the response to waves: no part of the product.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from m4e_fmi.analysis.points import Floats, observed
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.sea_response import SeaResponse
from m4e_fmi.analysis.response.wave_response import WaveResponse
from m4e_fmi.analysis.response.waves import Complex, InWaves
from m4e_fmi.program import TIME, Scalar, cos, sin, with_feedback
from m4e_fmi.program.composition import Law
from m4e_fmi.simulate import simulate

PERIODS = 40
"""Periods of a regular wave that are simulated; the last `MEASURED` are compared."""
MEASURED = 10
PER_PERIOD = 64
SEA_DURATION = 3600.0
"""Seconds of a sea that are compared."""
START_UP = 300.0
"""Seconds of a sea before these, in which the motion forgets how it began."""
SEA_INTERVAL = 0.2
TOLERANCE = 1e-8


@dataclass(frozen=True)
class Comparison:
    """Values of an output of the simulation and of the linearised response, in its unit.

    `what` is "amplitude", "mean" or "standard deviation".
    """

    output: str
    unit: str
    what: str
    simulated: float
    linearised: float

    @property
    def difference(self) -> float:
        """The linearised value relative to the simulated one [1]."""
        if self.simulated == 0.0:
            return 0.0 if self.linearised == 0.0 else np.inf
        return self.linearised / self.simulated - 1.0


def compared_in_time(
    waves: InWaves,
    response: WaveResponse | SeaResponse,
    *,
    period: int = 0,
    direction: int = 0,
) -> list[Comparison]:
    """`response` beside a simulation: to the wave of these numbers, or to an hour of the sea.

    The phases of the sea are random, and both see the same waves.
    """
    if isinstance(response, WaveResponse):
        return _in_regular_waves(waves, response, period, direction)
    return _in_a_sea(waves, response)


def _in_regular_waves(waves: InWaves, response: WaveResponse, k: int, d: int) -> list[Comparison]:
    omega, amplitude = response.omega[k : k + 1], response.height / 2.0
    angle = float(response.directions[d])
    local = _local(waves, response)
    forces = amplitude * waves.per_amplitude(omega, angle, response.point)
    period = 2.0 * np.pi / float(omega[0])
    times, found = _simulated(
        waves, local, omega, forces, np.real(amplitude * response.states[d, k]),
        stop_time=PERIODS * period, interval=period / PER_PERIOD,
    )  # fmt: skip
    last = times > (PERIODS - MEASURED + 0.5 / PER_PERIOD) * period
    first = np.exp(1j * omega[0] * times[last])
    rows = []
    for j, v in enumerate(response.outputs):
        y = found[last, j]
        harmonic = 2.0 * abs(np.mean(y * first))
        linear = amplitude * abs(response.values[d, k, j])
        rows.append(Comparison(v.name, v.unit, "amplitude", harmonic, float(linear)))
        mean = float(response.means[d, k, j])
        rows.append(Comparison(v.name, v.unit, "mean", float(y.mean()), mean))
    return rows


def _in_a_sea(waves: InWaves, response: SeaResponse) -> list[Comparison]:
    sea = response.sea
    local = _local(waves, response)
    turns = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(sea.omega))
    waves_now = (sea.amplitudes * np.exp(-1j * turns))[:, None]
    forces = waves_now * waves.per_amplitude(sea.omega, sea.directions, response.point)
    states = waves_now * response.states
    times, found = _simulated(
        waves, local, sea.omega, forces, response.mean_step + np.real(states.sum(axis=0)),
        stop_time=START_UP + SEA_DURATION, interval=SEA_INTERVAL,
    )  # fmt: skip
    last = times > START_UP
    steps, inputs = (_over(times[last], sea.omega, part) for part in (states, forces))
    linear = local.values(response.mean_step + steps, inputs)[:, local.n :]
    rows = []
    for j, v in enumerate(response.outputs):
        for what, of in (("mean", np.mean), ("standard deviation", np.std)):
            simulated, linearised = float(of(found[last, j])), float(of(linear[:, j]))
            rows.append(Comparison(v.name, v.unit, what, simulated, linearised))
    return rows


def _local(waves: InWaves, response: WaveResponse | SeaResponse) -> LocalEquations:
    names = [v.name for v in response.outputs]
    return LocalEquations(waves.program, response.point, inputs=waves.inputs, outputs=names)


def _simulated(
    waves: InWaves,
    local: LocalEquations,
    omega: Floats,
    forces: Complex,
    start: Floats,
    *,
    stop_time: float,
    interval: float,
) -> tuple[Floats, Floats]:
    """Times (s,) [s] and outputs (s, k) of the motion under Σ Re[`forces` (k, m) e^{−iωt}].

    It begins a step `start` (n,) from the point.
    """
    point, program = local.point, waves.program
    laws = {
        v.name: _law(omega, forces[:, j], point.values[v.name]) for j, v in enumerate(local.inputs)
    }
    known = {v.name for v in program.states}
    names = [v.name for v in local.outputs if v.name not in known]
    driven = with_feedback(observed(program, names), laws)
    values = {**point.values, **started_at(local, start)}
    known = {v.name for v in (*driven.parameters, *driven.inputs, *driven.states)}

    run = simulate(
        driven.with_start({k: x for k, x in values.items() if k in known}),
        stop_time=stop_time,
        output_interval=interval,
        tolerance=TOLERANCE,
    )
    columns = [np.asarray(run[v.name]) for v in local.outputs]
    return np.asarray(run.time), np.array(columns).T


def _law(omega: Floats, forces: Complex, mean: float) -> Law:
    """The input that is `mean` + Σ Re[`forces` (k,) e^{−iωt}], in its unit."""

    def law(x: Mapping[str, Scalar]) -> Scalar | float:
        total: Scalar | float = mean
        for w, force in zip(omega.tolist(), forces.tolist(), strict=True):
            angle = w * x[TIME]
            total = total + force.real * cos(angle) + force.imag * sin(angle)
        return total

    return law


def _over(times: Floats, omega: Floats, harmonics: Complex) -> Floats:
    """Σ Re[`harmonics` (k, n) e^{−iωt}] at `times` (s,), (s, n)."""
    turns = np.exp(-1j * np.outer(times, omega))
    return np.real(turns @ harmonics)


def started_at(local: LocalEquations, step: Floats) -> dict[str, float]:
    """Start values of the program's states at a `step` (n,) from the point, in SI, by name."""
    names = [v.name for v in local._linear.program.states]
    return dict(zip(names, local._moved(step[None])[0].tolist(), strict=True))
