"""`m4e-fmi compare` compares results with a reference, variable by variable."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files, show_result
from m4e_fmi.cli.shared.options import BUILD_FOLDER, EXIT_FAILED, add_options, finite
from m4e_fmi.errors import InputError, Problem


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `compare`."""
    files = "results (netCDF), or a table of any tool (CSV)"
    command.add_argument("file", type=Path, metavar="FILE", help=files)
    command.add_argument("reference", type=Path, metavar="REFERENCE", help=files)
    _add_pairs(command)
    _add_part(command)
    _add_measure(command)
    add_options(command, "--json")
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="picture; default build/NAME_compared.png"
    )
    add_options(command, "--no-plot")
    command.set_defaults(command=_run)


def _add_pairs(command: argparse.ArgumentParser) -> None:
    """Add the options of the variables that belong together."""
    command.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="COLUMN=VARIABLE",
        help="a name in the reference, and that of the same variable in FILE, as "
        "heave=buoy.body.float.z; may be given again. Others belong together by their names. With "
        "factor and offset in the variable's unit: 'heave * -1 + 0.5=buoy.body.float.z'",
    )
    command.add_argument(
        "--variables", nargs="+", metavar="NAME", help="of FILE; default all that both have"
    )


def _add_part(command: argparse.ArgumentParser) -> None:
    """Add the options of the part of the records that is compared."""
    command.add_argument(
        "--time-shift",
        type=finite,
        default=0.0,
        metavar="S",
        help="is added to the times of REFERENCE; default 0",
    )
    for flag, text in (("--start-time", "start"), ("--stop-time", "end")):
        command.add_argument(
            flag, type=finite, metavar="S", help=f"{text} of the part that is compared"
        )


def _add_measure(command: argparse.ArgumentParser) -> None:
    """Add the options of how large a difference is, and may be."""
    command.add_argument(
        "--tolerance",
        type=finite,
        metavar="X",
        help="largest difference that is accepted, divided as --relative-to says; default none",
    )
    command.add_argument(
        "--relative-to",
        choices=("range", "amplitude", "value"),
        default="range",
        help="of the reference: largest minus smallest value (default), √2 standard deviations, "
        "largest magnitude",
    )
    command.add_argument(
        "--floor",
        type=finite,
        default=0.0,
        metavar="X",
        help="least divisor in Eq. (10) of the paper, in the unit of each variable; default 0",
    )


def _run(options: argparse.Namespace) -> int:
    from m4e_fmi.analysis.comparison import compare
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.report import (
        check_picture_path,
        difference_json,
        difference_text,
        plot_differences,
    )

    default = Path(BUILD_FOLDER) / f"{file_stem(options.file.stem)}_compared.png"
    picture: Path = options.output_file or default
    check_picture_path(picture)
    found = compare(
        options.file,
        options.reference,
        variables=options.variables,
        mapping=_mapping(options.map),
        time_shift=options.time_shift,
        start_time=options.start_time,
        stop_time=options.stop_time,
        tolerance=options.tolerance,
        relative_to=options.relative_to,
        floor=options.floor,
    )
    show_result(difference_text(found), difference_json(found), options)
    if not options.no_plot:
        plot_differences(found, picture)
        print_files([picture], options)
    return 0 if found.is_within else EXIT_FAILED


def _mapping(given: Sequence[str]) -> dict[str, str]:
    """Names in FILE by those in the reference; InputError with all pairs that are wrong."""
    pairs = [text.rpartition("=") for text in given]
    problems = [
        Problem(f"--map {text}: expected COLUMN=VARIABLE", "as --map heave=buoy.body.float.z")
        for text, (column, _, variable) in zip(given, pairs, strict=True)
        if not (column.strip() and variable.strip())
    ]
    found = [(column.strip(), variable.strip()) for column, _, variable in pairs]
    counts = Counter(column for column, _ in found)
    problems += [
        Problem(f"column {column!r} is mapped {count} times", "map it once")
        for column, count in counts.items()
        if count > 1 and column
    ]
    InputError.raise_for(problems)
    return dict(found)
