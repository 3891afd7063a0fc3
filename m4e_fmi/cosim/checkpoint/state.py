"""The saved state of a run, and what another process must know beside it to go on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.cosim.error_estimate.estimator import EstimateSnapshot
from m4e_fmi.cosim.exchange.fmu_log import Kinds
from m4e_fmi.cosim.exchange.layout import NetworkSnapshot
from m4e_fmi.cosim.monitoring.instability import StabilitySnapshot
from m4e_fmi.cosim.monitoring.late_dependence import SecondLookSnapshot
from m4e_fmi.cosim.results.writer import Mark
from m4e_fmi.cosim.stepping.algorithm import AlgorithmSnapshot
from m4e_fmi.cosim.stepping.step_control import StepControlSnapshot
from m4e_fmi.cosim.time_loop.energy import EnergySnapshot
from m4e_fmi.cosim.time_loop.time_loop import TimeLoopSnapshot
from m4e_fmi.files.encoding import LIVE
from m4e_fmi.fmu.importer.calls import SerializedState


@dataclass(frozen=True, eq=False)
class State:
    """The state of a whole system at a communication point of a run, until that ends.

    It holds the states of the FMUs, the exchanged values, what the algorithm knows of the past,
    the energy balance, the integer time, the row of the results, and what is known of the errors.
    `master` is the run that it belongs to.
    """

    master: object = field(repr=False, metadata=LIVE)
    point: NetworkSnapshot = field(repr=False)
    algorithm: AlgorithmSnapshot = field(repr=False)
    control: StepControlSnapshot | None = field(repr=False)
    energy: EnergySnapshot = field(repr=False)
    time_loop: TimeLoopSnapshot = field(repr=False)
    second_look: SecondLookSnapshot = field(repr=False)
    row: Mark | None = field(repr=False)
    seen: EstimateSnapshot | None = field(repr=False)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.point.time

    @property
    def points(self) -> tuple[NetworkSnapshot, ...]:
        """All points of which the FMUs keep states."""
        return (self.point, *(self.seen.points if self.seen else ()))


@dataclass(frozen=True)
class Memory:
    """Memory of a run of its past that does not go back when it returns to a state.

    `warned` are the numbers of steps that FMUs have answered with Warning, with the times [s] of
    the first and the last; `messages` what they have logged, `stability` the looks for growth,
    `ranges` the outputs that have left the range of their FMU, by component and column.
    """

    warned: dict[str, tuple[int, float, float]]
    messages: Kinds
    stability: StabilitySnapshot
    ranges: tuple[dict[int, str], ...]


@dataclass(frozen=True)
class Saved:
    """A state for another process: `fmu_states` are those of its points, by place and component."""

    state: State
    fmu_states: dict[int, dict[str, SerializedState]]
    memory: Memory


@dataclass(frozen=True)
class Exchanged:
    """Exchanged outputs at a communication point, to be compared.

    `values` (n_outputs,) are Real, in the outputs' units; `cells` (n_discrete,) are codes of all
    others.
    """

    values: np.ndarray
    cells: np.ndarray


@dataclass(frozen=True)
class Head:
    """Where a checkpoint is in which run.

    `identity` is what must be the same in a run that goes on; `steps` macro steps lead to `time`
    [s]. `rows` are in the results by then, the last at `last` [s], with the checksum `digest`.
    `texts` are those that stand in cells, in their order. The run is `watched` if observers may
    read all outputs.
    `without` says why there is no state, where there is none: the run is then made again up to
    here.
    """

    identity: dict[str, str]
    time: float
    steps: int
    rows: int
    last: float
    digest: str
    watched: bool
    texts: tuple[bytes, ...]
    exchanged: Exchanged
    without: str

    def check(self) -> None:
        """ValueError if the times cannot be those of a run."""
        if not (math.isfinite(self.time) and self.last <= self.time):
            raise ValueError(f"results up to t = {self.last} s, and a state at t = {self.time} s")
