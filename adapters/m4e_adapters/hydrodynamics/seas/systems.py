"""Systems of waves: components whose frequencies, amplitudes and phases may be parameters.

A system is asked for its components with a function that gives each of its parameters a scalar: a
recorder's, or numbers for values that are known. Regular waves have a period that may change. The
components' frequencies of a spectrum are fixed when it is made: amplitudes follow the parameters,
frequencies stay. Its peak period therefore has limits, within which the statistics of the sea hold
(`PERIODS`). Components and records of one's own stay as they are.

Waves that break, and seas that are too steep: allowed, and seldom meant.

A wave breaks above 0.142 λ tanh kh (R. Miche, "Mouvements ondulatoires de la mer en profondeur
constante ou décroissante", Annales des Ponts et Chaussées 114, 1944), and above 0.78 h, which is
where a solitary wave does. A sea is too steep where 2π Hs/(g Tp²) is above 1/15 for Tp ≤ 8 s, above
1/25 for Tp ≥ 15 s, or above what is linear between: the steepness criteria of DNV-RP-C205,
"Environmental conditions and environmental loads".
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from m4e_adapters.hydrodynamics.config.waves import PEAK_ENHANCEMENT
from m4e_adapters.hydrodynamics.seas.water.kinematics import wavenumber
from m4e_adapters.hydrodynamics.seas.water.recorded_flow import Number, RecordedWaves
from m4e_adapters.hydrodynamics.seas.waves import component_amplitudes, recorded_wavenumber
from m4e_fmi.program import Recorder, Scalar, Variable, cos, maximum, minimum

STEEPEST, OF_DEPTH = 0.142, 0.78  # heights that break, over wavelength and over depth
PEAKS, STEEPNESSES = (8.0, 15.0), (1 / 15, 1 / 25)  # [s] of the peak, and limits there


def breaking_heights(omega: np.ndarray, *, depth: float, gravity: float) -> np.ndarray:
    """Heights (k,) [m] above which regular waves of `omega` (k,) [rad/s] break."""
    k = wavenumber(omega, depth=depth, gravity=gravity)
    return np.minimum(STEEPEST * 2 * math.pi / k * np.tanh(k * depth), OF_DEPTH * depth)


def wave_doubts(
    height: float, period: float, *, depth: float, gravity: float, regular: bool
) -> Iterator[str]:
    """Lines on a wave of `height` [m] and `period` [s], or on the sea of these at its peak."""
    omega = np.array([2 * math.pi / period])
    breaking = float(breaking_heights(omega, depth=depth, gravity=gravity)[0])
    noun, of = ("wave height", "") if regular else ("significant wave height", "peak ")
    if height > breaking:
        water = "deep water" if math.isinf(depth) else f"{depth:g} m of water"
        yield (
            f"the {noun} of {height:.4g} m is above {breaking:.3g} m, at which waves of a "
            f"{of}period of {period:.4g} s break in {water}: no such sea exists: make it lower or "
            "longer"
        )
    steepness = 2 * math.pi * height / (gravity * period**2)
    limit = float(np.interp(period, PEAKS, STEEPNESSES))
    if not regular and steepness > limit and height <= breaking:
        yield (
            f"the sea is too steep: 2 pi Hs/(g Tp^2) is {steepness:.3g} (Hs {height:.4g} m, Tp "
            f"{period:.4g} s), seas have up to {limit:.3g} at this period (DNV-RP-C205): make it "
            "lower or longer"
        )


Ask = Callable[[Variable], Number]
PERIODS = (0.8, 1.25)  # of the peak period that the components were made for
RAMP_PERIODS = 2.0  # default length of the ramp in (peak) periods
SHORTEST = 1e-9  # ramp [s], so that a ramp_time set to 0 is none
FEWEST = 1e-3  # s, period of a regular wave


@dataclass(frozen=True)
class WaveSystem(ABC):
    """One system of waves, whose parameters begin with `name`: "wave", or "wave[2]" of several.

    `omega`, `phases` and `offsets` from its direction are (k,) [rad/s, rad, rad], as configured;
    phases at `place` [m] and t = 0. `direction` in deg, `ramp_time` [s] (None: the default),
    `depth` [m], `gravity` [m/s2]. The direction is a parameter in space, which keeps its value if
    it is `fixed`.
    """

    name: str
    direction: float
    ramp_time: float | None
    depth: float
    gravity: float
    omega: np.ndarray = field(repr=False)
    phases: np.ndarray = field(repr=False)
    offsets: np.ndarray = field(repr=False)
    fixed: bool = field(default=False, kw_only=True)

    @property
    @abstractmethod
    def period(self) -> float:
        """Of the wave, of the peak, or of the largest component [s]."""

    @property
    @abstractmethod
    def needed(self) -> float:
        """Frequency [rad/s] up to which the waves need computed excitation."""

    @abstractmethod
    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Heights [m] and periods [s] that say whether there are such waves.

        For `values` of parameters by name; those left out are as configured.
        """

    @abstractmethod
    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        """Frequencies and amplitudes, with parameters that `ask` gives."""

    @property
    def regular(self) -> bool:
        """True if it is one wave."""
        return False

    @property
    def reach(self) -> str:
        """The meaning of `needed`, for messages."""
        return "97 % of their energy"

    @property
    def place(self) -> tuple[float, float]:
        """(x, y) [m] where the phases count."""
        return 0.0, 0.0

    @property
    def default_ramp(self) -> float:
        """Length of the ramp [s] if none is given."""
        return RAMP_PERIODS * self.period

    @property
    def length(self) -> float:
        """Of a wave of `period` [m]."""
        k = wavenumber(np.array(2 * math.pi / self.period), depth=self.depth, gravity=self.gravity)
        return 2 * math.pi / float(k)

    def doubts(self, values: Mapping[str, float]) -> list[str]:
        """Lines on waves that break, or are too steep, for `values` of parameters by name."""
        return [
            text
            for height, period in self.judged(values)
            for text in wave_doubts(
                height, period, depth=self.depth, gravity=self.gravity, regular=self._as_regular
            )
        ]

    def notes(self) -> tuple[str, ...]:
        """Lines on what is done with a file."""
        return ()

    def within(self, low: float, high: float) -> WaveSystem:
        """The system where forces are known from `low` to `high` [rad/s] only."""
        del low, high
        return self

    @property
    def _as_regular(self) -> bool:
        return self.regular

    def record(self, recorder: Recorder, *, in_space: bool) -> RecordedWaves:
        """Record the parameters; the components of them. Only `in_space` the direction is one."""
        omega, amplitude = self._own(recorder.parameter)
        phase = [self._phase(recorder, k) for k in range(len(self.omega))]
        given = math.radians(self.direction)
        direction: Number = given
        if in_space:
            text = "direction that the waves travel to, from +X towards +Y"
            limits = (given, given) if self.fixed else (-math.inf, math.inf)
            variable = Variable(
                f"{self.name}.direction", "rad", text, start=given, display_unit="deg",
                minimum=limits[0], maximum=limits[1],
            )  # fmt: skip
            direction = recorder.parameter(variable)
        number = self._numbers(omega)
        ramp = self._record_ramp(recorder)
        waves = RecordedWaves(omega, number, amplitude, phase, direction, self.offsets, ramp)
        x, y = self.place
        if x == y == 0.0:
            return waves
        ways = (waves.along(k) for k in range(len(omega)))
        moved = [p + k * (x * c + y * s) for p, k, (c, s) in zip(phase, number, ways, strict=True)]
        return RecordedWaves(omega, number, amplitude, moved, direction, self.offsets, ramp)

    def known(self, values: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """ω (k,) [rad/s], amplitudes (k,) [m] and directions (k,) [rad].

        For `values` of parameters by name; those left out are as configured.
        """
        omega, amplitude = self._own(lambda v: values.get(v.name, v.start))
        mean = self.known_direction(values)
        return (
            np.array(omega, dtype=float),
            np.array(amplitude, dtype=float),
            mean + self.offsets,
        )

    @property
    def in_statistics(self) -> float:
        """Amplitudes that statistics are of over those that a run has."""
        return 1.0

    def configured(self) -> tuple[np.ndarray, np.ndarray]:
        """ω (k,) [rad/s] and amplitudes (k,) [m] as configured."""
        omega, amplitude = self._own(lambda variable: variable.start)
        return np.array(omega, dtype=float), np.array(amplitude, dtype=float)

    def known_phases(self, values: Mapping[str, float]) -> np.ndarray:
        """Phases (k,) [rad] at x = y = 0, t = 0 for `values` by name."""
        omega, _, direction = self.known(values)
        names = (f"{self.name}.phase[{k + 1}]" for k in range(len(self.phases)))
        pairs = zip(names, self.phases.tolist(), strict=True)
        phases = np.array([values.get(name, phase) for name, phase in pairs])
        x, y = self.place
        number = wavenumber(omega, depth=self.depth, gravity=self.gravity)
        return phases + number * (x * np.cos(direction) + y * np.sin(direction))

    def known_direction(self, values: Mapping[str, float]) -> float:
        """Mean direction [rad] for `values` by name."""
        return values.get(f"{self.name}.direction", math.radians(self.direction))

    def _numbers(self, omega: Sequence[Number]) -> list[Number]:
        water = {"depth": self.depth, "gravity": self.gravity}
        if any(isinstance(w, Scalar) for w in omega):
            return [recorded_wavenumber(w, **water) for w in omega]
        return wavenumber(np.array(omega, dtype=float), **water).tolist()

    def _phase(self, recorder: Recorder, k: int) -> Number:
        text = f"phase of the wave component of {self.omega[k]:.6g} rad/s at x = 0, t = 0"
        start = float(self.phases[k])
        return recorder.parameter(Variable(f"{self.name}.phase[{k + 1}]", "rad", text, start=start))

    def _record_ramp(self, recorder: Recorder) -> Number:
        """½(1 − cos π t/T) until t = T = `ramp_time`, then 1."""
        start = self.default_ramp if self.ramp_time is None else self.ramp_time
        if start == 0.0:
            return 1.0
        text = "time in which the sea grows from nothing"
        variable = Variable(f"{self.name}.ramp_time", "s", text, start=start, minimum=0.0)
        length = recorder.parameter(variable)
        return 0.5 - 0.5 * cos(math.pi * minimum(recorder.time / maximum(length, SHORTEST), 1.0))


@dataclass(frozen=True)
class RegularWave(WaveSystem):
    """A regular wave of `height` [m], with a period from `shortest` to `longest` [s]."""

    height: float
    shortest: float = FEWEST
    longest: float = math.inf

    @property
    def regular(self) -> bool:
        """True."""
        return True

    @property
    def period(self) -> float:
        """As configured [s]."""
        return 2 * math.pi / float(self.omega[0])

    @property
    def needed(self) -> float:
        """Its frequency [rad/s]."""
        return float(self.omega[0])

    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Its height [m] and period [s], of `values` by name."""
        height = values.get(f"{self.name}.height", self.height)
        return [(height, values.get(f"{self.name}.period", self.period))]

    def within(self, low: float, high: float) -> RegularWave:
        """The wave with a period that stays where forces are known, or as it is."""
        shortest = min(self.period, max(FEWEST, 2 * math.pi / high))
        return replace(self, shortest=shortest, longest=max(self.period, 2 * math.pi / low))

    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        text = "height of the regular wave"
        height = ask(Variable(f"{self.name}.height", "m", text, start=self.height, minimum=0.0))
        text = "period of the regular wave"
        if math.isfinite(self.longest):
            text += f", {self.shortest:.4g} to {self.longest:.4g} s: as far as forces are computed"
        period = ask(
            Variable(
                f"{self.name}.period", "s", text, start=self.period,
                minimum=self.shortest, maximum=self.longest,
            )
        )  # fmt: skip
        return [2.0 * math.pi / period], [0.5 * height]


@dataclass(frozen=True)
class SpectralSea(WaveSystem):
    """A sea of JONSWAP's form, whose parts of the frequency axis have `widths` (k,) [rad/s].

    Energies are in proportion to widths, which may contain a factor of the form. `enhancement` None
    is the form of Pierson and Moskowitz. `luck` (k,) [1] multiplies amplitudes.
    """

    REACH = 2.5  # peak frequencies up to which excitation is computed

    widths: np.ndarray = field(repr=False)
    luck: np.ndarray = field(repr=False)
    significant_height: float
    peak_period: float
    enhancement: float | None

    @property
    def period(self) -> float:
        """Of the peak, as configured [s]."""
        return self.peak_period

    @property
    def needed(self) -> float:
        """Where 3 % of the energy is left [rad/s]."""
        return self.REACH * 2 * math.pi / self.peak_period

    @property
    def reach(self) -> str:
        """In peak frequencies."""
        return f"{self.REACH:g} peak frequencies"

    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Significant height [m] and peak period [s], of `values` by name."""
        height = values.get(f"{self.name}.significant_height", self.significant_height)
        return [(height, values.get(f"{self.name}.peak_period", self.peak_period))]

    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        height = ask(_significant(self.name, self.significant_height))
        made_for = self.peak_period
        low, high = (factor * made_for for factor in PERIODS)
        text = (
            f"peak period, {low:g} to {high:g} s: the components' frequencies are made for "
            f"{made_for:g} s and stay; for another sea change waves.peak_period and build anew"
        )
        period = ask(
            Variable(
                f"{self.name}.peak_period", "s", text, start=made_for, minimum=low, maximum=high
            )
        )
        enhancement: Number = 1.0
        if self.enhancement is not None:
            text, (low, high) = "peak enhancement of the JONSWAP spectrum", PEAK_ENHANCEMENT
            enhancement = ask(
                Variable(
                    f"{self.name}.peak_enhancement", "1", text, start=self.enhancement,
                    minimum=low, maximum=high,
                )
            )  # fmt: skip
        amplitudes = component_amplitudes(
            self.omega.tolist(),
            self.widths.tolist(),
            significant_height=height,
            peak_period=period,
            enhancement=enhancement,
        )
        lucky = zip(amplitudes, self.luck.tolist(), strict=True)
        return self.omega.tolist(), [amplitude * luck for amplitude, luck in lucky]


@dataclass(frozen=True)
class FixedSea(WaveSystem):
    """Components of `amplitudes` (k,) [m] that stay, or follow the `significant_height` [m].

    `scaled`: that height is a parameter. `tunable_phases`: the phases are parameters. `apart`: each
    is judged as a regular wave. `at` [m] is where phases count, `peak` [s] the period of the
    largest part. `remarks` are doubts about a file, `told` what a run does with it. `untapered` [1]
    is the amplitudes' factor in statistics: that of a record without its tapered ends.
    """

    amplitudes: np.ndarray = field(repr=False)
    significant_height: float
    peak: float
    scaled: bool = False
    tunable_phases: bool = True
    apart: bool = False
    at: tuple[float, float] = (0.0, 0.0)
    ramp: float | None = None
    remarks: tuple[str, ...] = ()
    told: tuple[str, ...] = ()
    untapered: float = 1.0

    @property
    def in_statistics(self) -> float:
        """`untapered`."""
        return self.untapered

    @property
    def place(self) -> tuple[float, float]:
        """`at`."""
        return self.at

    @property
    def period(self) -> float:
        """`peak`."""
        return self.peak

    @property
    def default_ramp(self) -> float:
        """`ramp`, or as of any sea."""
        return super().default_ramp if self.ramp is None else self.ramp

    def doubts(self, values: Mapping[str, float]) -> list[str]:
        """`remarks`, and lines on waves as of any system, for `values` by name."""
        return [*self.remarks, *super().doubts(values)]

    def notes(self) -> tuple[str, ...]:
        """`told`."""
        return self.told

    @property
    def needed(self) -> float:
        """Where 3 % of the energy is left [rad/s]."""
        order = np.argsort(self.omega)
        energy = np.cumsum(self.amplitudes[order] ** 2)
        return float(self.omega[order][np.searchsorted(energy, 0.97 * energy[-1])])

    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Those of the sea, of `values` by name, or of each component if they are `apart`."""
        if self.apart:
            pairs = zip(self.omega.tolist(), self.amplitudes.tolist(), strict=True)
            return [(2.0 * a, 2 * math.pi / w) for w, a in pairs]
        height = values.get(f"{self.name}.significant_height", self.significant_height)
        return [(height, self.peak)]

    @property
    def _as_regular(self) -> bool:
        return self.apart

    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        omega, amplitudes = self.omega.tolist(), self.amplitudes.tolist()
        if not self.scaled:
            return omega, amplitudes
        height = self.significant_height
        given = ask(_significant(self.name, height))
        return omega, [given * (a / height) for a in amplitudes]

    def _phase(self, recorder: Recorder, k: int) -> Number:
        return super()._phase(recorder, k) if self.tunable_phases else float(self.phases[k])


def _significant(name: str, start: float) -> Variable:
    text = "significant wave height"
    return Variable(f"{name}.significant_height", "m", text, start=start, minimum=0.0)
