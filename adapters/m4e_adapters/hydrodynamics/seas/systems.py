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
from itertools import chain

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
SHORTEST = 1e-9  # ramp [s], so that a ramp_time set to 0 is none
FEWEST = 1e-3  # s, period of a regular wave


@dataclass(frozen=True, kw_only=True)
class WaveSystem(ABC):
    """One system of waves, whose parameters begin with `name`: "wave", or "wave[2]" of several.

    Attributes
    ----------
    direction : [deg], a parameter in space, which keeps its value if it is `fixed`.
    depth [m], gravity [m/s2].
    omega, phases, offsets : (k,) [rad/s, rad, rad], as configured; phases at `place` (x, y) [m]
        and t = 0, parameters unless they are not `tunable_phases`; offsets from the direction.
    period : [s] of the wave, of the peak, or of the largest component.
    ramp_time : [s] in which the waves grow.
    needed : frequency [rad/s] up to which the waves need computed excitation; `reach` in words.
    regular : True if it is one wave. `apart`: each component is judged as a regular wave.
    in_statistics : amplitudes that statistics are of over those that a run has [1].
    notes : what is done with a file.
    """

    name: str
    direction: float
    depth: float
    gravity: float
    omega: np.ndarray = field(repr=False)
    phases: np.ndarray = field(repr=False)
    offsets: np.ndarray = field(repr=False)
    period: float
    ramp_time: float
    needed: float
    reach: str = "97 % of their energy"
    place: tuple[float, float] = (0.0, 0.0)
    regular: bool = False
    apart: bool = False
    tunable_phases: bool = True
    in_statistics: float = 1.0
    notes: tuple[str, ...] = ()
    fixed: bool = False

    @abstractmethod
    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Heights [m] and periods [s] that say whether there are such waves.

        For `values` of parameters by name; those left out are as configured.
        """

    @abstractmethod
    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        """Frequencies and amplitudes, with parameters that `ask` gives."""

    @property
    def length(self) -> float:
        """Of a wave of `period` [m]."""
        k = wavenumber(np.array(2 * math.pi / self.period), depth=self.depth, gravity=self.gravity)
        return 2 * math.pi / float(k)

    def doubts(self, values: Mapping[str, float]) -> list[str]:
        """Lines on waves that break, or are too steep, for `values` by name."""
        water = {"depth": self.depth, "gravity": self.gravity}
        one = self.regular or self.apart
        found = [wave_doubts(h, t, regular=one, **water) for h, t in self.judged(values)]
        return [*chain.from_iterable(found)]

    def within(self, low: float, high: float) -> WaveSystem:
        """The system where forces are known from `low` to `high` [rad/s] only."""
        del low, high
        return self

    def record(self, recorder: Recorder, *, in_space: bool) -> RecordedWaves:
        """Record the parameters; the components of them. Only `in_space` the direction is one."""
        omega, amplitude = self._own(recorder.parameter)
        phase: list[Number] = self.phases.tolist()
        for k, start in enumerate(self.phases.tolist() if self.tunable_phases else ()):
            text = f"phase of the wave component of {self.omega[k]:.6g} rad/s at x = 0, t = 0"
            variable = Variable(f"{self.name}.phase[{k + 1}]", "rad", text, start=start)
            phase[k] = recorder.parameter(variable)
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

    def _record_ramp(self, recorder: Recorder) -> Number:
        """½(1 − cos π t/T) until t = T = `ramp_time`, then 1."""
        if self.ramp_time == 0.0:
            return 1.0
        text = "time in which the sea grows from nothing"
        variable = Variable(f"{self.name}.ramp_time", "s", text, start=self.ramp_time, minimum=0.0)
        length = recorder.parameter(variable)
        return 0.5 - 0.5 * cos(math.pi * minimum(recorder.time / maximum(length, SHORTEST), 1.0))


@dataclass(frozen=True, kw_only=True)
class RegularWave(WaveSystem):
    """A regular wave of `height` [m], with a period from `shortest` to `longest` [s]."""

    height: float
    shortest: float = FEWEST
    longest: float = math.inf

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


@dataclass(frozen=True, kw_only=True)
class SpectralSea(WaveSystem):
    """A sea of JONSWAP's form, whose parts of the frequency axis have `widths` (k,) [rad/s].

    `enhancement` None is the form of Pierson and Moskowitz. `luck` (k,) [1] multiplies amplitudes.
    """

    widths: np.ndarray = field(repr=False)
    luck: np.ndarray = field(repr=False)
    significant_height: float
    enhancement: float | None

    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Significant height [m] and peak period [s], of `values` by name."""
        height = values.get(f"{self.name}.significant_height", self.significant_height)
        return [(height, values.get(f"{self.name}.peak_period", self.period))]

    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        height = ask(_significant(self.name, self.significant_height))
        made_for = self.period
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


@dataclass(frozen=True, kw_only=True)
class FixedSea(WaveSystem):
    """Components of `amplitudes` (k,) [m] that stay, or follow the `significant_height` [m].

    `scaled`: that height is a parameter.
    """

    amplitudes: np.ndarray = field(repr=False)
    significant_height: float
    scaled: bool = False

    def judged(self, values: Mapping[str, float]) -> Sequence[tuple[float, float]]:
        """Those of the sea, of `values` by name, or of each component if they are `apart`."""
        if self.apart:
            pairs = zip(self.omega.tolist(), self.amplitudes.tolist(), strict=True)
            return [(2.0 * a, 2 * math.pi / w) for w, a in pairs]
        height = values.get(f"{self.name}.significant_height", self.significant_height)
        return [(height, self.period)]

    def _own(self, ask: Ask) -> tuple[Sequence[Number], Sequence[Number]]:
        omega, amplitudes = self.omega.tolist(), self.amplitudes.tolist()
        if not self.scaled:
            return omega, amplitudes
        height = self.significant_height
        given = ask(_significant(self.name, height))
        return omega, [given * (a / height) for a in amplitudes]


def _significant(name: str, start: float) -> Variable:
    text = "significant wave height"
    return Variable(f"{name}.significant_height", "m", text, start=start, minimum=0.0)
