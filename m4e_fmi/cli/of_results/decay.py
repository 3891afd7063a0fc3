"""`m4e-fmi decay` finds period and damping from a record of a free decay."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files, show_result
from m4e_fmi.cli.shared.options import BUILD_FOLDER, add_options, finite
from m4e_fmi.errors import InputError, Problem, RunError


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `decay`."""
    command.add_argument(
        "record", type=Path, metavar="FILE", help="a table with a time, or results (netCDF)"
    )
    command.add_argument(
        "--variable",
        metavar="NAME",
        help="the motion: a column of a table, or component.variable of results; default the only "
        "one beside the time",
    )
    for flag, text in (
        ("--from", "start of the part that is fitted; default the first peak after the release"),
        ("--to", "its end; default the end of the record"),
    ):
        command.add_argument(flag, type=finite, metavar="S", dest=flag[2:] + "_", help=text)
    for flag, text in (
        ("--mass", "mass or moment of inertia with added mass, for the coefficients"),
        ("--stiffness", "or the stiffness"),
    ):
        command.add_argument(flag, type=finite, default=0.0, metavar="SI", help=text)
    add_options(command, "--json")
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="picture; default build/NAME_decay.png"
    )
    add_options(command, "--no-plot")
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.analysis.decay import fit_decay
    from m4e_fmi.report import check_picture_path, decay_json, decay_text, plot_decay
    from m4e_fmi.results.compared_file import read_measured

    _check(options)
    path: Path = options.record
    picture = options.output_file or Path(BUILD_FOLDER) / f"{path.stem}_decay.png"
    check_picture_path(picture)
    motion = read_measured(path, options.variable)
    try:
        found = fit_decay(motion.time, motion.values, start=options.from_, end=options.to_)
    except InputError as error:
        (problem,) = error.problems
        raise InputError.single(problem.message, problem.remedy, str(path)) from None
    except RunError as error:
        raise RunError(f"{path}: {error.message}", error.remedy) from None
    inertia = {"mass": options.mass, "stiffness": options.stiffness}
    values = decay_json(found, motion, **inertia)
    show_result(decay_text(found, motion, **inertia), values, options)
    if not options.no_plot:
        plot_decay(found, motion, picture)
        print_files([picture], options)


def _check(options: argparse.Namespace) -> None:
    """InputError with all options that do not go together."""
    wrong = []
    if options.mass and options.stiffness:
        message = "--mass and --stiffness: the period gives the one from the other"
        wrong.append(Problem(message, "leave one out"))
    wrong += [
        Problem(f"--{name} must be positive")
        for name in ("mass", "stiffness")
        if getattr(options, name) < 0.0
    ]
    InputError.raise_for(wrong)
