"""The command line: one module per subcommand, listed in `COMMANDS` here.

Exit codes: 0 done, 1 the work failed, 2 wrong input or usage; 130 after
Ctrl-C, 128 plus its number after another signal that asks for the end.

One module for each command: `add` says what it takes, `_run` does it; those on results are in
`of_results`. `options` has what they share. Nothing heavy is imported before a command runs, so
that `--help` answers at once.
"""

from __future__ import annotations

import argparse
import atexit
import gc
import re
import shlex
import sys
import tempfile
import traceback
from collections.abc import Sequence
from functools import cache
from typing import Any, cast

import m4e_fmi
from m4e_fmi.cli import (
    build,
    doctor,
    draw,
    equations,
    equilibrium,
    hydro,
    info,
    linearize,
    mooring,
    new,
    rao,
    run,
    simulate,
    study,
    validate,
)
from m4e_fmi.cli.of_results import compare, decay, report
from m4e_fmi.cli.shared.log import fail, logged, tell_event
from m4e_fmi.cli.shared.options import EXIT_FAILED
from m4e_fmi.cli.shared.output import Clean, clean_output
from m4e_fmi.errors import InputError, M4eError, RunError, suggestion
from m4e_fmi.files.file_kinds import FMU_SUFFIX
from m4e_fmi.signals import Terminated, ending_cleanly

EXIT_USAGE = 2
COLLECTION = (50_000, 20, 100)
"""Thresholds of the garbage collector. Equations are hundreds of thousands of objects that stay:
to look through them after every 700 new ones takes a third of the time that making them takes."""
EXIT_SIGNAL = 128
EXIT_INTERRUPTED = 130
_NEGATIVE = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)
COMMANDS = {
    run: "co-simulate a system of FMUs",
    simulate: "simulate one model, a system as one program, or any FMU",
    new: "write a working start: a model, a system, a controller",
    equations: "print the equations of motion of a model or a system",
    draw: "draw a model in its start pose",
    equilibrium: "where a model or a system is at rest, and the forces there",
    linearize: "equilibrium, frequencies, damping, state space",
    rao: "response of a system to waves; statistics in a sea",
    decay: "period, linear and quadratic damping of a recorded free decay",
    hydro: "hydrodynamic coefficients: tables, pictures, consistency",
    mooring: "mooring lines at rest: tensions, stiffness, offsets, broken lines",
    build: "build the FMU of a model, or all of a system",
    info: "show the contents of a model, a system or an FMU",
    validate: "check FMUs: their descriptions and their behaviour",
    study: "many runs: sea states, parameters, samples",
    report: "one HTML page of results: of a run, a simulation or a study",
    compare: "differences of results from a reference",
    doctor: "report what is installed and what is missing",
}
"""Modules of the commands, whose names are theirs, and what the commands do."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)  # Python looks through all objects once more, for 0.3 s
    with clean_output():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    gc.set_threshold(*COLLECTION)
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    is_fmu = any(word.lower().endswith(FMU_SUFFIX) for word in words)
    stepped = words[:1] == ["simulate"] and is_fmu  # by its own equations
    options = _parser().parse_args(["run", *words[1:]] if stepped else words)
    options.given = shlex.join(["m4e-fmi", *words])
    try:
        with logged(options, words):
            code = _done(options, words)
            tell_event("end", exit_code=code)
    except OSError as error:  # events that have not been written
        print(f"failed: {error}", file=sys.stderr)
        return EXIT_FAILED
    return code


def _done(options: argparse.Namespace, words: Sequence[str]) -> int:
    """The exit code of a command that is done, or whose error is told."""
    try:
        with ending_cleanly():
            code = options.command(options) or 0
            cast("Clean", sys.stdout).complain()
        return code
    except InputError as error:
        return _failed(EXIT_USAGE, f"error: {error}", error, "input")
    except RunError as error:
        return _failed(EXIT_FAILED, f"failed: {error}", error, "run")
    except M4eError as error:
        return _failed(EXIT_FAILED, f"error: {error}", error, "run")
    except KeyboardInterrupt as error:
        text = _with_notes("interrupted", error)
        return _failed(EXIT_INTERRUPTED, text, error, "interrupted")
    except Terminated as error:
        text = _with_notes(str(error), error)
        return _failed(EXIT_SIGNAL + error.signal, text, error, "interrupted")
    except OSError as error:  # of files that come and go, and of an output that is full
        return _failed(EXIT_FAILED, f"failed: {error}", error, "run")
    except MemoryError as error:
        return _failed(EXIT_FAILED, "failed: there is not enough memory", error, "run")
    except Exception as error:  # noqa: BLE001  the last resort
        return _failed(EXIT_FAILED, _defect(error, words), error, "defect")


def _defect(error: BaseException, arguments: Sequence[str]) -> str:
    """Text to print of an unexpected error, after the report on it has been written.

    The report has traceback, versions and arguments; nothing of the environment.
    """
    from m4e_fmi.doctor import versions

    text = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    told = f"failed: {text}\n      this is a defect of m4e_fmi or of a kind, not of your input"
    lines = [
        *(f"{name} {one}" for name, one in versions().items()),
        f"arguments: {list(arguments)!r}",
        "",
        *traceback.format_exception(error),
    ]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="m4e_fmi_defect_", suffix=".txt", delete=False,
            encoding="utf-8", errors="backslashreplace",
        ) as file:  # fmt: skip
            file.write("\n".join(lines))
    except OSError as reason:
        return f"{told}; no report could be written: {reason}"
    return f"{told}; please send the report {file.name}"


def _failed(code: int, text: str, error: BaseException, kind: str) -> int:
    """The exit code, after the error is told."""
    fail(text, error, kind)
    return code


def _with_notes(text: str, error: BaseException) -> str:
    """`text` and the progress noted on the error: "interrupted at t = 2 s of 9 s; …"."""
    return " ".join(filter(None, (text, "; ".join(getattr(error, "__notes__", ())))))


class _Parser(argparse.ArgumentParser):
    """A parser that takes whatever begins like a negative number for a value.

    Argparse takes -1e7 and -5mm for options; no option here begins so.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._negative_number_matcher = _NEGATIVE

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value not in action.choices:
            names = list(map(str, action.choices))
            near = suggestion(str(value), names)
            remedy = near if "did you mean" in near else f"known: {', '.join(names)}"
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}; {remedy}")


@cache  # for programs that call `main` often
def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="m4e-fmi",
        description="Equations of motion, FMUs and co-simulation of multibody systems.",
        epilog="m4e-fmi help COMMAND shows the options of one.",
    )
    parser.add_argument("--version", action="version", version=f"m4e_fmi {m4e_fmi.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command, text in COMMANDS.items():
        command.add(commands.add_parser(command.__name__.rpartition(".")[2], help=text))
    return parser
