"""Options and small services that commands share."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import say, warn
from m4e_fmi.errors import InputError, Problem

if TYPE_CHECKING:
    from m4e_fmi.analysis.response import InWaves
    from m4e_fmi.cosim import System
    from m4e_fmi.model import Model
    from m4e_fmi.program import Program

EXIT_FAILED = 1
BUILD_FOLDER = "build"
REPORT = ".report.html"
"""The end of the name of a report beside results."""
MODEL_FILE = "a model: ours, Chrono's or the paper's lists (YAML), or a robot (URDF)"
MODEL_OR_SYSTEM = f"{MODEL_FILE}; or a system file, whose equations are connected to one program"


SHARED = {
    "--start-value": {
        "nargs": 2,
        "action": "append",
        "default": [],
        "metavar": ("NAME", "VALUE"),
        "help": "set a parameter, input or state at the start, as `start:` of a system file does: "
        "a number in the variable's own unit (of a model SI), or with a unit, as '250 cm'; may be "
        "given again",
    },
    "--output-file": {
        "type": Path,
        "metavar": "FILE",
        "help": "results (.nc, .csv); default build/NAME.nc",
    },
    "--animate": {
        "nargs": "?",
        "type": Path,
        "const": Path(),
        "metavar": "FILE",
        "help": "write an animation (.html); default build/NAME.html",
    },
    "--report": {
        "nargs": "?",
        "type": Path,
        "const": Path(),
        "metavar": "FILE",
        "help": "write a report (.html): plots, animation, power flow, inputs in one file; "
        "default build/NAME.report.html",
    },
    "--no-plot": {"action": "store_true", "help": "no picture"},
    "--build-folder": {
        "type": Path,
        "default": Path(BUILD_FOLDER),
        "metavar": "DIR",
        "help": "where FMUs of a system are built; default build/",
    },
    "--native": {"action": argparse.BooleanOptionalAction},
    "--open": {
        "nargs": "+",
        "action": "extend",
        "default": [],
        "metavar": "COMPONENT",
        "help": "of a system: components that are left out, as those that are no equations; what "
        "they give are inputs then",
    },
    "--settled": {
        "nargs": "+",
        "action": "extend",
        "default": [],
        "metavar": "COMPONENT",
        "help": "of a system: components that are no equations, as mooring lines; they take part "
        "by what they give at rest, and how that changes with what they take",
    },
    "--json": {"action": "store_true", "help": "print all numbers as JSON"},
}
"""Options of several commands, with the arguments of `add_argument`."""


def add_options(command: argparse.ArgumentParser, *flags: str, **changed: object) -> None:
    """Add options of `SHARED`; `changed` are arguments in place of those there."""
    for flag in flags:
        command.add_argument(flag, **{**SHARED[flag], **changed})  # pyrefly: ignore[bad-argument-type]


def animation_file(options: argparse.Namespace, name: str) -> Path | None:
    """Path of the animation; None if none is wanted. InputError for another suffix."""
    from m4e_fmi.files.writing import check_suffix

    if options.animate is None:
        return None
    default = output_file(options, name).with_suffix(".html")
    path = options.animate if options.animate.name else default
    check_suffix(path, (".html",), "an animation")
    return path


def report_file(options: argparse.Namespace, output: Path) -> Path | None:
    """Path of the report beside `output`; None if none is wanted. InputError if it is no .html."""
    from m4e_fmi.files.writing import check_suffix

    if options.report is None:
        return None
    path = options.report if options.report.name else output.with_suffix(REPORT)
    check_suffix(path, (".html",), "a report")
    animation = getattr(options, "animate", None)
    if animation and path.absolute() == animation.absolute():
        raise InputError.single("--animate and --report name the same file", "", str(path))
    return path


def start_values(options: argparse.Namespace) -> dict[str, float | str]:
    """Values of --start-value by name, each as `start` in a system file would have it.

    Without those of components that are settled, which `load_program` gives to their FMUs.
    InputError with all variables that are given twice.
    """
    given = pairs("--start-value", options.start_value)
    return {name: value for name, value in given.items() if not _is_of_settled(name, options)}


def _is_of_settled(name: str, options: argparse.Namespace) -> bool:
    """True for a variable of a settled component's FMU, not for a parameter of its static law."""
    component, _, variable = name.partition(".")
    return component in getattr(options, "settled", ()) and not variable.startswith("at_rest.")


def _started_settled(system: System, options: argparse.Namespace) -> System:
    """The system with the values of --start-value of settled components."""
    given = pairs("--start-value", getattr(options, "start_value", ()))
    own = {name: value for name, value in given.items() if _is_of_settled(name, options)}
    return system.changed(start=own, origin="command line")


def pairs(flag: str, given: Sequence[Sequence[str]]) -> dict[str, float | str]:
    """Names and values of an option `flag` that may be given several times.

    InputError with all names that are given twice.
    """
    counts = Counter(name for name, _ in given)
    twice = [
        Problem(f"{flag} {name} is given {count} times", "give it once")
        for name, count in counts.items()
        if count > 1
    ]
    InputError.raise_for(twice)
    return {name: _scalar(text) for name, text in given}


def finite(text: str) -> float:
    """A finite number, of an option; argparse's error for anything else."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"expected a finite number, got {text!r}")
    return number


def _scalar(text: str) -> float | str:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return {"true": True, "false": False}.get(text, text)


def output_file(options: argparse.Namespace, name: str) -> Path:
    """Path of the results; InputError, before any work, if they cannot be written in that form."""
    from m4e_fmi.files.file_names import file_stem
    from m4e_fmi.results.results_file import check_export

    path = options.output_file or Path(BUILD_FOLDER) / f"{file_stem(name)}.nc"
    check_export(path)
    return path


def is_system(path: Path) -> bool:
    """True for a file of a system, not a model: a package, or YAML with components."""
    from m4e_fmi.files.document import Document
    from m4e_fmi.files.file_kinds import SSP_SUFFIX, SYSTEM, URDF_SUFFIX, kind_of

    if path.suffix.lower() == URDF_SUFFIX:
        return False
    return path.suffix.lower() == SSP_SUFFIX or kind_of(Document.load(path).data) == SYSTEM


def load_model(path: Path) -> Model:
    """The model in a file, after telling what is seldom meant in it."""
    from m4e_fmi import model

    found = model.load_model(path)
    for warning in found.warnings:
        warn(f"warning: {warning}")
    return found


def load_equations(options: argparse.Namespace) -> Model | Program:
    """The model in the file `model`, or the program of the system in it."""
    path: Path = options.model
    if is_system(path):
        return load_program(load_system(path), options)
    return load_only_model(options)


def load_only_model(options: argparse.Namespace) -> Model:
    """The model in the file `model`; InputError for options that are for systems."""
    for flag in ("open", "settled"):
        if getattr(options, flag):
            raise InputError.single(f"--{flag} is for the components of a system, not for a model")
    return load_model(options.model)


def load_program(system: System, options: argparse.Namespace) -> Program:
    """The program of a system; --open names components that are left out, --settled those that take
    part by their static law, with their start values, and each of these is told."""
    from m4e_fmi.cosim import system_program

    return system_program(
        _started_settled(system, options),
        keep_open=options.open,
        settled=options.settled,
        build_directory=options.build_folder,
        tell=say,
    )


def load_in_waves(system: System, options: argparse.Namespace, *, highest: float) -> InWaves:
    """As `load_program`, with forces of waves as inputs, up to `highest` [rad/s]."""
    from m4e_fmi.cosim import system_in_waves

    return system_in_waves(
        _started_settled(system, options),
        highest=highest,
        keep_open=options.open,
        settled=options.settled,
        build_directory=options.build_folder,
        tell=say,
    )


def load_system(path: Path) -> System:
    """The system in a file, after telling what reading it has changed or left out."""
    from m4e_fmi import cosim

    system = cosim.load_system(path)
    for line in system.notes:
        warn(f"{path}: {line}")
    return system
