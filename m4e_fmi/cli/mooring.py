"""`m4e-fmi mooring` shows mooring lines at rest: profiles, stiffness, offsets, broken lines."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from m4e_fmi.cli.shared.log import add_log, print_files, say, show_result
from m4e_fmi.cli.shared.options import BUILD_FOLDER, add_options, finite
from m4e_fmi.errors import InputError


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `mooring`."""
    command.add_argument(
        "source",
        type=Path,
        metavar="FILE",
        help="a system file, a MoorDyn v2 input file, or results (.nc): lines and their tensions",
    )
    command.add_argument(
        "--at",
        nargs="+",
        type=finite,
        default=[],
        metavar="T",
        help="of results: times [s] of profiles; default: that of the largest tension",
    )
    command.add_argument(
        "--component", default="", metavar="NAME", help="of a system with several moorings: which"
    )
    command.add_argument(
        "--about",
        nargs=3,
        type=finite,
        metavar=("X", "Y", "Z"),
        help="point [m] of force and stiffness; default: the mean of the fairleads",
    )
    command.add_argument(
        "--directions",
        nargs="+",
        type=finite,
        default=[0.0, 180.0],
        metavar="DEG",
        help="in which fairleads are moved, from X to Y; default 0 180",
    )
    command.add_argument(
        "--fairleads",
        nargs="+",
        default=[],
        metavar="NAME",
        help="those that move, as of one of several bodies; default: all",
    )
    command.add_argument(
        "--start",
        choices=("values", "equilibrium"),
        default="values",
        help="of a system: fairleads where it starts (default), or where it is at rest",
    )
    add_options(command, "--json", "--build-folder")
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="picture, build/NAME_mooring.png"
    )
    add_options(command, "--no-plot")
    add_log(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.cosim import mooring
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.report import check_picture_path, plot_lines, plot_mooring
    from m4e_fmi.results.results_file import NETCDF

    if options.output_file:
        check_picture_path(options.output_file)
    of_results = options.source.suffix.lower() == NETCDF
    foreign = ("component", "about", "fairleads", "json", "no_plot") if of_results else ("at",)
    if wrong := [name for name in foreign if getattr(options, name)]:
        message = f"--{wrong[0].replace('_', '-')} is not for {options.source}"
        raise InputError.single(message, "leave it out; see m4e-fmi mooring --help")
    if of_results:
        picture = options.output_file or Path(BUILD_FOLDER) / f"{options.source.stem}_lines.png"
        print_files([plot_lines(options.source, picture, times=options.at)], options)
        return
    data = mooring(
        options.source,
        component=options.component,
        about=options.about,
        directions=[math.radians(angle) for angle in options.directions],
        fairleads=options.fairleads,
        start=options.start,
        build_directory=options.build_folder,
        tell=say,
    )
    show_result(str(data), data.to_dict(), options)
    if not options.no_plot:
        default = Path(BUILD_FOLDER) / f"{file_stem(data.title)}_mooring.png"
        print_files([plot_mooring(data, options.output_file or default)], options)
