# %% [markdown]
# # A heaving sphere beside published curves
# The sphere of IEA OES Task 10 (F. Wendt et al., "Ocean Energy Systems Wave Energy Modelling Task",
# J. Mar. Sci. Eng. 7(11), 379, 2019) is 10 m in diameter and floats half immersed in deep water.
# Several codes computed its free decay and its response to regular waves, with and without a power
# take-off; their curves in `published/` are those of HydroChrono (NREL, MIT licence).

# %%
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from m4e_fmi.analysis import equilibrium
from m4e_fmi.analysis.response import sea_response, wave_response
from m4e_fmi.cosim import load_system, run, system_in_waves, system_program
from m4e_fmi.simulate import simulate

FOLDER = Path(__file__).parent
EQUILIBRIUM = -2.0  # m, height of the centre of gravity
HEIGHT, HEAVE = "body.body.sphere.z", "body.joint.rail.q"
RELEASES = (1.0, 3.0, 5.0)  # m above the equilibrium
STEEPNESS = 0.002  # height over length of the regular waves whose power is computed

Floats = NDArray[np.float64]


def table(name: str) -> tuple[list[str], Floats]:
    """Names of the columns of a file in `published/`, and its rows."""
    path = FOLDER / "published" / f"{name}.csv"
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    return names, np.loadtxt(path, delimiter=",", skiprows=1)


# %% [markdown]
# **Decay.** The linear system is all equations: no coupling steps are needed. The pressure on the
# wetted part, in `nonlinear.yaml`, is a Python FMU: that system is co-simulated.


# %%
def linear_decay(release: float) -> tuple[Floats, Floats]:
    """Times [s] and height above equilibrium [m] after a release at `release` [m]."""
    program = system_program(load_system(FOLDER / "system.yaml"))
    start = {HEIGHT: EQUILIBRIUM + release}
    found = simulate(program.with_start(start), stop_time=30.0, output_interval=0.1)
    return np.asarray(found.time), np.asarray(found[HEIGHT]) - EQUILIBRIUM


def nonlinear_decay(release: float, folder: Path) -> tuple[Floats, Floats]:
    """The same with hydrostatics of the wetted part; FMUs and results are left in `folder`."""
    system = load_system(FOLDER / "nonlinear.yaml")
    system = system.changed(start={HEIGHT: EQUILIBRIUM + release})
    outcome = run(system, results=folder / f"decay_{release:g}m.nc", build_directory=folder)
    results = outcome.results()
    return results.time, results[HEIGHT].values - EQUILIBRIUM


def deviation(curve: tuple[Floats, Floats], times: Floats, values: Floats) -> float:
    """Root mean square difference [m] of a curve from `values` (n,) [m] at `times` (n,) [s]."""
    return float(np.sqrt(np.mean((np.interp(times, *curve) - values) ** 2)))


# %% [markdown]
# **Response.** Each published period has a published damping of the take-off, the one that absorbs
# most: |Z(ω)|, the modulus of the sphere's own mechanical impedance. The mean power of a linear
# damper c in a wave that moves the sphere with the amplitude z is ½ c ω² z².


# %%
def responses(periods: Floats, dampings: Floats) -> Floats:
    """Heave per wave amplitude [m/m] at each period [s] with its own damping [N.s/m], (n,)."""
    waves = system_in_waves(load_system(FOLDER / "absorber.yaml"), highest=2 * np.pi / min(periods))
    found = []
    for period, damping in zip(periods.tolist(), dampings.tolist(), strict=True):
        rest = equilibrium(waves.program, at={"pto.damping": damping})
        response = wave_response(waves, rest, periods=[period], outputs=[HEAVE])
        found.append(abs(response.of(HEAVE)[0]))
    return np.array(found)


def regular_powers(periods: Floats, dampings: Floats) -> tuple[Floats, Floats]:
    """Heights [m] of regular waves of `STEEPNESS`, and mean powers [W] absorbed in them, (n,)."""
    waves = system_in_waves(load_system(FOLDER / "absorber.yaml"), highest=2 * np.pi / min(periods))
    heights, powers = STEEPNESS * 9.81 * periods**2 / (2 * np.pi), []
    for period, damping, height in zip(
        periods.tolist(), dampings.tolist(), heights.tolist(), strict=True
    ):
        rest = equilibrium(waves.program, at={"pto.damping": damping})
        response = wave_response(
            waves, rest, periods=[period], outputs=["pto.power"], height=height
        )
        powers.append(response.mean("pto.power")[0])
    return heights, np.array(powers)


def sea_power() -> tuple[float, float]:
    """Mean power [W] in the sea of `absorber.yaml`: by its linear response, and in ten minutes."""
    system = load_system(FOLDER / "absorber.yaml")
    waves = system_in_waves(system, highest=2 * np.pi / 2.0)
    rest = equilibrium(waves.program)
    sea = waves.jonswap(1.0, 6.0, 3.3, 0.0)
    linear = sea_response(waves, rest, sea, outputs=["pto.power"]).mean("pto.power")
    found = simulate(system_program(system), stop_time=660.0, output_interval=0.1)
    settled = np.asarray(found.time) >= 60.0
    return linear, float(np.mean(np.asarray(found["pto.power"])[settled]))


# %% [markdown]
# The pictures: our curves are lines, published ones are marks.


# %%
def picture_of_decays(folder: Path) -> dict[float, float]:
    """Draw decays from all releases; the nonlinear ones' difference from CFD over the release."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 8), layout="constrained")
    found = {}
    places = figure.subplots(3, 1, sharex=True)
    for axes, release in zip(places, RELEASES, strict=True):
        nonlinear = nonlinear_decay(release, folder)
        axes.plot(*linear_decay(release), color="0.6", label="linear")
        axes.plot(*nonlinear, color="tab:blue", label="hydrostatics of the wetted part")
        if release != 3.0:  # of which no curve is published
            names, rows = table(f"decay_{release:g}m")
            for name, marker in (("InWave+H (Lin)", "x"), ("NREL (CFD)", "o")):
                values = rows[:, names.index(f"{name} [m]")]
                axes.plot(rows[::5, 0], values[::5], marker, ms=4, mfc="none", label=name)
            cfd = rows[:, names.index("NREL (CFD) [m]")]
            found[release] = deviation(nonlinear, rows[:, 0], cfd) / release
        axes.set(ylabel="heave [m]", title=f"released at {release:g} m")
        axes.legend(loc="upper right")
    places[-1].set(xlabel="time [s]", xlim=(0, 30))
    figure.savefig(folder / "decays.png", dpi=120)
    return found


def picture_of_responses(folder: Path) -> tuple[Floats, Floats, Floats]:
    """Draw responses; periods [s], responses without and with take-off [m/m]."""
    from matplotlib.figure import Figure

    names, rows = table("heave_responses")
    periods, dampings = rows[:, 0], rows[:, 1]
    free, damped = responses(periods, 0 * dampings), responses(periods, dampings)
    figure = Figure(figsize=(8, 7), layout="constrained")
    places = figure.subplots(2, 1, sharex=True)
    for axes, title, ours in zip(places, ("free", "damped"), (free, damped), strict=True):
        axes.plot(periods, ours, color="tab:blue", label="m4e_fmi")
        for k, name in enumerate(names):
            if name.endswith(title):
                axes.plot(periods, rows[:, k], "x+1o^"[k % 5], mfc="none", label=name.split()[0])
        axes.set(ylabel="heave over wave amplitude", title=title)
        axes.legend()
    places[-1].set(xlabel="wave period [s]")
    figure.savefig(folder / "responses.png", dpi=120)
    return periods, free, damped


# %%
if __name__ == "__main__":
    build = Path("build")
    build.mkdir(exist_ok=True)
    for release, difference in picture_of_decays(build).items():
        print(f"decay from {release:g} m: {100 * difference:.2f} % of the release from CFD")
    periods, free, damped = picture_of_responses(build)
    names, rows = table("heave_responses")
    heights, powers = regular_powers(periods, rows[:, 1])
    print("\nperiod [s]   heave, free   damped   wave height [m]   mean power [W]")
    for line in zip(periods, free, damped, heights, powers, strict=True):
        print("{:10.1f} {:13.4f} {:8.4f} {:17.3f} {:16.1f}".format(*line))
    linear, simulated = sea_power()
    print(f"\nmean power in the sea: {linear:.0f} W, in ten minutes of it {simulated:.0f} W")
