"""`m4e-fmi build` builds the FMU of a model, or all of a system."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.options import add_build_folder, is_system, print_files, say
from m4e_fmi.errors import InputError


def add(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("build", help="build the FMU of a model, or all of a system")
    command.add_argument("source", type=Path, help="a model or system file")
    command.add_argument(
        "--native", action="store_true", help="of a model: no Python inside, model exchange too"
    )
    command.add_argument(
        "--fmi", choices=("2", "3"), default="2", help="version of FMI of --native; default 2"
    )
    add_build_folder(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.fmu import build_fmu

    if is_system(options.source):
        from m4e_fmi.cosim import System, fmu_files

        if options.native or options.fmi != "2":
            message = "--native and --fmi are for the FMU of a model, not for those of a system"
            raise InputError.single(message)
        files = fmu_files(System.load(options.source), options.build_folder, tell=say)
        for name, path in files.items():
            print(f"{name}: {path}")
        return
    from m4e_fmi.multibody import model_program

    program = model_program(options.source)
    path = options.build_folder / f"{program.name}.fmu"
    print_files([build_fmu(program, path, native=options.native, fmi=options.fmi)])
