"""`m4e-fmi info` shows what is in a model, a system or an FMU."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.options import add_build_folder, is_system, load_system, say


def add(commands: argparse._SubParsersAction) -> None:
    command = commands.add_parser("info", help="show what is in a model, a system or an FMU")
    command.add_argument("source", type=Path, help="a model, system or .fmu file")
    command.add_argument("--json", action="store_true", help="all of an FMU, as JSON")
    command.add_argument("--latex", action="store_true", help="a model's tables, in LaTeX")
    add_build_folder(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.report import fmu_text

    if options.source.suffix == ".fmu" and options.json:
        import json

        from m4e_fmi.fmu import fmu_contents

        print(json.dumps(fmu_contents(options.source), indent=2))
    elif options.source.suffix == ".fmu":
        print(fmu_text(options.source))
    elif is_system(options.source):
        from m4e_fmi.cosim import prepare

        system = load_system(options.source)
        print(prepare(system, build_directory=options.build_folder, tell=say))
    else:
        from m4e_fmi.model import load_model
        from m4e_fmi.multibody import model_program
        from m4e_fmi.report import model_tables

        model = load_model(options.source)
        print(model_tables(model, latex=options.latex))
        if not options.latex:
            print(f"\n{model_program(model)}")
