"""`m4e-fmi info` shows what is in a model, a system or an FMU."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import print_files, show_result
from m4e_fmi.cli.shared.options import add_options, is_system, load_model, load_system


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `info`."""
    command.add_argument("source", type=Path, help="a model, system, .ssp or .fmu file")
    command.add_argument(
        "--json", action="store_true", help="the complete description of an FMU, as JSON"
    )
    command.add_argument(
        "--output-file", type=Path, metavar="FILE", help="draw a system here (.png, .svg or .pdf)"
    )
    command.add_argument("--algorithm", help="of a system, instead of the one in its file")
    add_options(command, "--build-folder")
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.report import check_picture_path, draw_system, fmu_text

    is_fmu = options.source.suffix.lower() == ".fmu"
    if is_fmu:
        from m4e_fmi.fmu import fmu_contents

        show_result(fmu_text(options.source), fmu_contents(options.source), options)
    elif is_system(options.source):
        from m4e_fmi.cosim import prepare
        from m4e_fmi.cosim.preparation.components import waiting
        from m4e_fmi.cosim.wiring.prepared import outline

        if options.output_file:
            check_picture_path(options.output_file)
        system = load_system(options.source).changed(algorithm=options.algorithm)
        folder = options.build_folder
        later, drafts = waiting(system, folder)
        if later and not options.output_file:
            print(outline(system, later))
            return
        prepared = prepare(system, build_directory=folder, drafts=drafts)
        print(prepared)
        if options.output_file:
            print_files([draw_system(prepared, options.output_file)])
    else:
        from m4e_fmi.multibody import model_program
        from m4e_fmi.report import model_tables

        model = load_model(options.source)
        print(f"{model_tables(model)}\n\n{model_program(model)}")
