"""Checking anyone's FMU: its archive, its description, its first steps.

The steps are made in a process of their own: an FMU that crashes is a finding, not an accident.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

from m4e_fmi.cosim.binary import Binary
from m4e_fmi.cosim.instance import WARNING, Instance
from m4e_fmi.errors import M4eError
from m4e_fmi.fmu import Description, read_description

STEPS = 3
DEFAULT_STEP = 0.01  # s, where the FMU names none
TIME_LIMIT = 120.0  # s of wall time for all steps together
_ELSEWHERE = "import sys; from m4e_fmi.cosim.check import main; sys.exit(main(sys.argv[1]))"


def check_fmu(path: str | Path) -> list[str]:
    """Findings, one text each; none if all is well.

    Looked at: the model description against FMI's schema and
    rules (FMPy's validator), and, twice in one process of its own, instantiation, initialisation,
    three steps, finite outputs and termination. InputError if the archive is not even an FMU that
    this platform could run.
    """
    read_description(path)
    from fmpy.validation import validate_fmu

    return [*(str(finding) for finding in validate_fmu(str(path))), *_stepped_elsewhere(path)]


def _stepped_elsewhere(path: str | Path) -> list[str]:
    command = [sys.executable, "-c", _ELSEWHERE, str(path)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return [f"{STEPS} steps did not end within {TIME_LIMIT:g} s"]
    if done.returncode < 0:
        return [f"the process that ran it was ended by signal {-done.returncode}"]
    if done.returncode:
        return [done.stderr.strip() or f"the process that ran it ended with {done.returncode}"]
    return []


def _steps(description: Description) -> None:
    """Make the first steps; M4eError says what went wrong."""
    size = description.step_size or DEFAULT_STEP
    name = description.identifier
    with (
        Binary(description, origin=f"{name} ({description.path.name})") as binary,
        Instance(name, description, binary) as instance,
    ):
        instance.setup(start=0.0, stop=STEPS * size, tolerance=None)
        instance.enter_initialization()
        instance.exit_initialization()
        names = [v.name for v in description.of_causality("output") if v.type == "Real"]
        values = np.zeros(len(names))
        read, step = instance.getter(names, values), instance.stepper()
        for k in range(STEPS + 1):
            if (status := read()) > WARNING:
                instance.fail(status, "fmi2GetReal")
            if not np.isfinite(values).all():
                instance.not_finite(names, values)
            if k < STEPS and (status := step(k * size, size, 1)) > WARNING:
                instance.fail(status, "fmi2DoStep", size)
            instance.time = (k + 1) * size


def main(path: str) -> int:
    """Instantiate and step the FMU at `path` twice; the exit code of the process that does it."""
    try:
        description = read_description(path)
        for _ in range(2):
            _steps(description)
    except M4eError as error:
        print(error, file=sys.stderr)
        return 1
    return 0
