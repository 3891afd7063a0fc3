"""Energy balance of the coupling, over every connection that carries power.

Across a power bond a force F goes to a body, whose velocity v is exchanged too. At the
communication points, where all values are consistent, its source gives the power F·v:

    given = ∫ F·v dt

That is the trapezoid over the communication points, less H³/12 (F·v)″ in each step, from the
points beside it. During a step the body feels the force that the algorithm held, over the distance
it really went:

    received = Σ held force · displacement + c H/12 · ΔF · Δv

where the force went along with its source, the `followed` share c of the second term is added: the
work that the mean of the force lacks, by the changes of force and velocity over the step.

Their difference is energy that the coupling invented (received > given) or lost. For a second-order
algorithm it falls with the square of the step size; with inputs that are held it is the effect of
holding them.

It is given as a share of the energy that the motion exchanges. The mean F̄ of a force over the run,
as a weight or the pull of a mooring, is a constant force: the work F̄ (x − x₀) is that of a
potential, it comes back with the body, and may be far larger than all that moves. So

    exchanged = max W − min W,   W(t) = ∫₀ᵗ F·v dt − Σ F̄ (x − x₀)

over the directions of the bond: of an oscillation on a spring k with the amplitude A that is
k A²/2, whatever the preload. Where a body does not come back, as one that is towed or turns on and
on, the work of the mean force is exchanged energy, and stays in W: in a direction in which it ends
farther from its start than half the distance that it has travelled.

Of a force that does not change, holding it invents nothing. So the work of F̄ is the same on both
sides: the difference of ∫ v dt and the displacement is the error of these integrals, which F̄ would
multiply, at rest beyond all that is exchanged.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.network.operations import Operation, gather
from m4e_fmi.cosim.network.restorable import Restorable
from m4e_fmi.cosim.stepping.algorithm import BLOCK
from m4e_fmi.cosim.wiring.links import Bond

LIKE = 4.0
"""Largest ratio of two neighbouring steps that give a second derivative."""
NOISE = 1e-12
"""Swing of a coordinate of a body at rest by rounding, in its own unit (m, rad)."""
MOST_KEPT = 1024
"""Rows that are kept for the swing of the energy."""


@dataclass(frozen=True)
class BondEnergy:
    """Energies [J] over the whole run across one bond, from the force's source into the body.

    `exchanged` is how far the energy given has swung, without the work of the mean force on a
    motion that comes back (see the module): the scale of `residual`. `adds` are the components
    whose forces the source adds up: the energies are those of their sum.
    """

    connection: str
    given: float
    received: float
    exchanged: float
    adds: tuple[str, ...] = ()
    noise: float = 0.0

    @property
    def is_idle(self) -> bool:
        """True if nothing is exchanged, but for rounding noise."""
        return self.exchanged <= self.noise

    @property
    def residual(self) -> float:
        """Energy [J] that the body received and nobody gave."""
        return self.received - self.given

    @property
    def relative(self) -> float:
        """The residual over the energy exchanged; 0 if nothing was, but for rounding noise."""
        return 0.0 if self.is_idle else self.residual / self.exchanged


@dataclass(frozen=True)
class _Sums:
    """Integrals over all evaluated steps, and the extreme rows of the energies given.

    `given` and `received` (n_bonds,) are in J. By axis (n_axes,), in the units of their FMUs: `way`
    and `distance` travelled by the velocity, `moved` by the coordinate, `impulse` and largest
    magnitude `peak` of the force. `time` in s.
    `swing` (n_rows, n_bonds + n_axes) has rows of energies given and ways.
    """

    given: np.ndarray
    received: np.ndarray
    way: np.ndarray
    distance: np.ndarray
    moved: np.ndarray
    impulse: np.ndarray
    peak: np.ndarray
    time: float
    swing: np.ndarray


class EnergyBalance(Restorable):
    """Energy balance over the bonds of a network from the present communication point on.

    Forces, velocities and coordinates are noted at every point, and evaluated in blocks. Of each
    block two rows are kept for the swing of the energy, where it is largest and smallest for the
    mean forces up to there. `noted` are the steps in the present block, below BLOCK.
    """

    restored = ("_sums", "noted", "_points", "_held", "_sizes")

    def __init__(
        self, network: Network, bonds: Iterable[Bond], followed: np.ndarray | None = None
    ) -> None:
        """`followed` (n_inputs,) are shares by which inputs go along with sources (`Algorithm`)."""
        self._bonds = tuple(bonds)
        self._values = network.values
        axes = [(k, axis) for k, bond in enumerate(self._bonds) for axis in bond.axes]
        count = len(axes)
        sources = (
            [axis.force.source for _, axis in axes],
            [axis.velocity.source for _, axis in axes],
            [(axis.position or axis.velocity).source for _, axis in axes],
        )
        places = [network.index(port) for ports in sources for port in ports]
        self._index = np.array(places, dtype=np.intp)
        self._target = np.array([network.place(a.force) for _, a in axes], dtype=np.intp)
        self._followed = np.zeros(count) if followed is None else followed[self._target]
        self._has_position = np.array([a.position is not None for _, a in axes], dtype=bool)
        self._of_bond = np.zeros((count, len(self._bonds)))
        self._way_of_bond = np.zeros_like(self._of_bond)
        for row, (k, axis) in enumerate(axes):
            force, velocity, way = (network.to_si(ports[row]) for ports in sources)
            self._of_bond[row, k] = axis.share * force * velocity
            self._way_of_bond[row, k] = axis.share * force * way
        self._points = np.zeros((BLOCK + 1, 3 * count))
        self._held = np.zeros((BLOCK, count))
        self._sizes = np.zeros(BLOCK)
        self.noted = 0
        self._bond_of = np.array([k for k, _ in axes], dtype=np.intp)
        swing = np.zeros((1, len(self._bonds) + count))
        self._sums = _Sums(
            *np.zeros((2, len(self._bonds))), *np.zeros((5, count)), time=0.0, swing=swing
        )
        self._values.take(self._index, out=self._points[0], mode="clip")

    def add(self, held: np.ndarray, size: float, left: np.ndarray | None = None) -> None:
        """Account for a step of `size` [s] to the present point.

        The inputs `held` (n_inputs,) are in their sources' units. If there was a jump at the
        present point, `left` (n,) are all values before it, in their units.
        """
        if not self._bonds:
            return
        step = self.noted
        values = self._values if left is None else left
        values.take(self._index, out=self._points[step + 1], mode="clip")
        held.take(self._target, out=self._held[step], mode="clip")
        self.note(1, size)
        if left is not None:
            self.jump()

    def operations(self, held: np.ndarray) -> tuple[Operation, ...]:
        """Operations that note a step at place `noted` of a block.

        `held` (n_inputs,), in the sources' units, is read in each step.
        """
        if not self._bonds:
            return ()
        return (
            gather(self._points[1:], self._values, self._index),
            gather(self._held, held, self._target),
        )

    def note(self, count: int, size: float) -> None:
        """Account for `count` steps of `size` [s] that the operations have noted."""
        if not self._bonds:
            return
        self._sizes[self.noted : self.noted + count] = size
        self.noted += count
        if self.noted == BLOCK:
            self._evaluate()

    def jump(self) -> None:
        """Account for values set in an FMU at the present point, after the exchange there."""
        if not self._bonds:
            return
        present = self._values.take(self._index, mode="clip")
        if not np.array_equal(present, self._points[self.noted]):
            self._evaluate()
            self._points[0] = present

    def _evaluate(self) -> None:
        """Add the block to the sums; its last point is the first of the next."""
        count, sums = self.noted, self._sums
        if not count:
            return
        force, velocity, position = np.split(self._points[: count + 1], 3, axis=1)
        sizes = self._sizes[:count, None]
        half = sizes / 2
        given = sums.given + np.cumsum(_passed((force * velocity) @ self._of_bond, sizes), axis=0)
        passed = _passed(velocity, sizes)
        # a held force bends no way: where nothing follows, the trapezoid is exact
        along = np.where(self._followed > 0.0, passed, half * (velocity[1:] + velocity[:-1]))
        way = np.where(self._has_position, position[1:] - position[:-1], along)
        received = sums.received + ((self._held[:count] * way) @ self._way_of_bond).sum(axis=0)
        bent = sizes / 12 * np.diff(force, axis=0) * np.diff(velocity, axis=0)
        ways = sums.way + np.cumsum(passed, axis=0)  # by the same rule as the energy given
        self._sums = replace(
            sums,
            given=given[-1].copy(),
            received=received + (bent @ (self._followed[:, None] * self._of_bond)).sum(axis=0),
            way=ways[-1].copy(),
            distance=sums.distance + np.abs(passed).sum(axis=0),
            moved=sums.moved + way.sum(axis=0),
            impulse=sums.impulse + (half * (force[1:] + force[:-1])).sum(axis=0),
            peak=np.maximum(sums.peak, np.abs(force).max(axis=0)),
            time=sums.time + float(self._sizes[:count].sum()),
        )
        self._keep(np.hstack((given, ways)))
        self._points[0] = self._points[count]
        self.noted = 0

    def _work(self, rows: np.ndarray) -> np.ndarray:
        """W of each bond, for the mean forces, of rows: energies given (bonds), ways (axes)."""
        given, ways = np.hsplit(rows, [len(self._bonds)])
        return given - (ways * self._mean()) @ self._of_bond

    def _mean(self) -> np.ndarray:
        """Mean forces (n_axes,) where the motion comes back, 0 elsewhere; in the FMUs' units."""
        sums = self._sums
        comes_back = np.abs(sums.way) <= sums.distance / 2
        return np.where(comes_back, sums.impulse / (sums.time or 1.0), 0.0)

    def _keep(self, rows: np.ndarray) -> None:
        """Keep the extremes of these rows; of all kept rows, when they are too many."""
        swing = np.concatenate((self._sums.swing, self._extremes(rows)))
        if len(swing) > MOST_KEPT:
            parts = np.array_split(swing, len(swing) // 4)
            swing = np.concatenate([self._extremes(part) for part in parts])
        self._sums = replace(self._sums, swing=swing)

    def _extremes(self, rows: np.ndarray) -> np.ndarray:
        """Two rows: each bond with its axes as where its W is largest, and where smallest."""
        work = self._work(rows)
        bonds = np.array([work.argmax(axis=0), work.argmin(axis=0)])
        places = np.hstack((bonds, bonds[:, self._bond_of]))
        return np.take_along_axis(rows, places, axis=0)

    def result(self) -> tuple[BondEnergy, ...]:
        """The balance up to the present point, one entry per bond."""
        self._evaluate()
        sums = self._sums
        noise = NOISE * (sums.peak @ np.abs(self._way_of_bond))
        mean = self._mean()
        received = sums.received - (mean * sums.moved) @ self._way_of_bond
        received += (mean * sums.way) @ self._of_bond
        columns = (sums.given, received, np.ptp(self._work(sums.swing), axis=0), noise)
        rows = zip(*(column.tolist() for column in columns), strict=True)
        return tuple(
            BondEnergy(bond.name, given, received, exchanged, adds=bond.adds, noise=least)
            for bond, (given, received, exchanged, least) in zip(self._bonds, rows, strict=True)
        )


def _passed(rates: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Integrals (steps, n) over steps of `sizes` (steps, 1) [s] of `rates` (steps + 1, n).

    Trapezoids, less H³/12 times the mean second derivative at both ends, if it is known from
    points beside the step: neighbouring steps must be of like size, which is not so at a jump.
    """
    found = sizes / 2 * (rates[1:] + rates[:-1])
    if len(sizes) < 2:
        return found
    slopes = np.diff(rates, axis=0) / sizes
    bends = 2 * np.diff(slopes, axis=0) / (sizes[1:] + sizes[:-1])
    alike = np.maximum(sizes[1:], sizes[:-1]) <= LIKE * np.minimum(sizes[1:], sizes[:-1])
    bends = np.pad(np.where(alike, bends, 0.0), ((1, 1), (0, 0)))
    known = np.pad(alike, ((1, 1), (0, 0))).astype(float)
    count = np.maximum(known[1:] + known[:-1], 1.0)
    return found - sizes**3 / 12 * (bends[1:] + bends[:-1]) / count
