"""How the components make one step together: one algorithm per file.

An algorithm is made from a Network. Its `step(time, size)` steps every component from the present
communication point, at which all values are consistent, by `size` seconds, which it notes as the
network's `size`; the network's `advance` follows. `held` tells what it held at the network's inputs
meanwhile, `followed` how far these went along with their sources. What it knows of the past is in
the network's `values` and `last`, so that it needs no more than those to go on from another point.
One that does the same in every step is `Scheduled`, and the C library makes its steps. To add one:
a file here, an entry in `ALGORITHMS`, its name in `m4e_fmi.cosim.system.simulation.ALGORITHMS`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol, runtime_checkable

import numpy as np

from m4e_fmi.cosim.algorithms.corrector import Corrector, corrector
from m4e_fmi.cosim.algorithms.doubling import Doubling
from m4e_fmi.cosim.algorithms.gauss_seidel import GaussSeidel
from m4e_fmi.cosim.algorithms.implicit import Implicit
from m4e_fmi.cosim.algorithms.jacobi import Jacobi
from m4e_fmi.cosim.connections.dependence import STEPPED, how_known
from m4e_fmi.cosim.connections.links import Link
from m4e_fmi.cosim.exchange.network import Network


class Algorithm(Protocol):
    """What the master needs of an algorithm."""

    @property
    def held(self) -> np.ndarray:
        """Values held at the network's inputs during the last step, in their order."""
        ...

    @property
    def followed(self) -> np.ndarray:
        """Of each input, 1 if it goes along with its source in the step, 0 if it is held.

        In between, it is the share of the first moment about the mean that inputs have of their
        sources': 1 − 1/n² for n values that are held one after the other, each the mean.
        """
        ...

    @property
    def order(self) -> int:
        """The power of the step with which the error falls, at least."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What it does without because an FMU cannot, one line each."""
        ...

    def step(self, time: float, size: float) -> None:
        """Step all components from `time` by `size` [s]."""
        ...


@runtime_checkable
class Undoing(Protocol):
    """An algorithm that can take its step back, also one that failed, where all FMUs can."""

    def undo(self) -> None:
        """Return all components to the start of the step."""
        ...


class Returning(Algorithm, Undoing, Protocol):
    """An algorithm that estimates the error of its step, and so can have its step chosen."""

    @property
    def estimate_order(self) -> int:
        """The power of the step with which `change` falls."""
        ...

    @property
    def change(self) -> np.ndarray:
        """Estimated error of the exchanged outputs at the end of the step, or a bound of it."""
        ...

    @property
    def end(self) -> np.ndarray:
        """The exchanged outputs at the end of the step."""
        ...


Own = Corrector | GaussSeidel | Implicit | Jacobi

_OWN: dict[str, Callable[[Network], Own]] = {
    "corrector": corrector,
    "gauss_seidel": GaussSeidel,
    "implicit": Implicit,
    "jacobi": Jacobi,
}


def _made(make: Callable[[Network], Own], network: Network) -> Own:
    """The algorithm for `network`: of first order where values come a step late."""
    algorithm = make(network)
    delayed = [str(link) for link in network.links if link.delayed]
    stepped = dict.fromkeys(str(k.source) for k in network.links if _is_stepped(network, k))
    notes = [
        f"{_first_of(late)} {what}: first order, half the step leaves half the error"
        for late, what in (
            (delayed, "carries the value of the step before"),
            (list(stepped), "shows the inputs of its FMU after the next step only"),
        )
        if late
    ]
    if notes:
        algorithm.order = 1
        algorithm.notes = (*algorithm.notes, *notes)
    return algorithm


def _is_stepped(network: Network, link: Link) -> bool:
    source = link.source
    return how_known(network.instances[source.component].description, source.variable) == STEPPED


def _first_of(names: list[str]) -> str:
    return names[0] + (f" (and {len(names) - 1} more)" if len(names) > 1 else "")


ALGORITHMS: dict[str, Callable[[Network], Own]] = {
    name: partial(_made, make) for name, make in _OWN.items()
}


def returning(name: str, network: Network) -> Returning:
    """The algorithm `name` with an estimate of its error in each step."""
    algorithm = ALGORITHMS[name](network)
    if isinstance(algorithm, Corrector) and algorithm.estimates and algorithm.order > 1:
        return algorithm
    return Doubling(network, algorithm)
