"""A heavy body on an elastic rope, coupled with the line system by velocity Verlet.

The flexible pendulum of the M4E paper, section 4.4: M = 1e5 kg, EA = 1e9 N, l0 = 100.5 m,
g = 9.80665 m/s², released at (10, −100.00216) m. Its exact non-linear periods, from the ODE solved
to 1e-12: sway 20.1367 s, heave 10.0683 s and 0.62988 s.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.lines_in_waves import lines_of, mooring_of, started

from m4e_adapters.moordyn import MooringConfig, mooring
from m4e_fmi.files.document import Document

MASS, STIFFNESS, LENGTH, GRAVITY = 1e5, 1e9, 100.5, 9.80665
SPRING = STIFFNESS / LENGTH
HALF_ROPE = 1e-3 * LENGTH / 2  # [kg] whose weight, not inertia, MoorDyn puts on the fairlead
START = (10.0, -100.00216)

ROPE = """\
water: {{density: 0, depth: 1000}}
line_types:
  rope: {{diameter: 1.0e-3, mass_per_length: 1.0e-3, axial_stiffness: 1.0e+9,
          axial_damping: {damping}, drag_coefficient: 0, added_mass_coefficient: 0}}
anchors: {{top: [0, 0]}}
fairleads: [bob]
lines:
  rope: {{type: rope, from: top, to: bob, unstretched_length: 100.5, segments: 1}}
"""


def coupled(step: float, stop: float, *, damping: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and x, z, vx, vz (n, 4) of velocity Verlet with the rope in MoorDyn."""
    made = mooring(Document.parse(ROPE.format(damping=damping * LENGTH)).validate(MooringConfig))
    lines = lines_of(made, net=None)
    count = round(stop / step)
    (x, z), u, w = START, 0.0, 0.0
    lines.start([(x, z)], [(u, w)])
    states = np.empty((count + 1, 4))
    states[0] = x, z, u, w
    for k in range(count):
        ((force_x, force_z),) = lines.force
        u += force_x / MASS * step / 2
        w += (force_z / MASS - GRAVITY) * step / 2
        lines.advance(k * step, step, [(x, z)], [(u, w)])
        x, z = x + u * step, z + w * step
        ((force_x, force_z),) = lines.force
        u += force_x / MASS * step / 2
        w += (force_z / MASS - GRAVITY) * step / 2
        states[k + 1] = x, z, u, w
    lines.close()
    return np.arange(count + 1) * step, states


def exact(times: np.ndarray, *, damping: float = 0.0) -> np.ndarray:
    """x, z, vx, vz (n, 4) of the same body on a massless rope."""

    def rates(_, state):
        x, z, u, w = state
        length = math.hypot(x, z)
        pull = SPRING * (length - LENGTH) + damping * (x * u + z * w) / length
        down = GRAVITY * (1 + HALF_ROPE / MASS)
        return u, w, -pull * x / length / MASS, -pull * z / length / MASS - down

    solution = solve_ivp(
        rates, (0, times[-1]), (*START, 0, 0), method="DOP853", rtol=1e-12, atol=1e-12, t_eval=times
    )
    return solution.y.T


def error(step: float, stop: float, *, damping: float = 0.0) -> float:
    """Largest distance [m] from the exact path."""
    times, states = coupled(step, stop, damping=damping)
    return float(np.abs(states[:, :2] - exact(times, damping=damping)[:, :2]).max())


def crossings(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Times at which `values` crosses zero upwards."""
    k = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    return times[k] - values[k] * (times[k + 1] - times[k]) / (values[k + 1] - values[k])


def mean_period(times: np.ndarray, values: np.ndarray) -> float:
    found = crossings(times, values)
    return float((found[-1] - found[0]) / (len(found) - 1))


def peak_period(times: np.ndarray, values: np.ndarray, *, shortest: float, longest: float) -> float:
    """Period of the largest spectral line between two, of a windowed and padded signal."""
    window = (values - values.mean()) * np.hanning(len(values))
    spectrum = np.abs(np.fft.rfft(window, 16 * len(values)))
    frequency = np.fft.rfftfreq(16 * len(values), times[1] - times[0])
    inside = (frequency > 1 / longest) & (frequency < 1 / shortest)
    return float(1 / frequency[inside][spectrum[inside].argmax()])


@pytest.mark.verifies(
    "sway period of a mass on a MoorDyn line",
    analytic="exact nonlinear equation",
    tolerance="1e-4 s",
)
def test_periods_at_a_millisecond():
    times, states = coupled(0.001, 61.0)
    # Verlet changes a frequency by (ω h)²/24: 4e-9 for sway, 4e-6 for the rope's own 10 rad/s
    assert mean_period(times, states[:, 0]) == pytest.approx(20.1367, abs=1e-4)
    sag = states[:, 1] + np.hypot(states[:, 0], states[:, 1]).mean()
    slow = peak_period(times, sag, shortest=5.0, longest=15.0)
    fast = peak_period(times, states[:, 1], shortest=0.3, longest=2.0)
    # heave is twice the sway in frequency; six periods in a window padded 16 times: 1/1000 of it
    assert slow == pytest.approx(10.0683, rel=5e-3)
    # 97 periods: a bin of 1/(16 · 97) = 6e-4
    assert fast == pytest.approx(0.62988, rel=6e-4)


@pytest.mark.parametrize("damping", [0.0, 2e4])
def test_second_order_against_the_exact_equation(damping):
    coarse = error(0.02, 15.0, damping=damping)
    middle = error(0.01, 15.0, damping=damping)
    fine = error(0.005, 15.0, damping=damping)
    # the next term of the error is (ω h)² = 4 % and 1 % of the first
    assert coarse / middle == pytest.approx(4, rel=0.05)
    assert middle / fine == pytest.approx(4, rel=0.02)
    # phase error of the rope's mode, ω t (ω h)²/24 with ω = 9.975 rad/s, times its amplitude M g/k
    assert fine < MASS * GRAVITY / SPRING * 9.975 * 15 * (9.975 * 0.005) ** 2 / 24


@pytest.mark.verifies(
    "energy of a mass on a MoorDyn line", analytic="conservation", tolerance="1.2e-5"
)
def test_energy_does_not_drift():
    times, states = coupled(0.001, 30.0)
    x, z, u, w = states.T
    stretch = np.maximum(np.hypot(x, z) - LENGTH, 0)
    energy = MASS * (u**2 + w**2) / 2 + (MASS + HALF_ROPE) * GRAVITY * z + SPRING * stretch**2 / 2
    exchanged = MASS * GRAVITY * (LENGTH - math.sqrt(LENGTH**2 - START[0] ** 2))
    # Verlet's energy oscillates by (ω h)²/8 = 1.2e-5 of the rope mode's, and does not grow
    drift = np.abs(energy[times > 25].mean() - energy[times < 5].mean())
    assert drift < 1.2e-5 * exchanged


@pytest.mark.verifies(
    "swing of a buoy on a tether, without a fairlead",
    independent="period of a pendulum with added mass, for small angles",
    tolerance="1e-3, for an amplitude of 0.02 rad and a tether of 0.05 % of the buoy's mass",
)
def test_a_buoy_swings_on_its_tether() -> None:
    """2π √((m + Ca ρ V) L/((ρ V − m) g)), of half a period between two turning points."""
    length, mass, volume, added = 20.0, 400.0, 1.0, 0.5
    lines = started(
        mooring_of(
            "dimensions: 3\nwater: {density: 1025, depth: 100, gravity: 9.80665}\n"
            "line_types:\n"
            "  rope: {diameter: 1.0e-3, mass_per_length: 0.01, axial_stiffness: 1.0e+8,\n"
            "         axial_damping_ratio: 0.1, drag_coefficient: 0, added_mass_coefficient: 0}\n"
            "anchors: {a: [0, 0, -60]}\n"
            f"points: {{buoy: {{position: [0.4, 0, {-60 + length - 0.004}], mass: {mass},\n"
            f"          volume: {volume}, added_mass_coefficient: {added}}}}}\n"
            f"lines: {{l: {{type: rope, from: a, to: buoy, unstretched_length: {length}, "
            "segments: 1}}\n"
            "static_equilibrium: false\n"
        )
    )
    inertia, lift = mass + added * 1025 * volume, (1025 * volume - mass) * GRAVITY
    period = 2 * np.pi * np.sqrt(inertia * length / lift)
    step, places = period / 400, []
    for k in range(400):
        lines.advance(k * step, step, [], [])
        places.append(lines.node_position(0, 1)[0])
    lines.close()
    crossings = [k for k in range(399) if places[k] * places[k + 1] < 0]
    times = [step * (k + 1 + places[k] / (places[k] - places[k + 1])) for k in crossings]
    assert times == pytest.approx([period / 4, period * 3 / 4], rel=1e-3)
