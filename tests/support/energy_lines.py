"""Energy over the interfaces of a coupled system, from the outputs that its run recorded.

An interface is a connector of a model: forces that another component exerts, and the velocities
they work on. Gross is the energy that went through all of them, ∫ Σ |F·v| dt, without the forces of
still water and without the mean of each force over the run: constant forces, as buoyancy at rest
and pretensions, have a potential.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from m4e_fmi.cosim import Outcome, System, prepare, run
from m4e_fmi.cosim.wiring.links import AXES

LIMIT = 1e-3
"""Of what a balance may be off, over the gross energy."""
WORKS_ON = {force: velocity for force, velocity, _ in AXES} | {"effort": "u"}


@dataclass(frozen=True)
class Interface:
    """Power [W] of one connector into the model, (nt,): as exchanged, and as it counts for gross.

    `source` and `target` are the connectors that exert and feel the forces.
    """

    source: str
    target: str
    power: np.ndarray
    moving: np.ndarray


@dataclass(frozen=True)
class EnergyLines:
    """Interfaces of a run at the times `time` (nt,) [s], and the models' own balance.

    `stored` is the energy of all models, `own` the power of their own loads, (nt,) [J, W].
    """

    time: np.ndarray
    interfaces: list[Interface]
    stored: np.ndarray
    own: np.ndarray
    outcome: Outcome

    def integral(self, rate: np.ndarray) -> np.ndarray:
        """∫ `rate` dt (nt,) from the start, of fourth order, for `rate` (nt,)."""
        return np.asarray(CubicSpline(self.time, rate).antiderivative()(self.time))

    @property
    def gross(self) -> float:
        """Energy that went through all interfaces [J]."""
        return float(self.integral(_sum(np.abs(i.moving) for i in self.interfaces))[-1])

    @property
    def residual(self) -> np.ndarray:
        """Energy (nt,) [J] of the models that neither interfaces nor their own loads gave them."""
        given = self.integral(_sum(i.power for i in self.interfaces) + self.own)
        return self.stored - self.stored[0] - given

    @property
    def coupling(self) -> float:
        """Energy [J] that the coupling created or lost, by the master, over all its connections."""
        return sum(abs(bond.residual) for bond in self.outcome.energy)


def energy_lines(system: System, folder: Path) -> EnergyLines:
    """The lines of a whole run, every step of which is recorded; all is built in `folder`."""
    changed = replace(system, simulation=replace(system.simulation, output_interval=None))
    ready = prepare(changed, build_directory=folder / "build", tell=lambda _: None)
    outcome = run(ready, results=folder / f"{system.name}.nc", certify=False)
    results = outcome.results()
    time, known = np.asarray(results.time), results.series

    def course(name: str) -> np.ndarray:
        return np.asarray(known[name].values)

    sums: dict[tuple[str, str], list[np.ndarray]] = defaultdict(
        lambda: [np.zeros(len(time)), np.zeros(len(time))]
    )
    for link in ready.wiring.links:
        target, _, force = str(link.target).rpartition(".")
        if force not in WORKS_ON:
            continue
        source, _, given = str(link.source).rpartition(".")
        pushing, speed = (
            link.factor * course(f"{source}.{given}"),
            course(f"{target}.{WORKS_ON[force]}"),
        )
        still = f"{source}.hydrostatic_{given}"
        moving = pushing - (link.factor * course(still) if still in known else 0.0)
        mean = np.trapezoid(moving, time) / (time[-1] - time[0])
        both = sums[source, target]
        both[0] += pushing * speed
        both[1] += (moving - mean) * speed
    models = [name for name in known if name.endswith(".energy.total")]
    loads = [name for name in known if ".load." in name and name.endswith(".power")]
    return EnergyLines(
        time=time,
        interfaces=[Interface(*ends, *both) for ends, both in sums.items()],
        stored=_sum(map(course, models)),
        own=_sum([np.zeros(len(time)), *map(course, loads)]),
        outcome=outcome,
    )


def _sum(parts: Iterable[np.ndarray]) -> np.ndarray:
    return np.sum(list(parts), axis=0)
