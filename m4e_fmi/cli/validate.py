"""`m4e-fmi validate` checks anyone's FMUs."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.options import EXIT_FAILED


def add(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("validate", help="check FMUs: archive, description, first steps")
    command.add_argument("fmus", type=Path, nargs="+", metavar="FMU")
    command.add_argument("--json", action="store_true", help="print findings as JSON")
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    import json

    from m4e_fmi.cosim import check_fmu

    found = {str(path): check_fmu(path) for path in options.fmus}
    if options.json:
        print(json.dumps(found, indent=2))
    else:
        for path, findings in found.items():
            print(f"{path}: {'no finding' if not findings else f'{len(findings)} findings'}")
            for finding in findings:
                print(f"  {finding}")
    return EXIT_FAILED if any(found.values()) else 0
