"""The saved state of a run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from m4e_fmi.cosim.error_estimate.state import StepDoublingSnapshot
from m4e_fmi.cosim.exchange.network import NetworkSnapshot
from m4e_fmi.cosim.monitoring.late_dependence import SecondLookSnapshot
from m4e_fmi.cosim.results.writer import Mark
from m4e_fmi.cosim.stepping.algorithm import AlgorithmSnapshot
from m4e_fmi.cosim.stepping.step_control import StepControlSnapshot
from m4e_fmi.cosim.time_loop.energy import EnergySnapshot
from m4e_fmi.cosim.time_loop.time_loop import TimeLoopSnapshot

if TYPE_CHECKING:
    from m4e_fmi.cosim.master.master import Master


@dataclass(frozen=True, eq=False)
class State:
    """The state of a whole system at a communication point of a run, until that ends.

    It holds the states of the FMUs, the exchanged values, what the algorithm knows of the past,
    the energy balance, the integer time, the row of the results, and what is known of the errors.
    """

    master: Master = field(repr=False)
    point: NetworkSnapshot = field(repr=False)
    algorithm: AlgorithmSnapshot = field(repr=False)
    control: StepControlSnapshot | None = field(repr=False)
    energy: EnergySnapshot = field(repr=False)
    time_loop: TimeLoopSnapshot = field(repr=False)
    second_look: SecondLookSnapshot = field(repr=False)
    row: Mark | None = field(repr=False)
    seen: StepDoublingSnapshot | None = field(repr=False)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.point.time
