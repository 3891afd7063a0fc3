"""`m4e-fmi build` builds the FMU of a model, all of a system, or one of a whole system."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_fmi.cli.shared.log import add_log, note, print_files, say, show
from m4e_fmi.cli.shared.options import (
    MODEL_FILE,
    add_options,
    is_system,
    load_model,
    load_program,
    load_system,
)
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from m4e_fmi.fmu import Options
    from m4e_fmi.program import Program

ARGUMENTS = {
    "fmi": "2",
    "method": "dop853",
    "tolerance": None,
    "stop_time": None,
    "step_size": None,
    "outputs": None,
    "sources": False,
}
"""Arguments of `build_fmu` that are options here, with their defaults."""


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `build`."""
    command.add_argument("source", type=Path, help=f"{MODEL_FILE}, or a system file")
    add_options(
        command,
        "--native",
        help="no Python inside, model exchange too; default for a system, not a model",
    )
    of_model = command.add_argument_group("of a model, and with --single")
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
    of_model.add_argument("--no-documentation", action="store_true", help="no page about it")
    command.add_argument(
        "--ssp", action="store_true", help="for a system: one package (.ssp) with all its FMUs"
    )
    command.add_argument(
        "--single",
        action="store_true",
        help="for a system: one FMU of the whole, its equations connected to one program; takes "
        "the options of a model",
    )
    add_options(command, "--open", "--settled", "--build-folder")
    add_log(command)
    command.set_defaults(command=_run, **ARGUMENTS)


def _run(options: argparse.Namespace) -> None:
    system = is_system(options.source)
    for flag in ("open", "settled"):
        if getattr(options, flag) and not (system and options.single):
            message = f"--{flag} is for the components of a system with --single"
            raise InputError.single(message)
    if options.ssp and (options.single or not system):
        raise InputError.single("--ssp packs a system with all its FMUs, not one FMU")
    if options.single and not system:
        raise InputError.single("--single is for a system: a model is one FMU already")
    if system and not options.single:
        _build_system(options)
        return
    from m4e_fmi.files.files_read import files_read
    from m4e_fmi.files.writing import remove_leftovers
    from m4e_fmi.fmu.export.build_record import BuildRecord, write_record

    remove_leftovers(options.build_folder)
    with files_read() as files:
        path, content = (_build_whole if system else _build_model)(options)
    write_record(path, BuildRecord(fmu=content, files=files))
    print_files([path])


def _chosen(options: argparse.Namespace, *, native: bool) -> dict[str, Any]:
    """Arguments of `Options`; `native` unless the command line says so or not."""
    chosen: dict[str, Any] = {name: getattr(options, name) for name in ARGUMENTS}
    chosen["native"] = native if options.native is None else options.native
    return chosen


def _written(program: Program, asked: Options, folder: Path) -> tuple[Path, str]:
    """The FMU of a program in a folder, and the SHA-256 of its content."""
    from m4e_fmi.fmu.export.archive import write_archive
    from m4e_fmi.fmu.export.build import fmu_files

    path = _place(program, folder)
    return path, write_archive(fmu_files(program, asked), path)


def _place(program: Program, folder: Path) -> Path:
    """Where the FMU of a program is written."""
    from m4e_fmi.files.file_names import file_stem

    return folder / f"{file_stem(program.name)}.fmu"


def _build_whole(options: argparse.Namespace) -> tuple[Path, str]:
    """One FMU of a system, and the SHA-256 of its content; times are those of the system."""
    from m4e_fmi.files.files_read import ABSENT, file_hash
    from m4e_fmi.fmu import Options

    if options.inputs is not None:
        raise InputError.single("--inputs is for a model: a system has those that are left open")
    system = load_system(options.source)
    program = load_program(system, options)
    chosen = _chosen(options, native=True)
    times = system.simulation
    chosen["stop_time"] = chosen["stop_time"] or times.stop_time
    chosen["step_size"] = chosen["step_size"] or times.step_size
    documentation: dict[str, bytes] = {}
    if not options.no_documentation:
        from m4e_fmi.cosim import Kind
        from m4e_fmi.report import whole_documentation

        sources = {c.name: c.source for c in system.components}
        documentation = whole_documentation(
            program,
            Options(**chosen),
            components={
                name: f"kind {source.name}" if isinstance(source, Kind) else source.path.name
                for name, source in sources.items()
            },
            connections=system.connections,
        )
    before = file_hash(_place(program, options.build_folder))
    asked = Options(documentation=documentation, **chosen)
    path, content = _written(program, asked, options.build_folder)
    if before not in (ABSENT, content):
        note(f"note: {path} replaces another FMU of that name")
    return path, content


def _build_model(options: argparse.Namespace) -> tuple[Path, str]:
    """The FMU of a model, and the SHA-256 of its content."""
    from m4e_fmi.fmu import Options, matching
    from m4e_fmi.multibody import model_program

    chosen = _chosen(options, native=False)
    model = load_model(options.source)
    for name in model.lacking:
        note(f"note: {name} has no value: the FMU runs when it is set")
    program = model_program(model)
    if options.inputs is not None:
        program = model_program(model, inputs=matching(program.inputs, options.inputs, "input"))
    documentation: dict[str, bytes] = {}
    if not options.no_documentation:
        from m4e_fmi.report import fmu_documentation

        documentation = fmu_documentation(model, program, Options(**chosen))
    return _written(program, Options(documentation=documentation, **chosen), options.build_folder)


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
        show(f"{name}: {path}", "file", path=str(path))
    if options.ssp:
        from m4e_fmi.cosim import save_system

        package = options.build_folder / f"{file_stem(system.name)}.ssp"
        print_files([save_system(system, package, build_directory=options.build_folder)])
