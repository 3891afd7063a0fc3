"""Report of the coupling error: the estimated error of each connection.

A run repeats some of its steps, in half as many that are twice as long, or where these are not
possible in twice as many that are half as long; all are watched for kinks (`roughness`).
The largest over the run is reported for each connection, relative to the range: the largest range
of any monitored output of that unit; of the output itself, if it has no unit. A range
of rounding noise counts as NOISE times the largest value of the unit, that of moments at least as
LEAST_ARM times the forces of their component. Monitored are the sources of
all connections; of a component from which no Real is taken, all outputs. This is the error of the
coupling alone; each FMU's own error is the same in both runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from m4e_fmi.cosim.network.network import Network
from m4e_fmi.cosim.system.simulation import NS_PER_SECOND
from m4e_fmi.cosim.wiring.links import Port
from m4e_fmi.shown import first_of, short

LEAST_RANGE = 1e-9
"""Below this share of the largest, the range of an output without unit may be noise."""
NOISE = 1e-12
"""The least range over the largest present value of the unit, and over the nominal values: what
moves less is noise of rounding."""
LEVERS = (("N", "N.m"), ("kg", "kg.m"))
"""Units of forces and of the moments that they make, of masses and of their first moments."""
LEAST_ARM = 1e-9
"""Arm [m] of a component's largest force up to which the range of its moments is noise of rounding,
as of pressures of meganewtons about an axis of symmetry; the same of masses."""
OF_VALUE = 1e-3
"""The least range of such an output over its value: what moves less is an invariant."""
ONE_LENGTH = "its FMU makes steps of one length only"
"""The reason why longer steps are not halved, to know their error."""
LARGE = 0.1
"""Coupling error over the range with which a run tells nothing but that it is wrong."""
LITTLE = 0.8
"""The part of an error that half the step leaves, above which it is not worth the time."""


@dataclass(frozen=True)
class Coverage:
    """The parts of a run from `start` to `end` that were `repeated`; times in nanoseconds.

    `lost` is the time from which on less was repeated than was wanted, and why.
    """

    start: int
    end: int
    repeated: tuple[tuple[int, int], ...] = ()
    lost: tuple[int, str] | None = None

    @property
    def share(self) -> float:
        """Share of the run that was repeated."""
        span, last, covered = self.end - self.start, self.start, 0
        for begin, end in sorted(self.repeated):
            covered += max(0, end - max(begin, last))
            last = max(last, end)
        return covered / span if span else 0.0

    def __str__(self) -> str:
        text = f"{min(99, round(100 * self.share))} % of the run repeated"
        text = "all of the run repeated" if self.share == 1.0 else text
        if self.lost:
            since, why = self.lost
            return f"{text}; from t = {since / NS_PER_SECOND:.6g} s on less than was wanted: {why}"
        return text if self.share == 1.0 else f"{text}, the rest monitored for kinks"


@dataclass(frozen=True)
class CouplingError:
    """The largest error over the range of one connection, and the output that has it.

    `halved` is what half the step would give. Both are shares [1] of `span`, the range in `unit`.
    An output is `switched` if its error is LARGE, its component is one of the `switching`, and it
    changes by more than its error within one step. It then switches a step earlier or later than it
    should, which says nothing of other outputs.
    """

    connection: str
    source: Port
    error: float
    halved: float
    span: float
    unit: str = ""
    switched: bool = False

    def __str__(self) -> str:
        span = f"{self.span:.2g} {self.unit}".rstrip()
        return f"{share_text(self.error)} of the range of {span}, at {self.source}"

    @property
    def falls(self) -> bool:
        """True if half the step is worth its time."""
        return self.halved <= LITTLE * self.error


@short
@dataclass(frozen=True)
class CouplingErrorReport:
    """Estimated coupling errors of a run, the largest first, and how much of it was watched.

    `longer` are the components, none of them sampled, with steps longer than the system's, and why
    the errors do not include those of their steps; empty where they do. Where one is not, errors up
    to NOISE are left out, as they are no knowledge: `errors` may then be empty. The steps of an
    `adaptive` run follow the coupling_tolerance.
    """

    errors: tuple[CouplingError, ...]
    coverage: Coverage | None = None
    longer: Mapping[str, str] = field(default_factory=dict)
    adaptive: bool = False

    @property
    def worst(self) -> CouplingError | None:
        """Largest error of outputs not `switched`, or of all if all are; None without errors."""
        return next((e for e in self.errors if not e.switched), next(iter(self.errors), None))

    @property
    def uncovered(self) -> str:
        """Words on the components whose longer steps are not in the errors; empty if all are."""
        names = " and ".join(name for name, why in self.longer.items() if why)
        return f", without the longer steps of {names}" if names else ""

    def partial(self) -> str:
        """The warning of longer steps whose error is not known; empty if there are none."""
        named = " and ".join(f"{name} ({why})" for name, why in self.longer.items() if why)
        text = (
            f"the stated coupling error does not count the longer steps of {named}: take a "
            "step_size of the system as long as these; of a sampled controller take an FMU that "
            "declares its connected outputs as discrete"
        )
        return text if named else ""

    def warning(self) -> str:
        """The warning of an error that leaves no result; empty if the largest is not LARGE."""
        worst = self.worst
        if worst is None or worst.error <= LARGE:
            return ""
        told = f"the coupling error is {worst}: the results are unusable"
        smaller = "coupling_tolerance" if self.adaptive else f"step_size{self._halved}"
        if not worst.falls:
            events = "another algorithm, or FMUs that announce their events"
            return f"{told}; take a much smaller {smaller}, {events}"
        return f"{told}; take a smaller {smaller}, or another algorithm"

    def __str__(self) -> str:
        worst = self.worst
        if worst is None and self.uncovered:
            return f"the coupling error is not known: it is rounding{self.uncovered}"
        if worst is None:
            return "no coupling, no coupling error"
        halved = share_text(worst.halved)
        remedy = f"half the step{self._halved} would give {halved}"
        if self.adaptive:
            remedy = "a smaller coupling_tolerance lowers it"
        elif not worst.falls:
            remedy = f"half the step would help little: {halved}"
        return f"largest coupling error {worst}{self.uncovered}; {remedy}{self._switched}"

    @property
    def _halved(self) -> str:
        """The components whose steps are to be shortened with the system's, in words."""
        return "".join(f" and that of {name}" for name, why in self.longer.items() if not why)

    @property
    def _switched(self) -> str:
        """The outputs that switch at other points, in words; empty if there are none."""
        found = dict.fromkeys(e.source for e in self.errors if e.switched)
        if not found or (self.worst and self.worst.switched):
            return ""
        verb = "switch" if len(found) > 1 else "switches"
        return (
            f"; {first_of(found, 1)} {verb} a step earlier or later: wrong there by the whole jump"
        )


def share_text(share: float) -> str:
    """A share of 1 in percent, with two digits, or a whole number."""
    return f"{100.0 * share:.{'0f' if share >= 0.1 else '2g'}} %"


def over(values: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Shares (…, n) [1] of values in the spans of their units; 0 where these are 0.

    `values` (…, n) and `spans` (n,) are in the outputs' units.
    """
    return np.divide(values, spans, out=np.zeros_like(values), where=spans > 0.0)


def monitored_places(network: Network) -> np.ndarray:
    """Places (n,) of the monitored outputs in the network's values, as indices."""
    return np.array([network.index(port) for _, port in network.monitored_outputs], dtype=np.intp)


class Spans:
    """Reference of each monitored output's error: the largest range of all outputs of its unit.

    Outputs that have no unit may be anything: each has its own range, but at least OF_VALUE of its
    present value, which an invariant keeps, and LEAST_RANGE of the largest range of them. At least
    NOISE of the largest present or nominal value of the unit: below it is the noise of bodies at
    rest; moments of a component at least LEAST_ARM times the largest range or present value of its
    forces.
    """

    def __init__(self, network: Network) -> None:
        units = [network.unit(port) for _, port in network.monitored_outputs]
        numbers = {unit: number for number, unit in enumerate(dict.fromkeys(units))}
        self._of_unit = np.array([numbers[unit] for unit in units], dtype=np.intp)
        self._bare = np.array([not unit for unit in units], dtype=bool)
        self._places = monitored_places(network)
        self._values, self._largest = network.values, np.zeros(len(numbers))
        self._nominal = np.zeros(len(numbers))
        names = [port.component for _, port in network.monitored_outputs]
        places = {name: place for place, name in enumerate(dict.fromkeys(names))}
        self._of_component = np.array([places[name] for name in names], dtype=np.intp)
        self._levers = [
            tuple(np.array([unit == one for unit in units], dtype=bool) for one in lever)
            for lever in LEVERS
        ]
        np.maximum.at(
            self._nominal, self._of_unit, [network.nominal(p) for _, p in network.monitored_outputs]
        )

    def __call__(self, ranges: np.ndarray) -> np.ndarray:
        """For the range of each of them."""
        self._largest[:] = 0.0
        np.maximum.at(self._largest, self._of_unit, ranges)
        found = self._largest[self._of_unit]
        present = np.abs(self._values[self._places])
        least = np.maximum(LEAST_RANGE * found, OF_VALUE * present)
        spans = np.where(self._bare & (found > 0.0), np.maximum(ranges, least), found)
        spans = np.maximum(spans, self._noise(present))
        for are_forces, are_moments in self._levers:
            forces = np.zeros(len(self._of_component))
            sizes = np.where(are_forces, np.maximum(ranges, present), 0.0)
            np.maximum.at(forces, self._of_component, sizes)
            arms = np.where(are_moments, LEAST_ARM * forces[self._of_component], 0.0)
            spans = np.maximum(spans, arms)
        return np.where(found > 0.0, spans, 0.0)

    def _noise(self, present: np.ndarray) -> np.ndarray:
        """The least range of each, for the magnitudes of the present values."""
        largest = self._nominal.copy()
        np.maximum.at(largest, self._of_unit, present)
        return NOISE * largest[self._of_unit]


def switching(network: Network) -> frozenset[str]:
    """Components that are sampled, exchange values that are no Reals, or take Reals from such ones.

    Others that change by much within one step may have become unstable.
    """
    outputs = {p.component for p in network.discrete.outputs}
    makers = network.sampled | outputs | network.discrete.takers
    taken = {k.target.component for k in network.links if k.source.component in makers}
    return frozenset(makers | taken)


def certificate(
    network: Network,
    connections: Sequence[str],
    *,
    errors: np.ndarray,
    halved: np.ndarray,
    ranges: np.ndarray,
    leaps: np.ndarray | None = None,
    coverage: Coverage | None = None,
    longer: Mapping[str, str] | None = None,
    adaptive: bool = False,
) -> CouplingErrorReport:
    """The certificate of a run from errors of the monitored outputs.

    `errors` (n,), those at half the step `halved` (n,), and `ranges` (n,) are in their units.
    `leaps` (n,), in their units, too, are the largest changes within one step of a run in which
    outputs may be switched at points of their own. `longer` and `adaptive` are those of the report.
    """
    beside = frozenset[str]() if leaps is None else switching(network)
    largest: dict[int, CouplingError] = {}
    spans = Spans(network)(ranges)
    leaps = 0.0 * errors if leaps is None else leaps
    shares = np.array([*over(np.array([errors, halved, leaps]), spans), spans]).T.tolist()
    for (number, port), (error, half, leap, span) in zip(
        network.monitored_outputs, shares, strict=True
    ):
        known = largest.get(number)
        if known is None or error > known.error:
            unit = network.unit(port)
            switched = LARGE < error <= leap and port.component in beside
            largest[number] = CouplingError(
                connections[number], port, error, half, span, unit, switched
            )
    ordered = sorted(largest.values(), key=lambda found: -found.error)
    if longer and any(longer.values()):
        ordered = [found for found in ordered if found.error > NOISE]
    return CouplingErrorReport(tuple(ordered), coverage, longer or {}, adaptive)
