"""The outcome of a run that has ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.cosim.error.report import CouplingErrorReport
from m4e_fmi.cosim.network.fmu_log import FmuMessage
from m4e_fmi.cosim.time_loop.energy import BondEnergy
from m4e_fmi.cosim.wiring.prepared import Prepared
from m4e_fmi.errors import RunError
from m4e_fmi.results.results_file import Results, load_results
from m4e_fmi.shown import listing

NOT_ASKED = "it was not estimated, as asked (certify, --no-certify)"


@dataclass(frozen=True)
class Outcome:
    """A finished run: where its results are, its steps, wall time [s] and energy balance [J].

    `order` is that of the coupling, `rejected` steps were taken back and made again, smaller.
    `notes` tell what the algorithm did without because an FMU cannot, `warnings` what seems to be
    left out of the connections, and what grows without bound, one line each. `certificate`
    estimates the coupling errors; it is a text that tells why they are not known, where they are
    not. `messages` are the warnings and errors that FMUs have logged, one of each kind; `scenario`
    has a line for each action of the scenario: when it began and ended.
    """

    prepared: Prepared = field(repr=False)
    path: Path | None
    steps: int
    wall_time: float
    energy: tuple[BondEnergy, ...]
    order: int
    notes: tuple[str, ...] = ()
    rejected: int = 0
    certificate: CouplingErrorReport | str = ""
    messages: tuple[FmuMessage, ...] = ()
    warnings: tuple[str, ...] = ()
    scenario: tuple[str, ...] = ()

    def results(self) -> Results:
        """The results file, in memory."""
        if self.path is None:
            raise RunError("this run wrote no results", "give `results` to run")
        return load_results(self.path)

    def __repr__(self) -> str:
        return listing(
            f"Outcome of {self.prepared.system.name!r}: {self.steps} steps in "
            f"{self.wall_time:.3g} s, results in {str(self.path) if self.path else 'no file'}",
            certificate=[str(self.certificate)],
            energy=[bond.connection for bond in self.energy],
            notes=self.notes,
        )


class ExportError(RunError):
    """A run has ended well, but its results could not be written in the form that was asked for.

    `outcome` is that of the run; its `path` is the netCDF file, which is complete.
    """

    def __init__(self, error: RunError, outcome: Outcome) -> None:
        super().__init__(error.message, error.remedy)
        self.outcome = outcome
