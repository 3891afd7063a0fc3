"""Checks of anyone's FMU: its description, and whether the FMU does what the description says.

Start reading at `run`: it checks the description here (`description`), and all else in a host, a
process that starts one more for each group of checks. There a `probe` calls the FMU's library and
writes every call into a journal first. `checks/` has the groups, generators of findings: `start`
comes first and tells the others what works.
"""

from m4e_fmi.fmu.validation.findings import Finding, Group, Report
from m4e_fmi.fmu.validation.run import GROUPS, validate_fmu

__all__ = ["GROUPS", "Finding", "Group", "Report", "validate_fmu"]
