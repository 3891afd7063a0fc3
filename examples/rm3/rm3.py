"""RM3 beside published curves: decay, response to waves, power. Run: python rm3.py

It draws build/rm3.png. "By shape" are decay.yaml and system.yaml, "WAMIT" the same with files
of WAMIT; the published decay is WEC-Sim's (HydroChrono, MIT), with the same files of WAMIT.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from m4e_fmi.analysis import equilibrium
from m4e_fmi.analysis.response import SeaResponse, WaveResponse, sea_response, wave_response
from m4e_fmi.cosim import load_system, system_in_waves, system_program
from m4e_fmi.simulate import Simulation, simulate

FOLDER = Path(__file__).parent
PUBLISHED = FOLDER.parents[1] / "tests" / "data" / "hydrodynamics" / "rm3_decay_wec_sim.csv"
SOURCES = {"by shape": "", "WAMIT": "_wamit"}
BODIES = ("float", "spar")
HEAVE = {body: f"wec.body.{body}.z" for body in BODIES}
POWER = "wec.load.pto.power"
PERIODS = np.linspace(4.0, 14.0, 41)
COLOURS = {"by shape": "#1f5f8b", "WAMIT": "#d1495b"}


def decay(suffix: str) -> Simulation:
    """The float let go at 1 m."""
    program = system_program(load_system(FOLDER / f"decay{suffix}.yaml"))
    return simulate(program, stop_time=100.0, output_interval=0.1, tolerance=1e-9)


def apart(found: Simulation) -> list[float]:
    """Root mean square [m] of the distance of each body's heave from the published one."""
    times, *others = np.loadtxt(PUBLISHED, delimiter=",").T
    pairs = zip(BODIES, others, strict=True)
    ours = ((np.interp(times, found.time, found[HEAVE[b]]), other) for b, other in pairs)
    return [float(np.sqrt(np.mean((heave - other) ** 2))) for heave, other in ours]


def responses(suffix: str) -> tuple[WaveResponse, SeaResponse]:
    """RAOs, and statistics in a sea of 2 m and 8 s."""
    path = FOLDER / f"system{suffix}.yaml"
    waves = system_in_waves(load_system(path), highest=2.5 * 2.0 * np.pi / 8.0)
    rest = equilibrium(waves.program)
    names = [*HEAVE.values(), "wec.body.float.theta"]
    small = wave_response(waves, rest, periods=PERIODS.tolist(), outputs=names)
    sea = waves.jonswap(2.0, 8.0, 3.3, 0.0)
    return small, sea_response(waves, rest, sea, outputs=[POWER])


def picture(decays: dict[str, Simulation], raos: dict[str, WaveResponse], path: Path) -> None:
    """Decay of both bodies, and the responses in heave."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 6), layout="constrained")
    rows: Any = figure.subplots(2, 2)
    times, *others = np.loadtxt(PUBLISHED, delimiter=",").T
    for axis, body, other in zip(rows[0], BODIES, others, strict=True):
        axis.plot(times, other, color="#9aa5ae", linewidth=4, label="WEC-Sim, published")
        for name, found in decays.items():
            axis.plot(found.time, found[HEAVE[body]], COLOURS[name], linewidth=1, label=name)
        axis.set(title=f"{body}: float let go at 1 m", xlabel="time [s]", ylabel="height [m]")
    rows[0, 0].set_xlim(0, 30)
    for axis, body in zip(rows[1], BODIES, strict=True):
        for name, found in raos.items():
            axis.plot(PERIODS, np.abs(found.of(HEAVE[body])), COLOURS[name], label=name)
        axis.set(
            title=f"{body} in waves", xlabel="period [s]", ylabel="heave [m/m]", ylim=(0, None)
        )
    for axis in rows.ravel():
        axis.spines[["top", "right"]].set_visible(False)
    rows[0, 0].legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Compute, compare, draw."""
    decays = {name: decay(suffix) for name, suffix in SOURCES.items()}
    for name, found in decays.items():
        shown = ", ".join(f"{b} {v:.3%}" for b, v in zip(BODIES, apart(found), strict=True))
        print(f"decay {name}, RMS from WEC-Sim, of the release: {shown}")
    found = {name: responses(suffix) for name, suffix in SOURCES.items()}
    for name, (_, sea) in found.items():
        print(f"power {name}, JONSWAP sea of 2 m and 8 s: {-sea.mean(POWER) / 1e3:.1f} kW")
    picture(decays, {name: small for name, (small, _) in found.items()}, Path("build/rm3.png"))
    print("wrote build/rm3.png")


if __name__ == "__main__":
    main()
