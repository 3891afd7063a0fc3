"""`m4e-fmi study` makes many runs, and statistics of them in one file."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import add_log, print_files, runs_progress, say, show
from m4e_fmi.cli.shared.options import EXIT_FAILED, add_options, report_file
from m4e_fmi.errors import InputError


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `study`."""
    command.add_argument("study", type=Path, help="a study file (YAML)")
    command.add_argument(
        "--jobs",
        type=_positive,
        metavar="N",
        help="processes that make runs; default: one for each processor",
    )
    command.add_argument(
        "--fresh", action="store_true", help="make all runs, also those kept from earlier studies"
    )
    command.add_argument(
        "--output-file",
        type=Path,
        metavar="FILE",
        help="the result (.nc, or .csv as a long table); default build/NAME.nc",
    )
    add_options(
        command,
        "--report",
        help="write a report (.html): maps, curves, scatter, numbers and series in one file; "
        "default build/NAME.report.html",
    )
    add_options(command, "--build-folder")
    add_log(command, events=True)
    command.set_defaults(command=_run)


def _positive(text: str) -> int:
    """A number of processes, of an option."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, got {text!r}")
    return number


def _run(options: argparse.Namespace) -> int:
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.files.writing import check_suffix
    from m4e_fmi.study.given.study import load_study
    from m4e_fmi.study.report.of_study import report_of_study
    from m4e_fmi.study.run import SUFFIXES, run_study
    from m4e_fmi.study.shown.summary import summary

    if options.output_file:
        check_suffix(options.output_file, SUFFIXES, "the result of a study")
    study = load_study(options.study)
    output = options.output_file or options.build_folder / f"{file_stem(study.name)}.nc"
    report = report_file(options, output)
    if report and output.suffix.lower() != ".nc":
        message = "--report is made from a netCDF file"
        raise InputError.single(message, "let --output-file end with .nc", str(output))
    with runs_progress() as progress:
        outcome = run_study(
            study,
            output=output,
            build_directory=options.build_folder,
            jobs=options.jobs,
            fresh=options.fresh,
            progress=progress,
            tell=say,
        )
    show(summary(outcome))
    print_files([output])
    if report:
        print_files([report_of_study(output, report, command=options.given)])
    return EXIT_FAILED if outcome.failures else 0
