"""Checks of anyone's FMU: its description, and whether the FMU does what the description says.

Start reading at `runner`: it checks the description here (`description/`), and all else in `host`,
a process that starts one more for each group of checks (`worker`). There a `probe` calls the FMU's
library and writes every call into a journal first. `checks/` has one module per group, whose
function `check` yields findings; `capabilities` comes first and tells the others what works.
`sampling/` chooses inputs, times and points at which the checks look.
"""

from m4e_fmi.fmu.validation.findings import Finding, Group, Report
from m4e_fmi.fmu.validation.runner import GROUPS, validate_fmu

__all__ = ["GROUPS", "Finding", "Group", "Report", "validate_fmu"]
