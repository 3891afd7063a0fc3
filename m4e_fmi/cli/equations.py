"""`m4e-fmi equations` prints the equations of motion of a model."""

from __future__ import annotations

import argparse
from pathlib import Path

from m4e_fmi.cli.options import MODEL_FILE, load_model


def add(commands: argparse._SubParsersAction) -> None:
    """Add `equations` to the command line."""
    command = commands.add_parser("equations", help="print the equations of motion of a model")
    command.add_argument("model", type=Path, help=MODEL_FILE)
    form = command.add_mutually_exclusive_group()
    form.add_argument("--latex", action="store_true", help="as LaTeX instead of text")
    form.add_argument(
        "--code", choices=("python", "c"), help="M and f as source of a function instead"
    )
    command.add_argument(
        "--explicit",
        action="store_true",
        help="write repeated expressions out in full instead of naming them",
    )
    command.add_argument(
        "--reactions", action="store_true", help="also the reactions of each joint"
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.multibody import Equations

    equations = Equations(load_model(options.model))
    if options.code:
        print(equations.code(options.code), end="")
        return
    explicit = options.explicit or None
    print(equations.text(latex=options.latex, reactions=options.reactions, explicit=explicit))
