"""`m4e-fmi equations` prints the equations of motion of a model, or the program of a system."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from m4e_fmi.cli.shared.options import MODEL_OR_SYSTEM, add_options, load_equations
from m4e_fmi.errors import InputError

if TYPE_CHECKING:
    from m4e_fmi.program import Program


def add(command: argparse.ArgumentParser) -> None:
    """Add the arguments of `equations`."""
    command.add_argument("model", type=Path, help=MODEL_OR_SYSTEM)
    add_options(command, "--open", "--settled", "--build-folder")
    command.add_argument("--latex", action="store_true", help="as LaTeX instead of text")
    command.add_argument(
        "--reactions", action="store_true", help="also the reactions of each joint"
    )
    command.add_argument(
        "--simplify", action="store_true", help="expand, and collect sines and cosines"
    )
    command.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    from m4e_fmi.multibody import Equations
    from m4e_fmi.program import Program

    source = load_equations(options)
    if isinstance(source, Program):
        _print_program(source, options)
        return
    equations = Equations(source, simplify=options.simplify)
    print(equations.text(latex=options.latex, reactions=options.reactions))


def _print_program(program: Program, options: argparse.Namespace) -> None:
    """A system's program as functions in Python."""
    from m4e_fmi.program.python_form import python_source

    for flag in ("latex", "reactions", "simplify"):
        if getattr(options, flag):
            message = f"--{flag} is for a model: a system has straight-line equations"
            raise InputError.single(message, "leave it out, or give the file of a model")
    print(python_source(program))
