"""A hydraulic power take-off: a cylinder, an accumulator and a motor.

`circuit` has the equations and `accumulator` solves them with SciPy; neither knows of FMI.
`program_fmu` and `python_fmu` make an FMU of them, each in its way, from the same `config`.
"""

from importlib.util import find_spec


def requirements() -> list[tuple[str, bool, str]]:
    """What this package needs of the machine, for `m4e-fmi doctor`: (what, is it there, remedy)."""
    there = find_spec("scipy") is not None
    return [("scipy", there, "found" if there else "pip install scipy")]
