"""What the coupling does to energy: a balance over every connection that carries power.

Across a power bond a force F goes one way and the velocity v it works on comes back. At the
communication points, where all values are consistent, its source gives the power F·v:

    given = ∫ F·v dt                     (trapezoid over the communication points)

During a step the body feels the force that the algorithm held, over the distance it really went:

    received = Σ held force · displacement

Their difference is energy that the coupling invented (received > given) or lost. For a second-order
algorithm it falls with the square of the step size.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from m4e_fmi.cosim.connect import Bond
from m4e_fmi.cosim.network import Network
from m4e_fmi.cosim.operations import Operation, gather

BLOCK = 1024
"""Steps that are noted before they are evaluated."""


@dataclass(frozen=True)
class BondEnergy:
    """Energies [J] over the whole run across one bond, from the force's source into the body.

    `exchanged` is the largest magnitude that the energy given has had: the scale of `residual`.
    """

    connection: str
    given: float
    received: float
    exchanged: float

    @property
    def residual(self) -> float:
        """Energy [J] that the body received and nobody gave."""
        return self.received - self.given

    @property
    def relative(self) -> float:
        """The residual over the largest energy exchanged; 0 if nothing was."""
        return self.residual / self.exchanged if self.exchanged else 0.0


class EnergyBalance:
    """Follows the bonds of a network from the present communication point on.

    Forces, velocities and coordinates are noted at every point, and evaluated in blocks.
    """

    REMEMBERED = ("_points", "_held", "_sizes", "_steps", "_given", "_received", "_exchanged")

    def __init__(self, network: Network, bonds: Iterable[Bond]) -> None:
        self._bonds = tuple(bonds)
        self._values = network.values
        axes = [(k, axis) for k, bond in enumerate(self._bonds) for axis in bond.axes]
        count = len(axes)
        targets = {port: k for k, port in enumerate(network.targets)}
        sources = (
            [axis.force.source for _, axis in axes],
            [axis.velocity.source for _, axis in axes],
            [(axis.position or axis.velocity).source for _, axis in axes],
        )
        places = [network.index(port) for ports in sources for port in ports]
        self._index = np.array(places, dtype=np.intp)
        self._target = np.array([targets[a.force.target] for _, a in axes], dtype=np.intp)
        self._has_position = np.array([a.position is not None for _, a in axes], dtype=bool)
        self._of_bond = np.zeros((count, len(self._bonds)))
        self._way_of_bond = np.zeros_like(self._of_bond)
        for row, (k, _) in enumerate(axes):
            force, velocity, way = (network.to_si(ports[row]) for ports in sources)
            self._of_bond[row, k] = force * velocity
            self._way_of_bond[row, k] = force * way
        self._points = np.zeros((BLOCK + 1, 3 * count))
        self._held = np.zeros((BLOCK, count))
        self._sizes = np.zeros(BLOCK)
        self._steps = 0
        self._given = np.zeros(len(self._bonds))
        self._received = np.zeros(len(self._bonds))
        self._exchanged = np.zeros(len(self._bonds))
        self._values.take(self._index, out=self._points[0], mode="clip")

    def add(self, held: np.ndarray, size: float) -> None:
        """Account for the step of `size` [s] that led to the present point, with `held` inputs."""
        if not self._bonds:
            return
        step = self._steps
        self._values.take(self._index, out=self._points[step + 1], mode="clip")
        held.take(self._target, out=self._held[step], mode="clip")
        self.note(1, size)

    def operations(self, held: np.ndarray) -> tuple[Operation, ...]:
        """What notes a step at place `noted` of a block, as `add` does; `held` stays the array."""
        if not self._bonds:
            return ()
        return (
            gather(self._points[1:], self._values, self._index),
            gather(self._held, held, self._target),
        )

    @property
    def noted(self) -> int:
        """Steps in the present block, below BLOCK."""
        return self._steps

    def note(self, count: int, size: float) -> None:
        """Account for `count` steps of `size` [s] that the operations have noted."""
        if not self._bonds:
            return
        self._sizes[self._steps : self._steps + count] = size
        self._steps += count
        if self._steps == BLOCK:
            self._evaluate()

    def jump(self) -> None:
        """Something was set in an FMU: the next step begins with other values than the last ended.

        To be called after they were exchanged.
        """
        if self._bonds:
            self._evaluate()
            self._values.take(self._index, out=self._points[0], mode="clip")

    def _evaluate(self) -> None:
        """Add the block to the sums; its last point is the first of the next."""
        count = self._steps
        force, velocity, position = np.split(self._points[: count + 1], 3, axis=1)
        half = self._sizes[:count, None] / 2
        power = (force * velocity) @ self._of_bond
        given = self._given + np.cumsum(half * (power[1:] + power[:-1]), axis=0)
        way = np.where(
            self._has_position,
            position[1:] - position[:-1],
            half * (velocity[1:] + velocity[:-1]),
        )
        self._received += ((self._held[:count] * way) @ self._way_of_bond).sum(axis=0)
        self._exchanged = np.maximum(self._exchanged, np.abs(given).max(axis=0, initial=0.0))
        self._given = given[-1] if count else self._given
        self._points[0] = self._points[count]
        self._steps = 0

    def result(self) -> tuple[BondEnergy, ...]:
        """The balance up to the present point, one entry per bond."""
        self._evaluate()
        columns = (self._given, self._received, self._exchanged)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return tuple(
            BondEnergy(bond.name, *row) for bond, row in zip(self._bonds, rows, strict=True)
        )
