"""`m4e-fmi doctor` tells report what is installed and what is missing."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from m4e_fmi.cli.shared.log import show_result
from m4e_fmi.cli.shared.options import EXIT_FAILED


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `doctor`."""
    command.add_argument("--json", action="store_true", help="print findings as JSON")
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    from m4e_fmi import doctor

    findings = doctor.examine()
    show_result(doctor.report(findings), [asdict(one) for one in findings], options)
    return EXIT_FAILED if any(f.needed and not f.ok for f in findings) else 0
