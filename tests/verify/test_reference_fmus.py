"""The Reference-FMUs of the Modelica Association, one at a time: a run gives what FMPy gives.

`M4E_FMI_REFERENCE_FMUS` names a folder with their FMUs of FMI 1.0, 2.0 and 3.0 for co-simulation in
subfolders 1, 2 and 3. They are built from their sources with CMake; those of FMI 1.0 are in
releases before 0.0.40.
"""

from __future__ import annotations

import os
from pathlib import Path

import fmpy
import numpy as np
import pytest

from m4e_fmi.cosim import Component, FmuFile, Simulation, System, load, run
from m4e_fmi.fmu import read_description

FOLDER = os.environ.get("M4E_FMI_REFERENCE_FMUS")
FMUS = sorted(Path(FOLDER).glob("[123]/[!C]*.fmu")) if FOLDER else []
"""All but Clocks, which is for scheduled execution only."""
NEAR = 1.5e-9
"""Seconds; communication points are whole nanoseconds, and steps end one before an event."""
TOLERANCES = {"Roberts": 4e-8}
"""It takes times for the same that are 1e-5 s apart, ten of its steps: whether it makes one more
may hang on the last bit of t + h, and with it 1e-6 s of y' = -0.04/s."""
SHARES = (1, 2, 5, 10)
"""Communication steps over the FMU's own."""


def test_the_folder_is_there() -> None:
    if not FOLDER:
        pytest.skip("M4E_FMI_REFERENCE_FMUS names no folder of the Reference-FMUs")
    assert {path.parent.name for path in FMUS} == {"1", "2", "3"}


def own_step(path: Path) -> float:
    """The step [s] by which the FMU goes inside; that of its default experiment."""
    description = fmpy.read_model_description(str(path), validate=False)
    return float(description.defaultExperiment.stepSize or 0.1)


def in_fmpy(expected: np.ndarray, name: str) -> np.ndarray:
    """The values (n,) of a variable, or of an element of an array of FMI 3.0, in FMPy's results."""
    array, _, place = name.partition("[")
    return expected[array][:, int(place[:-1]) - 1] if place else expected[name]


@pytest.mark.parametrize("share", [0.1, *SHARES])
@pytest.mark.parametrize("path", FMUS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_alone_it_gives_what_fmpy_gives(path: Path, tmp_path: Path, share: float) -> None:
    description = read_description(path)
    step = round(share * own_step(path), 9)
    stop = 20 * step if share < 1 else 12 * max(step, 1.0)
    system = System("s", (Component("a", FmuFile(path)),), (), Simulation(stop, step, "jacobi"))
    run(system, results=tmp_path / "r.nc")
    found = load(tmp_path / "r.nc")
    types = {v.name: v.type for v in description.variables.values()}
    names = [name for name in found.components["a"] if types[name] != "String"]
    told = {v.name for v in description.of_causality("output") if not v.name.endswith("]")}
    assert found.components["a"].keys() >= {name for name in told if types[name] != "Binary"}
    for name in found.components["a"].keys() - set(names):  # FMPy records no Strings
        assert set(found[f"a.{name}"].values) == {"Set me!"}
    expected = fmpy.simulate_fmu(
        str(path),
        start_time=0.0,
        stop_time=stop,
        output_interval=step,
        output=list(dict.fromkeys(name.partition("[")[0] for name in names)),
        validate=False,
    )
    assert abs(expected["time"][-1] - found.time[-1]) <= step * (1 + 1e-9)
    if not description.has_events:
        np.testing.assert_allclose(found.time, expected["time"], rtol=0, atol=NEAR)
    # with event mode there may be further points, at which a run ends
    places = np.searchsorted(expected["time"], found.time - NEAR)
    both = [(k, row) for k, row in enumerate(places) if row < len(expected)]
    both = [(k, row) for k, row in both if abs(expected["time"][row] - found.time[k]) <= NEAR]
    assert len(both) >= min(len(expected), len(found.time)) - 1
    mine, theirs = np.array(both).T
    for name in names:
        np.testing.assert_allclose(
            found[f"a.{name}"].values[mine],
            in_fmpy(expected, name)[theirs],
            rtol=1e-12,
            atol=TOLERANCES.get(path.stem, 1e-12),
            err_msg=name,
        )
