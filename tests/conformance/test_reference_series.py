"""Every library FMU gives the series beside its README: fmus/m4e_fmus/<kind>/reference.csv.

The FMU of reference.yaml is stepped by plain FMPy for 20 s at 0.05 s while its point or body moves
as in `motion` below. Those that are programs give the same bits natively, and are valid in FMI 3.0.
`pytest --update` writes the series anew.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from m4e_fmi.files.document import Document
from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program

FMUS = Path(__file__).parents[2] / "fmus" / "m4e_fmus"
STOP, STEP, EVERY = 20.0, 0.05, 10  # s, s, steps between rows of the series
MOVED: dict[str, tuple[tuple[float, float], list[str]]] = {
    "linear_pto": ((0.0, -3.0), ["pto"]),
    "joint_pid": ((0.0, 0.0), ["elbow"]),
    "mooring": ((-4.0, -2.0), ["fairlead"]),
    "hydrodynamics": ((0.0, -1.2), ["float"]),
    "morison": ((0.0, -6.0), ["spar"]),
    "sea": ((0.0, -1.0), ["fairlead"]),
    "hull_pressure": ((0.0, -1.2), ["float"]),
    "sum": ((1.0, 2.0), ["float", "barge"]),
    "table": ((0.0, 0.0), []),
    "wind": ((0.0, 12.0), ["mast"]),
}
"""Kind → position at rest, connectors that move."""
# Nine digits are written, and solvers repeat to rounding: with other BLAS kernels and numbers of
# threads the same nine come out. The hydrodynamics is in deep water for that: in finite depth the
# fit of Capytaine's kernel makes 1e-7 of rounding errors on one machine, 1e-5 between machines.
TOLERANCE = 1e-6


def motion(rest: tuple[float, float], t: np.ndarray) -> dict[str, np.ndarray]:
    """A slow surge of 1 m and a heave and pitch of 0.5 m and 0.05 rad, starting at rest."""
    ramp = 1 - np.cos(0.4 * t)
    rate = 0.4 * np.sin(0.4 * t)
    wave, wave_rate = 1 - np.cos(0.9 * t), 0.9 * np.sin(0.9 * t)
    return {
        "x": rest[0] + 0.5 * ramp,
        "vx": 0.5 * rate,
        "z": rest[1] + 0.25 * wave,
        "vz": 0.25 * wave_rate,
        "theta": 0.025 * wave,
        "omega": 0.025 * wave_rate,
        "q": 0.025 * wave,
        "u": 0.025 * wave_rate,
    }


def stepped(kind: str, folder: Path) -> dict[bool, np.ndarray]:
    """Structured arrays of time and all outputs of the Python (False) and native (True) FMU."""
    module = import_module(f"m4e_fmus.{kind}")
    config = Document.load(FMUS / kind / "reference.yaml").validate(module.KIND.config)
    source = module.KIND.build(config, name=kind, folder=FMUS / kind, progress=lambda _: None)
    natives = (False, True) if isinstance(source, Program) else (False,)
    if isinstance(source, Program):
        newer = build_fmu(source, folder / f"{kind}_3.fmu", native=True, fmi="3")
        assert validate_fmu(str(newer)) == []
    return {
        native: series(kind, build_fmu(source, folder / f"{kind}_{native}.fmu", native=native))
        for native in natives
    }


def series(kind: str, fmu: Path) -> np.ndarray:
    t = np.arange(round(STOP / STEP) + 1) * STEP
    names = {v.name for v in fmpy.read_model_description(str(fmu)).modelVariables}
    rest, connectors = MOVED[kind]
    moved = motion(rest, t)
    columns = {f"{c}.{key}": value for c in connectors for key, value in moved.items()}
    columns = {"time": t, **{k: v for k, v in columns.items() if k in names}}
    signals = np.array(
        list(zip(*columns.values(), strict=True)), dtype=[(name, float) for name in columns]
    )
    given: dict[str, Any] = {"input": signals} if len(columns) > 1 else {}
    return fmpy.simulate_fmu(
        str(fmu), stop_time=STOP, step_size=STEP, output_interval=STEP, **given
    )


@pytest.mark.parametrize("kind", sorted(MOVED))
def test_reference_series(kind: str, tmp_path: Path, request: pytest.FixtureRequest):
    both = stepped(kind, tmp_path)
    for native in both.values():
        assert np.array_equal(native, both[False])
    result = both[False][::EVERY]
    path = FMUS / kind / "reference.csv"
    names = result.dtype.names
    assert names is not None
    if request.config.getoption("--update"):
        rows = np.array([list(row) for row in result])
        np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="", fmt="%.9g")
    reference = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    assert reference.dtype.names == names
    for name in names:
        limit = TOLERANCE * np.abs(reference[name]).max() + 1e-12
        assert result[name] == pytest.approx(reference[name], rel=TOLERANCE, abs=limit)
