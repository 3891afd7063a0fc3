"""`m4e-fmi build` builds the FMU of a model, or all of a system."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.options import add_build_folder, add_native, is_system, print_files, say
from m4e_fmi.errors import InputError


def add(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("build", help="build the FMU of a model, or all of a system")
    command.add_argument("source", type=Path, help="a model or system file")
    add_native(command, "no Python inside, model exchange too; default for a system, not a model")
    command.add_argument(
        "--fmi", choices=("2", "3"), default="2", help="version of FMI of --native; default 2"
    )
    add_build_folder(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.fmu import build_fmu

    if is_system(options.source):
        from m4e_fmi.cosim import System, fmu_files

        if options.fmi != "2":
            raise InputError.single("--fmi is for the FMU of a model, not for those of a system")
        system = System.load(options.source)
        files = fmu_files(system, options.build_folder, native=options.native, tell=say)
        for name, path in files.items():
            print(f"{name}: {path}")
        return
    from m4e_fmi.multibody import model_program

    program = model_program(options.source)
    path = options.build_folder / f"{program.name}.fmu"
    print_files([build_fmu(program, path, native=bool(options.native), fmi=options.fmi)])
