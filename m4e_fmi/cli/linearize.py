"""`m4e-fmi linearize` finds equilibrium, frequencies and state space of a model or system."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.shared.log import add_log, show_result
from m4e_fmi.cli.shared.options import (
    MODEL_OR_SYSTEM,
    add_options,
    finite,
    load_equations,
    start_values,
)
from m4e_fmi.errors import RunError

POINTS = {
    "equilibrium": "equilibrium",
    "nearest": "nearest equilibrium",
    "start": "start values",
}


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `linearize`."""
    command.add_argument("model", type=Path, help=MODEL_OR_SYSTEM)
    add_options(command, "--open", "--settled", "--build-folder")
    command.add_argument(
        "--at",
        choices=tuple(POINTS),
        default="equilibrium",
        help="where it settles from the start values (default), the equilibrium that is nearest "
        "to them, stable or not, or these values themselves",
    )
    command.add_argument("--time", type=finite, default=0.0, metavar="S", help="default 0 s")
    for flag, text in (
        ("--inputs", "inputs or parameters of B and D; default none"),
        ("--outputs", "outputs or states of C and D; default all states"),
    ):
        command.add_argument(flag, nargs="+", action="extend", metavar="NAME", help=text)
    add_options(command, "--start-value")
    command.add_argument("--json", action="store_true", help="print everything as JSON")
    add_log(command)
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.analysis import equilibrium, linearize, modes
    from m4e_fmi.report import linear_json, linear_text

    model, at = load_equations(options), start_values(options)
    if options.at != "start":
        nearest = options.at == "nearest"
        try:
            at = equilibrium(model, at=at, time=options.time, nearest=nearest)
        except RunError as error:
            also = "" if nearest else "; or take --at nearest, which finds unstable ones, too"
            raise RunError(error.message, error.remedy + also) from None
    linear = linearize(
        model, at=at, time=options.time, inputs=options.inputs or (), outputs=options.outputs
    )
    found = modes(linear)
    values = linear_json(linear, found)
    show_result(linear_text(linear, found, title=POINTS[options.at]), values, options)
