"""Checks of anyone's FMU: what it says, and whether it does what it says.

`runner` runs each group of checks in a process of its own (`worker`), where a `probe` (for FMI 3.0:
`probe_3`, with `elements` of arrays) calls the FMU's library and writes every call into a journal
first. One module per group: `archive` with `variables` and `units` need no FMU code; `starting`
comes next and tells the others what works; then `dependencies`, `derivatives`, `directional`,
`states`, `elsewhere`, `instances`, `solutions`, `values`, `phases`, `parameters`. Each has a
function `check` that yields findings.
"""

from m4e_fmi.fmu.validation.findings import Finding, Group, Report
from m4e_fmi.fmu.validation.runner import GROUPS, validate_fmu

__all__ = ["GROUPS", "Finding", "Group", "Report", "validate_fmu"]
