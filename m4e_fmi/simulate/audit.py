"""Energy balance of a simulation: works of loads and inputs, and the residual.

The work of a load is one more state of the program, whose rate is the power that the program
reports: it is integrated by the method that integrates the motion, under the same error control.
A power can have kinks that the motion does not have, as at the end of a damped contact, where the
force is zero on both sides.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.program import Program, Variable
from m4e_fmi.shown import short

KINETIC, POTENTIAL, TOTAL = "energy.kinetic", "energy.potential", "energy.total"
POWER = re.compile(r"(?:.+\.)?(load\.\w+|inputs)\.power")

WORK = re.compile(r"(load\.\w+|inputs)\.work")


@short
@dataclass(frozen=True)
class EnergyAudit:
    """Error of the energy balance of a simulation.

    `residual` [J], shape (n_times,), is E(t) − E(0) − Σ works: of kinetic and potential energy
    together, and of all loads and inputs that change it. `scale` [J] is the largest value of the
    kinetic energy, the change of the potential energy or the work of one load. `total` [J], shape
    (n_times,), is E(t).
    """

    residual: np.ndarray
    scale: float
    total: np.ndarray

    @property
    def relative(self) -> float:
        """The largest residual, of the scale; 0 if nothing happened but rounding of the total."""
        rounding = float(np.finfo(float).eps * np.abs(self.total).max())
        happened = self.scale > rounding
        return float(np.abs(self.residual).max()) / self.scale if happened else 0.0


def with_works(program: Program) -> tuple[Program, int]:
    """The program with a state `<…>.work` [J] for each of its powers, and how many these are."""
    states, rates = [], []
    for variable, node in zip(program.outputs, program.results, strict=True):
        if POWER.fullmatch(variable.name):
            owner = variable.name.removesuffix(".power")
            text = "Work since the start by which the total energy has changed"
            states.append(Variable(f"{owner}.work", "J", text, local=True))
            rates.append(node)
    audited = replace(program, states=(*program.states, *states), rates=(*program.rates, *rates))
    return audited, len(states)


def energy_audit(values: Mapping[str, np.ndarray]) -> EnergyAudit | None:
    """Audit of `values` over time, arrays (n_times,) by name, energies and works in J.

    Of a program of several parts the energies and works of all are added up. None where there is
    no total energy.
    """
    owners = [name.removesuffix(TOTAL) for name in values if f".{name}".endswith(f".{TOTAL}")]
    if not owners:
        return None
    energy, residual, exchanged = 0.0, 0.0, list[np.ndarray]()
    for owner in owners:
        own = {n.removeprefix(owner): v for n, v in values.items() if n.startswith(owner)}
        works = [value for name, value in own.items() if WORK.fullmatch(name)]
        kinetic, potential, total = (values[owner + name] for name in (KINETIC, POTENTIAL, TOTAL))
        energy, residual = energy + total, residual + total - total[0] - sum(works)
        exchanged += [kinetic, potential - potential[0], *works]
    scale = max(float(np.abs(value).max()) for value in exchanged)
    return EnergyAudit(np.asarray(residual), scale, np.asarray(energy))
