"""`validate` on the Reference-FMUs of the Modelica Association: no error where others find none.

The folder M4E_FMI_REFERENCE_FMUS holds their FMUs in 1, 2 and 3, by FMI version, as their build
makes them. FMU_CHECK is the FMU compliance checker (fmuCheck), which judges FMI 1.0 and 2.0;
without it, and of FMI 3.0, FMPy's validator and simulation judge.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu as validated_by_fmpy

from m4e_fmi.fmu import Finding, validate_fmu

FOLDER = os.environ.get("M4E_FMI_REFERENCE_FMUS", "")
CHECKER = os.environ.get("FMU_CHECK", "")
FMUS = sorted(Path(FOLDER).glob("[123]/*.fmu")) if FOLDER else []
TRUE = {
    # its setStartValues leaves the parameter x0 as it was
    "3/StateSpace": {"instances.reset"},
    # its y3 is 1 - y1 - y2, with dependencies=""
    "3/Roberts": {"dependencies.missing"},
}
"""Errors that are right, of FMUs that only FMPy judges."""

pytestmark = pytest.mark.skipif(not FMUS, reason="M4E_FMI_REFERENCE_FMUS names no folder with FMUs")


def monitored_outputs(path: Path, folder: Path) -> list[str]:
    """Errors that another checker finds in the FMU."""
    if CHECKER and path.parent.name != "3":
        command = [CHECKER, "-l", "2", "-o", str(folder / "out.csv"), str(path)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        lines = (done.stdout + done.stderr).splitlines()
        return [line for line in lines if line.startswith(("[ERROR]", "[FATAL]"))]
    problems = list(validated_by_fmpy(str(path)))
    experiment = fmpy.read_model_description(str(path), validate=False).defaultExperiment
    start = float(experiment.startTime or 0.0) if experiment else 0.0
    try:  # not to the end, which is 1e8 s for some
        fmpy.simulate_fmu(
            str(path), validate=False, start_time=start, stop_time=start + 1, output_interval=0.1
        )
    except Exception as error:  # noqa: BLE001  FMPy raises plain exceptions
        problems.append(str(error))
    return problems


@pytest.mark.parametrize("path", FMUS, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_no_error_where_others_find_none(path: Path, tmp_path: Path) -> None:
    name = f"{path.parent.name}/{path.stem}"
    if path.stem == "Clocks":
        pytest.skip("clocks are not supported")
    others = monitored_outputs(path, tmp_path)
    report = validate_fmu(path)
    errors: list[Finding] = [
        f for f in report.of_severity("error") if f.id not in TRUE.get(name, ())
    ]
    print(f"{name}: {len(errors)} errors, others {len(others)}: {others[:3]}")
    assert report.complete
    assert not errors or others, errors
