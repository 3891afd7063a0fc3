"""A hinged flap beside published coefficients: decay, waves, power. Run: python oswec.py

It draws build/oswec.png. "By shape" are decay.yaml and system.yaml, "published" the same with the
coefficients of Capytaine 2.3.1 in WEC-Sim Applications.
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
SOURCES = {"by shape": "", "published": "_capytaine"}
ANGLE, POWER = "wec.joint.hinge.q", "wec.load.pto.power"
PERIODS = np.linspace(4.0, 14.0, 41)
COLOURS = {"by shape": "#1f5f8b", "published": "#d1495b"}


def decay(suffix: str) -> Simulation:
    """The flap let go at 10°, its take-off idle."""
    program = system_program(load_system(FOLDER / f"decay{suffix}.yaml"))
    return simulate(program, stop_time=100.0, output_interval=0.1, tolerance=1e-9)


def period(found: Simulation) -> float:
    """Mean period [s] of the decay, between crossings of rest."""
    time, angle = np.asarray(found.time), np.asarray(found[ANGLE])
    down = np.flatnonzero((angle[:-1] > 0.0) & (angle[1:] <= 0.0))
    crossings = time[down] + np.diff(time)[down] * angle[down] / (angle[down] - angle[down + 1])
    return float(np.diff(crossings).mean())


def responses(suffix: str) -> tuple[WaveResponse, SeaResponse]:
    """RAOs, and statistics in a sea of 1.2 m and 10 s."""
    path = FOLDER / f"system{suffix}.yaml"
    waves = system_in_waves(load_system(path), highest=2.0 * np.pi / 4.0)
    rest = equilibrium(waves.program)
    small = wave_response(waves, rest, periods=PERIODS.tolist(), outputs=[ANGLE])
    sea = waves.jonswap(1.2, 10.0, 3.3, 0.0)
    return small, sea_response(waves, rest, sea, outputs=[POWER])


def picture(decays: dict[str, Simulation], raos: dict[str, WaveResponse], path: Path) -> None:
    """Decay, and the response of the angle."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.4), layout="constrained")
    axes: Any = figure.subplots(1, 2)
    for name, found in decays.items():
        axes[0].plot(found.time, np.degrees(found[ANGLE]), COLOURS[name], label=name)
        axes[1].plot(PERIODS, np.degrees(np.abs(raos[name].of(ANGLE))), COLOURS[name], label=name)
    axes[0].set(title="let go at 10°", xlabel="time [s]", ylabel="angle [deg]")
    axes[1].set(title="in waves", xlabel="period [s]", ylabel="angle [deg/m]", ylim=(0, None))
    for axis in axes:
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Compute, compare, draw."""
    decays = {name: decay(suffix) for name, suffix in SOURCES.items()}
    for name, found in decays.items():
        print(f"decay {name}: period {period(found):.3f} s")
    found = {name: responses(suffix) for name, suffix in SOURCES.items()}
    for name, (_, sea) in found.items():
        print(f"power {name}, JONSWAP sea of 1.2 m and 10 s: {-sea.mean(POWER) / 1e3:.1f} kW")
    picture(decays, {name: small for name, (small, _) in found.items()}, Path("build/oswec.png"))
    print("wrote build/oswec.png")


if __name__ == "__main__":
    main()
