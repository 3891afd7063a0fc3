"""`m4e-fmi equilibrium` finds where a model or a system is at rest."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.log import add_log, note, show_result
from m4e_fmi.cli.shared.options import (
    MODEL_OR_SYSTEM,
    add_options,
    finite,
    load_equations,
    pairs,
    start_values,
)
from m4e_fmi.errors import RunError

if TYPE_CHECKING:
    from m4e_fmi.analysis import OperatingPoint
    from m4e_fmi.model import Model
    from m4e_fmi.program import Program


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `equilibrium`."""
    command.add_argument("model", type=Path, help=MODEL_OR_SYSTEM)
    add_options(command, "--open", "--settled", "--build-folder")
    command.add_argument(
        "--nearest",
        action="store_true",
        help="the equilibrium nearest to the start values, stable or not; default: where it "
        "settles from them",
    )
    command.add_argument(
        "--such-that",
        nargs=2,
        action="append",
        default=[],
        metavar=("NAME", "VALUE"),
        help="the equilibrium in which this output or state has this value, or this mode, as "
        "'mode 1 frequency' '2 Hz', 'mode 1 damping' 0.05 by the numbers of linearize; may be "
        "given again",
    )
    command.add_argument(
        "--vary",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME",
        help="parameters or inputs that are changed for that, one for each value",
    )
    command.add_argument("--time", type=finite, default=0.0, metavar="S", help="default 0 s")
    add_options(command, "--start-value")
    command.add_argument("--json", action="store_true", help="print all values as JSON")
    add_log(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.analysis.rest_notes import rest_notes
    from m4e_fmi.report import equilibrium_text, equilibrium_values

    options.such_that = pairs("--such-that", options.such_that)
    source, at = load_equations(options), start_values(options)
    try:
        point = _found(source, at, options)
    except RunError as error:
        also = "" if options.nearest else "; or take --nearest, which finds unstable ones, too"
        raise RunError(error.message, error.remedy + also) from None
    notes = rest_notes(point)
    text = equilibrium_text(point, varied=options.vary, notes=notes)
    show_result(text, equilibrium_values(point), options)
    if options.json:
        for line in notes:
            note(f"note: {line}")


def _found(
    source: Model | Program, at: dict[str, float | str], options: argparse.Namespace
) -> OperatingPoint:
    from m4e_fmi.analysis import equilibrium, trimmed

    if options.such_that or options.vary:
        return trimmed(
            source,
            such_that=options.such_that,
            vary=options.vary,
            at=at,
            time=options.time,
            nearest=options.nearest,
        )
    return equilibrium(source, at=at, time=options.time, nearest=options.nearest)
