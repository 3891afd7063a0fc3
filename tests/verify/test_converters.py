"""RM3 and the OSWEC by shape against published results; all responses against coupled runs.

The potential flow takes minutes where it is not in the cache.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.coefficient_files import RM3_SERIES
from support.converters import EXAMPLES, apart, copied, energy_lost

from m4e_adapters.hydrodynamics import HydrodynamicsConfig, make_hulls
from m4e_fmi.cosim import Kind, load_system, system_program
from m4e_fmi.simulate import Simulation, simulate

RM3, OSWEC = EXAMPLES / "rm3", EXAMPLES / "oswec"
PERIODS = np.linspace(4.0, 14.0, 11).tolist()
OF_RM3 = ["wec.body.float.z", "wec.body.float.theta", "wec.body.spar.z", "wec.joint.guide.q"]


def decay(path: Path) -> Simulation:
    """The motion of a system that is let go, for 100 s."""
    program = system_program(load_system(path))
    return simulate(program, stop_time=100.0, output_interval=0.1, tolerance=1e-9)


def test_rm3_by_shape() -> None:
    """The float released 1 m: heave of both bodies within 1 % of it of WEC-Sim's, RMS."""
    config = hydrodynamics(RM3 / "decay.yaml")
    hulls = make_hulls(config, RM3, progress=lambda _: None)
    assert sum(len(hull.panels.faces) for hull in hulls) <= 2500
    found = decay(RM3 / "decay.yaml")
    times, *others = np.loadtxt(RM3_SERIES, delimiter=",").T
    for body, other in zip(("float", "spar"), others, strict=True):
        heave = np.interp(times, found.time, found[f"wec.body.{body}.z"])
        rms = np.sqrt(np.mean((heave - other) ** 2))
        print(f"{body}: {rms:.2%} of the release")
        assert rms < 1e-2


def hydrodynamics(path: Path) -> HydrodynamicsConfig:
    """The configuration of the water of a system file."""
    sources = [component.source for component in load_system(path).components]
    (config,) = (s.config for s in sources if isinstance(s, Kind) and s.name == "hydrodynamics")
    assert isinstance(config, HydrodynamicsConfig)
    return config


def test_the_flap_by_shape() -> None:
    """The period of the decay from 10°, with the published coefficients and by shape."""
    periods = []
    for name in ("decay.yaml", "decay_capytaine.yaml"):
        found = decay(OSWEC / name)
        time, angle = np.asarray(found.time), np.asarray(found["wec.joint.hinge.q"])
        down = np.flatnonzero((angle[:-1] > 0.0) & (angle[1:] <= 0.0))
        crossings = time[down] + np.diff(time)[down] * angle[down] / (angle[down] - angle[down + 1])
        periods.append(float(np.diff(crossings).mean()))
    print("{:.3f} s, file {:.3f} s".format(*periods))
    assert periods[0] == pytest.approx(periods[1], rel=1.5e-2)


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("name", ["system.yaml", "system_wamit.yaml"])
def test_small_waves_at_rm3(name: str, period: float, tmp_path: Path) -> None:
    found = apart(copied(RM3 / name, tmp_path), period, OF_RM3, tmp_path)
    print(f"{period} s: {max(found):.1e}")
    assert max(found) < 3e-3


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("name", ["system.yaml", "system_capytaine.yaml"])
def test_small_waves_at_the_flap(name: str, period: float, tmp_path: Path) -> None:
    found = apart(copied(OSWEC / name, tmp_path), period, ["wec.joint.hinge.q"], tmp_path)
    print(f"{period} s: {max(found):.1e}")
    assert max(found) < 3e-3


@pytest.mark.parametrize(
    "path", [f / n for f in (RM3, OSWEC) for n in ("system.yaml", "decay.yaml")], ids=str
)
def test_energy(path: Path, tmp_path: Path) -> None:
    assert energy_lost(copied(path, tmp_path), tmp_path) < 1e-3
