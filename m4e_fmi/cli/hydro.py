"""`m4e-fmi hydro` shows hydrodynamic coefficients, the memory fitted to them, and their faults."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import add_log, print_files, say, show_result
from m4e_fmi.cli.shared.options import BUILD_FOLDER, add_options, finite, is_system, load_system
from m4e_fmi.errors import YAML_SUFFIXES, InputError, suggestion

if TYPE_CHECKING:
    from m4e_fmi.analysis.hydrodynamic_data import HydrodynamicData
    from m4e_fmi.cosim import System
    from m4e_fmi.files.document import Section
    from m4e_fmi.fmu.kind import FmuKind

SYSTEMS = (*YAML_SUFFIXES, ".json", ".ssp")


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `hydro`."""
    command.add_argument(
        "source",
        type=Path,
        metavar="FILE",
        help="coefficients (WAMIT .1 with .3 and .hst, BEMIO .h5, Capytaine .nc), or a system file",
    )
    command.add_argument(
        "--component", metavar="NAME", help="of a system with several in water: which one"
    )
    command.add_argument(
        "--depth", type=finite, metavar="M", help="of a file: depth of the water, if it lacks one"
    )
    add_options(command, "--json")
    command.add_argument(
        "--output-file",
        type=Path,
        metavar="FILE",
        help="netCDF, build/NAME_hydro.nc",
    )
    command.add_argument(
        "--refine",
        action="store_true",
        help="of a system: convergence with finer panels, and the errors of each mesh",
    )
    add_options(command, "--no-plot")
    add_log(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    if options.depth is not None and options.source.suffix.lower() in SYSTEMS:
        message = "--depth is of a file of coefficients"
        raise InputError.single(message, "write it in the system file, as water: {depth: …}")
    if options.depth is not None and options.depth <= 0.0:
        raise InputError.single("--depth must be positive")
    if options.refine:
        _refine(options)
        return
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.files.writing import check_suffix
    from m4e_fmi.report import hydro_json, hydro_text, plot_hydro, write_hydro

    if options.output_file:
        check_suffix(options.output_file, (".nc",), "a report of coefficients")
    of_system = options.source.suffix.lower() in SYSTEMS
    data = _of_system(options) if of_system else _of_file(options)
    output = options.output_file or Path(BUILD_FOLDER) / f"{file_stem(data.title)}_hydro.nc"
    show_result(hydro_text(data), hydro_json(data), options)
    files = [write_hydro(data, output)]
    if not options.no_plot:
        files.append(plot_hydro(data, output.with_suffix(".png")))
    print_files(files, options)


def _of_file(options: argparse.Namespace) -> HydrodynamicData:
    """The data of all bodies of a file."""
    if options.component:
        raise InputError.single("--component is of a system, not of a file of coefficients")
    from m4e_fmi.cosim.system.component import kind_of, kinds

    notes: list[str] = []
    for kind in map(kind_of, sorted(kinds())):
        if kind.config_of_file and kind.coefficients:
            config = kind.config_of_file(options.source, progress=notes.append, depth=options.depth)
            folder, name = options.source.parent, options.source.stem
            data = kind.coefficients(config, name=name, folder=folder, progress=say)
            return replace(data, notes=(*notes, *data.notes))
    raise InputError.single("no kind of FMU that is installed reads coefficients")


def _refine(options: argparse.Namespace) -> None:
    """Print a convergence study of a component in water."""
    if options.source.suffix.lower() not in SYSTEMS:
        message = f"{options.source}: --refine is of a system, not of a file of coefficients"
        raise InputError.single(message, "give a system file with shapes or meshes of bodies")
    if options.output_file:
        message = "--output-file is for the coefficients of one mesh"
        raise InputError.single(message, "leave it out beside --refine; --json prints all numbers")
    system, chosen, _ = _chosen(options)
    kind, config = _in_water(system)[chosen]
    if kind.refinement is None:
        message = f"the kind of component {chosen!r} has no panels to refine"
        raise InputError.single(message, "choose another one with --component")
    try:
        text, numbers = kind.refinement(config, folder=system.folder, progress=say)
    except InputError as error:
        raise InputError([system.located(chosen, p) for p in error.problems]) from None
    show_result(text, numbers, options)


def _of_system(options: argparse.Namespace) -> HydrodynamicData:
    """The data of a component in water."""
    system, chosen, title = _chosen(options)
    kind, config = _in_water(system)[chosen]
    assert kind.coefficients
    try:
        return kind.coefficients(config, name=title, folder=system.folder, progress=say)
    except InputError as error:
        raise InputError([system.located(chosen, p) for p in error.problems]) from None


def _chosen(options: argparse.Namespace) -> tuple[System, str, str]:
    """The system, its component in water that is meant, and a title."""
    if not is_system(options.source):
        message = f"{options.source}: a model alone is in no water"
        raise InputError.single(message, "give a system with a component in water, or a file")
    system = load_system(options.source)
    there = _in_water(system)
    names = ", ".join(there)
    if options.component:
        if options.component not in there:
            message = f"{system.name}: no component in water {options.component!r}"
            raise InputError.single(message, suggestion(options.component, there))
        chosen = options.component
    elif len(there) == 1:
        (chosen,) = there
    else:
        message = f"{system.name}: {len(there) or 'no'} components are in water"
        remedy = f"choose one with --component: {names}" if there else "give a file of coefficients"
        raise InputError.single(f"{message}: {names}" if there else message, remedy)
    return system, chosen, system.name if len(there) == 1 else f"{system.name}_{chosen}"


def _in_water(system: System) -> dict[str, tuple[FmuKind, Section]]:
    """Components with coefficients, each with its kind and its configuration."""
    from m4e_fmi.cosim.system.component import Kind, kind_of

    found = {}
    for component in system.components:
        source = component.source
        if isinstance(source, Kind) and (kind := kind_of(source.name)).coefficients:
            found[component.name] = kind, source.config
    return found
