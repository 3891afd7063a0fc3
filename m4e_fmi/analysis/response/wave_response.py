"""Response to regular waves: transfer functions (RAOs) of outputs per wave amplitude.

Small waves have that of the linear equations, waves of a height that of `steady_motion`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from m4e_fmi.analysis.attitudes import attitudes
from m4e_fmi.analysis.points import Floats, OperatingPoint, local_parts, motion, place
from m4e_fmi.analysis.response.linear_equations import Limits, LinearEquations
from m4e_fmi.analysis.response.local_equations import LocalEquations
from m4e_fmi.analysis.response.steady_motion import steady_motion
from m4e_fmi.analysis.response.waves import Complex, InWaves
from m4e_fmi.analysis.rest_notes import growth
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.program import TIME, Program, Variable
from m4e_fmi.shown import listing
from m4e_fmi.units import POWER

INPUTS = "inputs.power"
GUESS = 1e-2
"""Of the first guess of a motion: its decay over its frequency."""
ROUNDING = 1e-9
"""Of the largest amplitude of the same unit; smaller ones have no phase."""
THIRD = 0.05
"""Third harmonic over first from which on it is told."""
COUNTS = 1e-3
"""Part of the largest output of its unit from which on a third harmonic matters."""


@dataclass(frozen=True)
class WaveResponse:
    """First harmonics of outputs per wave amplitude: y = mean + Re[of a e^{−iωt}].

    A crest of the wave, of amplitude a, is at x = y = 0 at t = 0. `omega` (k,) [rad/s],
    `directions` (d,) [rad]; `values` (d, k, outputs) complex, per m. `height` [m] is that of the
    waves, 0 of small ones. `means` (d, k, outputs) are over a period, in the outputs' units;
    `third` (d, k, outputs) the amplitude of the third harmonic over that of the first [1],
    0 of powers and of what is small beside others of its unit;
    `states` (d, k, n) are those of the states, as `values`. `notes` say where the response is in
    doubt.
    """

    point: OperatingPoint = field(repr=False)
    omega: Floats
    directions: Floats
    height: float
    outputs: tuple[Variable, ...]
    values: Complex = field(repr=False)
    means: Floats = field(repr=False)
    third: Floats = field(repr=False)
    states: Complex = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def periods(self) -> Floats:
        """2π/ω [s], (k,)."""
        return 2.0 * np.pi / self.omega

    def of(self, output: str, direction: int = 0) -> Complex:
        """The response of an output (k,), in its unit per m, to the `direction` of that number."""
        return self.values[direction, :, place(output, self.outputs)]

    def mean(self, output: str, direction: int = 0) -> Floats:
        """The mean of an output (k,) in its unit, as of a power, in waves of that direction."""
        return self.means[direction, :, place(output, self.outputs)]

    @property
    def phases(self) -> Floats:
        """Lag of each output behind the crest at x = y = 0 [rad], (d, k, outputs).

        nan where the amplitude is rounding beside the largest of its unit: of motions that a
        symmetry excludes.
        """
        sizes = np.nan_to_num(np.abs(self.values))
        units = [v.unit for v in self.outputs]
        alike = np.array([[unit == other for other in units] for unit in units])
        largest = np.array([sizes[:, :, own].max(axis=(1, 2)) for own in alike]).T
        return np.where(sizes > ROUNDING * largest[:, None], np.angle(self.values), np.nan)

    def __repr__(self) -> str:
        waves = f"waves of {self.height:g} m" if self.height else "small waves"
        return listing(
            f"WaveResponse of {self.point.program.name!r} to {waves}: {len(self.omega)} periods, "
            f"{len(self.directions)} directions",
            outputs=self.outputs,
        )


def wave_response(
    waves: InWaves,
    point: OperatingPoint,
    *,
    periods: ArrayLike,
    directions: ArrayLike | None = None,
    outputs: Sequence[str] | None = None,
    height: float = 0.0,
    progress: Callable[[str], object] | None = None,
) -> WaveResponse:
    """The response to regular waves of `periods` (k,) [s] about `point`, an equilibrium.

    `directions` (d,) [rad] are those that waves travel to, by default the configured one. `outputs`
    names outputs or states, by default `usual_outputs`. `height` [m] is that of the waves, crest to
    trough; 0: small waves. `progress` is told each wave of a height. InputError for periods that
    are not positive and unknown names, RunError where no steady motion is found; where one is found
    for other waves, nan and a note.
    """
    given_periods = np.atleast_1d(np.asarray(periods, dtype=float))
    positive = np.isfinite(given_periods).all() and (given_periods > 0).all()
    if given_periods.ndim != 1 or not (positive and given_periods.size):
        raise InputError.single("wave periods must be positive numbers of seconds, at least one")
    omega = 2.0 * np.pi / given_periods
    if not (np.isfinite(height) and height >= 0):
        raise InputError.single(f"the wave height must not be negative, got {height:g} m")
    given = waves.own_direction(point) if directions is None else directions
    angles = np.atleast_1d(np.asarray(given, dtype=float))
    if not np.isfinite(angles).all():
        raise InputError.single("directions of waves must be finite numbers of radians")
    names = usual_outputs(waves.program, powers=height > 0) if outputs is None else outputs
    powers = {v.name for v in waves.program.outputs if v.unit == POWER}
    if not height and (wrong := [name for name in names if name in powers]):
        message = f"{', '.join(wrong)}: powers are of second order, in small waves 0"
        raise InputError.single(message, "give the waves a height (--height), or take a sea")
    local = LocalEquations(waves.program, point, inputs=waves.inputs, outputs=names)
    forces = [waves.per_amplitude(omega, angle, point) for angle in angles.tolist()]
    values, states, means, third, told = _responses(
        local, forces, omega, height / 2.0, progress or (lambda _: None)
    )
    notes = [*doubts(waves, local, float(omega.max()), small=height == 0), *told]
    if height:
        most = waves.breaking_heights(omega)
        if (broken := np.flatnonzero(height > most)).size:
            shown = ", ".join(f"{2.0 * np.pi / w:.4g}" for w in omega[broken])
            lowest = broken[np.argmin(most[broken])]
            notes.append(
                f"waves of {height:.4g} m break at periods of {shown} s (at "
                f"{2.0 * np.pi / omega[lowest]:.4g} s above {most[lowest]:.3g} m): there are no "
                "such waves: take lower or longer ones"
            )
        limits = Limits(waves, point)
        if limits.outputs:
            pairs = zip(states, forces, strict=True)
            rows = [np.abs(limits.harmonics(own, per_wave)) for own, per_wave in pairs]
            largest = np.nan_to_num(np.array(rows)).max(axis=(0, 1))
            notes += limits.passed(height / 2.0 * largest, "an amplitude of")
    third = np.where(_counts(local, values), third, 0.0)
    for j, v in enumerate(local.outputs):
        largest = third[:, :, j].max(axis=0)
        if largest.max(initial=0.0) > THIRD:
            period = 2.0 * np.pi / omega[int(np.argmax(largest))]
            notes.append(
                f"third harmonic of {v.name}: up to {100 * largest.max():.2g} % of the first, at "
                f"{period:.4g} s"
            )
    return WaveResponse(
        point=point, omega=omega, directions=angles, height=height, outputs=local.outputs,
        values=values, means=means, third=third, states=states, notes=tuple(notes),
    )  # fmt: skip


def _responses(
    local: LocalEquations,
    forces: Sequence[Complex],
    omega: Floats,
    amplitude: float,
    progress: Callable[[str], object],
) -> tuple[Complex, Complex, Floats, Floats, list[str]]:
    """Values, states, means, third harmonics and notes as of `WaveResponse`, also of what is small.

    For `forces` (k, m) [SI] of each direction and `omega` (k,) [rad/s], of waves of an `amplitude`
    [m]; 0: small waves. RunError if no steady motion is found in any wave.
    """
    rest = LinearEquations.of(local)
    decay = GUESS if amplitude else 0.0
    linear = [rest.harmonics(omega, per_wave, decay=decay) for per_wave in forces]
    states, values = (np.array(part) for part in zip(*linear, strict=True))
    means = np.tile(rest.outputs, (*values.shape[:2], 1))
    third = np.zeros(values.shape)
    places = list(np.ndindex(values.shape[:2])) if amplitude else []
    drifts: dict[str, None] = {}
    failures: list[RunError] = []
    for number, place_of in enumerate(places):
        progress(f"steady motion in wave {number + 1} of {len(places)}")
        d, k = place_of
        guess = states[place_of]
        try:
            found = steady_motion(local, float(omega[k]), forces[d][k], guess, amplitude)
        except RunError as error:
            failures.append(error)
            for part in (states, values, means):
                part[place_of] = np.nan
            continue
        states[place_of], values[place_of], means[place_of], third[place_of], drift = found
        drifts |= {drift: None} if drift else {}
    if failures and len(failures) == len(places):
        raise failures[0]
    notes = [str(error) for error in failures]
    notes += [f"nothing balances the mean force on {name}: it drifts" for name in drifts]
    return values, states, means, third, notes


def usual_outputs(program: Program, *, powers: bool = True) -> list[str]:
    """Coordinates (of free attitudes roll, pitch, yaw), and outputs that are `powers`."""
    known = {v.name for v in program.outputs}
    moved = [program.states[q].name for q, _ in motion(program)]
    turned = [f"{a.owner}.{name}" for a in attitudes(program) for name in ("phi", "theta", "psi")]
    found = [v.name for v in program.outputs if v.unit == POWER and not v.name.endswith(INPUTS)]
    return [*moved, *(name for name in turned if name in known), *(found if powers else ())]


def doubts(waves: InWaves, local: LocalEquations, highest: float, *, small: bool) -> Iterator[str]:
    """Lines on what makes a response to waves up to `highest` [rad/s] doubtful."""
    if found := growth(local.at_rest):
        yield str(found) if found.within else f"at rest {found}: the response has no meaning"
    if highest > waves.highest * (1 + 1e-9):
        period = 2.0 * np.pi / waves.highest
        yield (
            f"waves shorter than {period:.4g} s are beyond the computed forces, which decrease as "
            "1/omega^3 from there"
        )
    if any(TIME in local.point.program.dependencies(node) for node in waves.program.rates):
        yield f"loads depend on time: they are taken at t = {local.point.time:g} s"
    yield from _settled(local, small=small)
    for part, forces in waves.forces.items():
        yield from (f"{part}: {note}" if part else note for note in forces.notes)
    if small and local.curved:
        yield "small waves: drag and all that is not linear count as at rest"


def _settled(local: LocalEquations, *, small: bool) -> Iterator[str]:
    """Lines on components that take part by their law at rest, and on outputs of these."""
    names = [part.name for part, _ in local_parts(local.point.program)]
    if not names:
        return
    stay = "" if small else "linear about the rest in still water, and "
    yield (
        f"{', '.join(names)} (settled): {stay}without damping and inertia: near a resonance the "
        "response is too large, by far if that damping would limit it; compare with `m4e-fmi run` "
        "in regular waves of that period"
    )
    own = [v.name for v in local.outputs if v.name.partition(".")[0] in names]
    if own:
        yield f"{', '.join(own)}: quasi-static, without dynamics; the largest may be much larger"


def _counts(local: LocalEquations, values: Complex) -> NDArray[np.bool_]:
    """True where a first harmonic, `values` (d, k, outputs), is not small beside those of its unit.

    Never for powers, which have twice the frequency of the motion.
    """
    sizes = np.nan_to_num(np.abs(values))
    found = np.zeros(sizes.shape, dtype=bool)
    units = [v.unit for v in local.outputs]
    for j, unit in enumerate(units):
        alike = [k for k, other in enumerate(units) if unit == other]
        found[:, :, j] = (unit != POWER) & (
            sizes[:, :, j] > COUNTS * sizes[:, :, alike].max(axis=2)
        )
    return found
