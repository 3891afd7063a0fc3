"""`m4e-fmi validate` checks anyone's FMUs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from m4e_fmi.cli.shared.log import show_result
from m4e_fmi.cli.shared.options import EXIT_FAILED
from m4e_fmi.errors import YAML_SUFFIXES

EPILOG = (
    "Exit code 1 if there are errors, or a check failed to run; warnings and notes leave it at 0. "
    "See docs/validate.md."
)


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `validate`."""
    command.epilog = EPILOG
    command.add_argument("fmus", type=Path, nargs="+", metavar="FMU")
    command.add_argument("--json", action="store_true", help="print the findings as JSON")
    for flag, text in (("--only", "check this group only"), ("--skip", "leave this group out")):
        help_text = f"{text}; may be given again"
        command.add_argument(flag, action="append", default=[], metavar="GROUP", help=help_text)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    from m4e_fmi.files.document import Document
    from m4e_fmi.files.file_kinds import FMU, check_keys, check_suffix
    from m4e_fmi.fmu import validate_fmu
    from m4e_fmi.report import validation_text

    terminal = sys.stderr.isatty()

    def tell(text: str) -> None:
        if terminal:
            print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)

    for path in options.fmus:
        check_suffix(path, FMU)
        if path.suffix.lower() in (*YAML_SUFFIXES, ".json"):
            check_keys(path, Document.load(path).data, FMU)
    reports = []
    for path in options.fmus:
        name = path.name
        report = validate_fmu(
            path,
            only=options.only,
            skip=options.skip,
            tell=lambda group, name=name: tell(f"{name}: {group} …"),
        )
        tell("")
        reports.append(report)
        if not options.json:
            print(validation_text(report))
    if options.json:
        show_result("", [report.as_dict() for report in reports], options)
    return 0 if all(report.ok and report.complete for report in reports) else EXIT_FAILED
