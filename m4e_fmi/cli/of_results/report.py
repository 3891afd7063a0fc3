"""`m4e-fmi report` writes the report of results that are there already."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `report`."""
    command.add_argument(
        "results",
        type=Path,
        metavar="FILE",
        help="results (.nc) of run, simulate or study, also of a run that was killed",
    )
    command.add_argument(
        "--output-file",
        type=Path,
        metavar="FILE",
        help="the page (.html); default FILE with the end .report.html",
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.study import write_report

    print_files([write_report(options.results, options.output_file)])
