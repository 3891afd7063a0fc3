"""The buoy of the examples on its lines in still water: at rest, and let go."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from m4e_fmi.analysis import equilibrium, linearize, modes
from m4e_fmi.cosim import System, at_equilibrium, load_system, run, system_program
from m4e_fmi.results.results_file import Results

EXAMPLE = Path(__file__).parents[2] / "examples" / "moored_buoy"
SURGE = "buoy.body.float.x"


def still(folder: Path, heavier: float = 1.0) -> System:
    """The example without waves; its mass times `heavier`, with the same weight."""
    folder.mkdir(exist_ok=True)
    model = (EXAMPLE / "buoy.model.yaml").read_text("utf-8")
    for old, new in (
        ("value: 143.2", f"value: {143.2 * heavier!r}"),
        ("gravity: 9.81", f"gravity: {9.81 / heavier!r}"),
    ):
        assert model.count(old) == 1
        model = model.replace(old, new)
    (folder / "buoy.model.yaml").write_text(model, "utf-8")
    lines = (EXAMPLE / "system.yaml").read_text("utf-8").splitlines()
    text = "\n".join(line for line in lines if "waves:" not in line)
    (folder / "system.yaml").write_text(text, "utf-8")
    return load_system(folder / "system.yaml")


def results(system: System, folder: Path, stop_time: float) -> Results:
    system = system.changed(stop_time=stop_time)
    file, build = folder / "r.nc", folder / "build"
    return run(system, results=file, build_directory=build, certify=False).results()


def periods(folder: Path, heavier: float) -> tuple[float, float]:
    """That of surge [s] of the linear equations, and of a decay from 5 cm."""
    system = still(folder, heavier)
    whole = system_program(system, settled=["mooring"], build_directory=folder / "build")
    rest = equilibrium(whole)
    linear = linearize(whole, at=rest)
    found = modes(linear)
    mode = found.participation[[v.name for v in linear.states].index(SURGE)].argmax()
    start = {SURGE: 0.05, "buoy.body.float.z": rest["buoy.body.float.z"]}
    decay = results(system.changed(start=start), folder, 200.0)
    t, x = np.asarray(decay.time), np.asarray(decay[SURGE])
    k = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    crossings = t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k])
    return float(2 * np.pi / abs(found.eigenvalues[mode])), float(np.diff(crossings).mean())


def test_the_stiffness_of_the_lines_is_that_of_decays(tmp_path: Path) -> None:
    """T² = 4 π² (m + what moves with it)/K: between two masses, what the lines add cancels."""
    (linear, decayed), (heavy, heavy_decayed) = (
        periods(tmp_path / f"m{factor:g}", factor) for factor in (1.0, 10.0)
    )
    assert heavy**2 - linear**2 == pytest.approx(heavy_decayed**2 - decayed**2, rel=1e-3)
    assert 1.0 < heavy_decayed / heavy < 1.01 < decayed / linear < 1.06


def test_a_run_from_rest_stays_there(tmp_path: Path) -> None:
    """It moves by less than 10 µm in a minute; from the start in the file, by decimetres."""
    away = still(tmp_path).changed(start={"buoy.body.float.z": -1.5, "buoy.body.float.theta": 0.05})
    rest = at_equilibrium(away, build_directory=tmp_path / "build")
    for system, low, high in ((away, 0.1, 1.0), (rest, 0.0, 1e-5)):
        found = results(system, tmp_path, 60.0)
        for name in ("x", "z", "theta"):
            assert np.ptp(np.asarray(found[f"buoy.body.float.{name}"])) < high
        assert np.ptp(np.asarray(found["buoy.body.float.z"])) >= low
