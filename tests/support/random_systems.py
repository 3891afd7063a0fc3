"""Random chains of masses, springs and dampers as coupled systems, with their exact course."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.linalg import expm

from m4e_fmi.cosim import Component, FmuFile, Network, Outcome, Simulation, System, run, start


@dataclass(frozen=True)
class RandomSystem:
    """A chain in 2 to 4 components, whose states s = (x, v of each mass) follow s' = `matrix` s.

    `sources` (m, states) are the exchanged outputs `names` as rows over the states, `units` theirs.
    """

    system: System
    matrix: np.ndarray
    start: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    sources: np.ndarray

    def true_and_stated(self) -> tuple[float, float]:
        """Largest true error over range of the exchanged outputs, and the one of the certificate.

        nan is stated where the certificate says that it does not know.
        """
        found: list[list[float]] = []

        def observe(_: float, network: Network) -> None:
            found.append([network.read(name) for name in self.names])

        outcome = run(self.system, observers=[observe])
        step = expm(self.matrix * self.system.simulation.step_size)
        return self._compared(found, [step] * (len(found) - 1)), _stated(outcome)

    def true_and_stated_when_set(
        self, dampings: Mapping[int, float], *, detour: int = 0
    ) -> tuple[float, float]:
        """The same of a run in which the first mass is given other dampings after so many steps.

        After each `detour` steps, if not 0, the run goes on as far with another damping, and back.
        """
        first = self.system.components[0].start
        mass, usual, damping = (float(str(first[n])) for n in ("mass", "damping", "damping"))
        row = len(self.start) // 2
        found, ways, way = [], [], np.empty(0)
        with start(self.system) as execution:
            for k, point in enumerate(execution):
                found.append([point[name] for name in self.names])
                if k in dampings:
                    damping = execution["c0.damping"] = dampings[k]
                if detour and k % detour == detour - 1:
                    state = execution.save()
                    execution["c0.damping"] = 10 * usual + mass
                    for _ in range(detour):
                        if not execution.done:
                            execution.step()
                    execution.restore(state)
                if k in dampings or not ways:
                    matrix = self.matrix.copy()
                    matrix[row, row] -= (damping - usual) / mass
                    way = expm(matrix * self.system.simulation.step_size)
                ways.append(way)
        return self._compared(found, ways[:-1]), _stated(execution.outcome)

    def _compared(self, found: Sequence[Sequence[float]], ways: Sequence[np.ndarray]) -> float:
        """The largest error over range; each of `ways` leads the states over a step."""
        states = [self.start]
        for way in ways:
            states.append(way @ states[-1])
        exact = np.array(states) @ self.sources.T
        ranges = {
            unit: max(np.ptp(exact, axis=0)[[u == unit for u in self.units]])
            for unit in set(self.units)
        }
        error = np.abs(np.array(found) - exact).max(axis=0)
        return max(error / [ranges[unit] for unit in self.units])


def _stated(outcome: Outcome) -> float:
    certificate = outcome.certificate
    return np.nan if isinstance(certificate, str) else certificate.errors[0].error


def random_system(
    fmus: Callable[[str], Path],
    algorithm: str,
    rng: np.random.Generator,
    *,
    steps: tuple[int, int] = (40, 250),
    rigid: Literal["none", "some", "all"] = "none",
) -> RandomSystem:
    """Mass ratios to 100, stiffness ratios to 1000, undamped to overdamped, any ωH below 0.5.

    `rigid` components cannot go back to a state; `some` is each second one.
    """
    count = int(rng.integers(2, 5))
    mass = 10 ** rng.uniform(-1, 1, count)
    wall = 10 ** rng.uniform(-1, 1, count)
    spring = 10 ** rng.uniform(-1, 2, count - 1)
    share = rng.choice([0.0, 0.02, 0.2, 1.0], 2)  # of the critical damping
    damper = share[0] * 2 * np.sqrt(spring * mass[1:]) * rng.uniform(0, 1, count - 1)
    loss = share[1] * 2 * np.sqrt(wall * mass) * rng.uniform(0, 1, count)
    stiffness, damping = np.diag(wall), np.diag(loss)
    for k in range(count - 1):
        pair = np.zeros(count)
        pair[k : k + 2] = 1, -1
        stiffness = stiffness + spring[k] * np.outer(pair, pair)
        damping = damping + damper[k] * np.outer(pair, pair)
    inverse = np.diag(1 / mass)
    nothing, one = np.zeros((count, count)), np.eye(count)
    matrix = np.block([[nothing, one], [-inverse @ stiffness, -inverse @ damping]])
    start = np.concatenate((rng.normal(size=count), np.zeros(count)))
    step = 10 ** rng.uniform(-1.7, -0.3) / np.abs(np.linalg.eigvals(matrix)).max()
    step = round(step, 6)  # the master counts nanoseconds
    names, units, rows = [], [], []
    for k in range(count - 1):
        x, v = np.concatenate((one[k], 0 * one[k])), np.concatenate((0 * one[k], one[k]))
        pull = spring[k] * (np.roll(x, 1) - x) + damper[k] * (np.roll(v, 1) - v)
        prefix = f"c{k}.body.m."
        names += [f"{prefix}x", f"{prefix}vx", f"c{k + 1}.end.force_x"]
        units += ["m", "m/s", "N"]
        rows += [x, v, pull]
    components = []
    for k in range(count):
        given = {"mass": mass[k], "stiffness": wall[k]}
        place = {"body.m.x": start[k]}
        model = "mass"
        if k == 0:
            given["damping"] = loss[k]
        else:
            given |= {"coupling": spring[k - 1], "damping": damper[k - 1], "wall_damping": loss[k]}
            model = "middle" if k < count - 1 else "partner"
            place = {"body.m.x": start[k]} if k < count - 1 else {"x": start[k]}
        held = rigid == "all" or (rigid == "some" and k % 2 == 1)
        values = {name: float(value) for name, value in {**given, **place}.items()}
        components.append(
            Component(f"c{k}", FmuFile(fmus(model + ("" if held else "+state"))), values)
        )
    links = tuple(f"c{k}.m <-> c{k + 1}.end" for k in range(count - 1))
    settings = Simulation(step * int(rng.integers(*steps)), step, algorithm)
    system = System("s", tuple(components), links, settings)
    return RandomSystem(system, matrix, start, tuple(names), tuple(units), np.array(rows))
