# %% [markdown]
# # Two flaps on one base
# A device like the floating oscillating surge wave-energy converter (FOSWEC), of dimensions of our
# own: two flaps, 10 m wide and 8 m deep, on hinges 1.5 m below them, 16 m apart; below them a base
# on the sea bed at 13 m. A damper in each hinge is the power take-off, stops end the motion at 25°.
#
# The coefficients in `flaps.nc` come from the shapes in `shapes.yaml` (`coefficients.py`): the base
# takes part as an obstacle, and each flap feels the waves that the other makes.

# %%
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.analysis.response import sea_response, wave_response
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.simulate import simulate

FOLDER = Path(__file__).parent
FLAPS = ("fore", "aft")
ANGLES = tuple(f"device.body.{flap}.theta" for flap in FLAPS)
POWERS = tuple(f"device.load.{flap}_pto.power" for flap in FLAPS)
PERIODS = np.linspace(4.0, 14.0, 41)  # s
DAMPING = "device.c"
HIGHEST = 2 * np.pi / 3.0  # rad/s

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


# %% [markdown]
# **Response** to small waves, with the take-offs and without: angle per wave amplitude. Without
# damping the resonance at 14 s is hardly damped by the waves, which is why such flaps need a
# take-off that is strong there.


# %%
def responses(damping: float | None = None, periods: Floats = PERIODS) -> dict[str, Complex]:
    """Complex angles [rad/m] of the flaps at `periods` [s], with another `damping` [N.m.s/rad]."""
    waves = system_in_waves(load_system(FOLDER / "system.yaml"), highest=HIGHEST)
    rest = equilibrium(waves.program, at={} if damping is None else {DAMPING: damping})
    found = wave_response(waves, rest, periods=periods, outputs=ANGLES)
    return {flap: found.of(angle) for flap, angle in zip(FLAPS, ANGLES, strict=True)}


# %% [markdown]
# **Decay** of the fore flap from 10°, without take-offs: the aft flap, at rest before, follows.


# %%
def decay(damping: float) -> tuple[Floats, dict[str, Floats]]:
    """Times [s] and angles [rad] of both flaps."""
    program = system_program(load_system(FOLDER / "system.yaml").changed(start={DAMPING: damping}))
    still = {"sea.wave.significant_height": 0.0, "device.joint.fore_hinge.q": np.radians(10.0)}
    found = simulate(program.with_start(still), stop_time=60.0, output_interval=0.1)
    return np.asarray(found.time), {
        flap: np.asarray(found[angle]) for flap, angle in zip(FLAPS, ANGLES, strict=True)
    }


def natural_periods() -> list[tuple[float, float]]:
    """Period [s] and damping ratio of both motions without take-offs, in still water."""
    program = system_program(load_system(FOLDER / "system.yaml").changed(start={DAMPING: 0.0}))
    found = modes(linearize(program, at=equilibrium(program)))
    rows = [k for k, value in enumerate(found.eigenvalues) if 10 < period(value) < 20]
    return [(period(v), -v.real / abs(v)) for v in found.eigenvalues[rows] if v.imag > 0]


def period(value: complex) -> float:
    """Period [s] of an eigenvalue."""
    return float(2 * np.pi / abs(value)) if value else np.inf


# %% [markdown]
# **Irregular sea.** A load's power is what it adds to the energy: what a take-off absorbs is the
# negative of it.


# %%
def sea_powers() -> tuple[list[float], list[float]]:
    """Mean powers [W] absorbed by fore and aft flap: of the linear response, of ten minutes."""
    system = load_system(FOLDER / "system.yaml")
    waves = system_in_waves(system, highest=HIGHEST)
    sea = sea_response(
        waves, equilibrium(waves.program), waves.jonswap(1.5, 8.0, 3.3, 0.0), outputs=POWERS
    )
    # means of ten minutes need no more digits; by default it takes twice the time
    found = simulate(system_program(system), stop_time=660.0, output_interval=0.1, tolerance=1e-4)
    settled = np.asarray(found.time) >= 60.0
    simulated = [-float(np.mean(np.asarray(found[p])[settled])) for p in POWERS]
    return [-sea.mean(power) for power in POWERS], simulated


# %%
def picture(folder: Path) -> None:
    """Draw responses and decay."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 7), layout="constrained")
    above, below = figure.subplots(2, 1)
    for label, damping, style in (("with take-offs", None, "-"), ("without", 0.0, "--")):
        for k, (flap, values) in enumerate(responses(damping).items()):
            angle = np.degrees(np.abs(values))
            above.plot(PERIODS, angle, style, color=f"C{k}", label=f"{flap}, {label}")
    above.set(xlabel="wave period [s]", ylabel="angle [deg/m]", yscale="log")
    times, angles = decay(0.0)
    for flap, values in angles.items():
        below.plot(times, np.degrees(values), label=flap)
    below.set(xlabel="time [s]", ylabel="angle [deg]", title="the fore flap let go at 10°")
    for axes in (above, below):
        axes.legend()
    figure.savefig(folder / "two_flaps.png", dpi=120)


# %%
if __name__ == "__main__":
    build = Path("build")
    build.mkdir(exist_ok=True)
    print("period [s]   fore [deg/m]   aft [deg/m]")
    periods = np.array([4.0, 6.0, 8.0, 10.0, 12.0, 14.0])
    for line in zip(periods, *responses(periods=periods).values(), strict=True):
        print("{:10.0f} {:14.2f} {:13.2f}".format(line[0], *np.degrees(np.abs(line[1:]))))
    for length, ratio in natural_periods():
        print(f"natural period {length:.2f} s, damping {100 * ratio:.2f} %")
    for flap, *power in zip(FLAPS, *sea_powers(), strict=True):
        print("{}: mean power in the sea {:.0f} W, in ten minutes {:.0f} W".format(flap, *power))
    picture(build)
