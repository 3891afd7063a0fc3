"""`m4e-fmi build` builds the FMU of a model, or all of a system."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from m4e_fmi.cli.options import (
    MODEL_FILE,
    add_build_folder,
    add_native,
    is_system,
    load_model,
    load_system,
    print_files,
    say,
)
from m4e_fmi.errors import InputError, Problem

ARGUMENTS = {
    "fmi": "2",
    "method": "dop853",
    "tolerance": None,
    "stop_time": None,
    "step_size": None,
    "outputs": None,
    "rename": [],
    "sources": False,
}
"""Arguments of `build_fmu` that are options here, with their defaults."""


def add(commands: argparse._SubParsersAction) -> None:
    """Add `build` to the command line."""
    command = commands.add_parser("build", help="build the FMU of a model, or all of a system")
    command.add_argument("source", type=Path, help=f"{MODEL_FILE}, or a system file")
    add_native(command, "no Python inside, model exchange too; default for a system, not a model")
    of_model = command.add_argument_group("of a model")
    of_model.add_argument(
        "--fmi", choices=("2", "3"), help="version of the standard; 3 of native FMUs; default 2"
    )
    for flag in ("--inputs", "--outputs"):
        of_model.add_argument(
            flag,
            nargs="+",
            action="extend",
            metavar="PATTERN",
            help="only these, as 'body.*'; default all",
        )
    of_model.add_argument(
        "--rename", action="append", metavar="OLD=NEW", help="call a variable NEW; may be repeated"
    )
    of_model.add_argument("--method", help="dop853 (default), rk45, rodas (stiff), rk4 (fixed)")
    of_model.add_argument(
        "--tolerance", type=float, help="if the importer gives none; default 1e-8"
    )
    for flag, text in (("--stop-time", "10 s"), ("--step-size", "0.01 s")):
        of_model.add_argument(
            flag, type=float, metavar="S", help=f"of the default experiment; default {text}"
        )
    of_model.add_argument(
        "--sources", action="store_true", help="with --native: C sources too, to compile elsewhere"
    )
    of_model.add_argument(
        "--no-documentation", action="store_true", help="no page, picture and reference series"
    )
    command.add_argument(
        "--ssp", action="store_true", help="for a system: one package (.ssp) with all its FMUs"
    )
    add_build_folder(command)
    command.set_defaults(command=_run, **ARGUMENTS)


def _run(options: argparse.Namespace) -> None:
    if is_system(options.source):
        _build_system(options)
        return
    if options.ssp:
        raise InputError.single("--ssp packs a system, not the FMU of a model")
    from m4e_fmi.files.files_read import files_read
    from m4e_fmi.files.writing import remove_leftovers
    from m4e_fmi.fmu.export.build_record import BuildRecord, write_record

    remove_leftovers(options.build_folder)
    with files_read() as files:
        path, content = _build_model(options)
    write_record(path, BuildRecord(fmu=content, files=files))
    print_files([path])


def _build_model(options: argparse.Namespace) -> tuple[Path, str]:
    """The FMU of a model, and the SHA-256 of its content."""
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.fmu import Options, matching
    from m4e_fmi.fmu.export.archive import write_archive
    from m4e_fmi.fmu.export.build import fmu_files
    from m4e_fmi.multibody import model_program

    chosen: dict[str, Any] = {name: getattr(options, name) for name in ARGUMENTS}
    chosen["native"] = bool(options.native)
    chosen["rename"] = _renamings(options.rename)
    model = load_model(options.source)
    for name in model.lacking:
        say(f"note: {name} has no value: the FMU runs when it is set")
    program = model_program(model)
    if options.inputs is not None:
        program = model_program(model, inputs=matching(program.inputs, options.inputs, "input"))
    documentation: dict[str, bytes] = {}
    if not options.no_documentation:
        from m4e_fmi.report import fmu_documentation

        documentation = fmu_documentation(model, program, Options(**chosen))
    path = options.build_folder / f"{file_stem(program.name)}.fmu"
    asked = Options(documentation=documentation, **chosen)
    return path, write_archive(fmu_files(program, asked), path)


def _build_system(options: argparse.Namespace) -> None:
    from m4e_fmi.cosim import fmu_files
    from m4e_fmi.files.file_names import file_stem

    defaults = {**ARGUMENTS, "inputs": None, "no_documentation": False}
    given = [name for name, default in defaults.items() if getattr(options, name) != default]
    if given:
        flag = f"--{given[0].replace('_', '-')}"
        raise InputError.single(f"{flag} is for the FMU of a model, not for those of a system")
    system = load_system(options.source)
    files = fmu_files(system, options.build_folder, native=options.native, tell=say)
    for name, path in files.items():
        print(f"{name}: {path}")
    if options.ssp:
        from m4e_fmi.cosim import save_system

        package = options.build_folder / f"{file_stem(system.name)}.ssp"
        print_files([save_system(system, package, build_directory=options.build_folder)])


def _renamings(texts: Sequence[str]) -> dict[str, str]:
    """Old names → new ones, of OLD=NEW; InputError with all that is wrong."""
    found: dict[str, str] = {}
    problems = []
    for text in texts:
        old, equals, new = (part.strip() for part in text.partition("="))
        if not equals:
            problems.append(Problem(f"--rename {text}: expected OLD=NEW", "as --rename m=mass"))
        elif found.setdefault(old, new) != new:
            problems.append(Problem(f"--rename gives {old!r} two names: {found[old]!r}, {new!r}"))
    if problems:
        raise InputError(problems)
    return found
