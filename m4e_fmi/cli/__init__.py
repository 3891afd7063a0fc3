"""The command line: one module per subcommand, listed in `COMMANDS` here.

Exit codes: 0 done, 1 the work failed, 2 wrong input or usage; 130 after
Ctrl-C, 128 plus its number after another signal that asks for the end.

One module for each command: `add` says what it takes, `_run` does it. `options` has what they
share. Nothing heavy is imported before a command runs, so that `--help` answers at once.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

import m4e_fmi
from m4e_fmi.cli import (
    build,
    compare,
    decay,
    doctor,
    draw,
    equations,
    equilibrium,
    hydro,
    info,
    linearize,
    rao,
    run,
    simulate,
    study,
    validate,
)
from m4e_fmi.cli.shared.options import EXIT_FAILED
from m4e_fmi.cli.shared.output import clean_output
from m4e_fmi.errors import InputError, M4eError, RunError, suggestion
from m4e_fmi.signals import Terminated, ending_cleanly

EXIT_USAGE = 2
EXIT_SIGNAL = 128
EXIT_INTERRUPTED = 130
_NEGATIVE = re.compile(r"-(\d|\.\d|inf|nan)", re.IGNORECASE)
COMMANDS = (
    equations, draw, simulate, equilibrium, linearize, rao, decay, hydro, build, info, validate,
    run, study, compare, doctor,
)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    with clean_output():
        return _run(arguments)


def _run(arguments: Sequence[str] | None) -> int:
    options = _parser().parse_args(arguments)
    try:
        with ending_cleanly():
            code = options.command(options) or 0
            sys.stdout.flush()
        return code
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_USAGE
    except RunError as error:
        print(f"failed: {error}", file=sys.stderr)
        return EXIT_FAILED
    except M4eError as error:
        print(f"error: {error}", file=sys.stderr)
        return EXIT_FAILED
    except KeyboardInterrupt as error:
        print(_with_notes("interrupted", error), file=sys.stderr)
        return EXIT_INTERRUPTED
    except Terminated as error:
        print(_with_notes(str(error), error), file=sys.stderr)
        return EXIT_SIGNAL + error.signal
    except OSError as error:  # of files that come and go, and of an output that is full
        print(f"failed: {error}", file=sys.stderr)
        return EXIT_FAILED
    except MemoryError:
        print("failed: there is not enough memory", file=sys.stderr)
        return EXIT_FAILED
    except Exception as error:  # noqa: BLE001  the last resort
        from m4e_fmi.cli.shared.defect import defect_line, given

        print(defect_line(error, given(arguments)), file=sys.stderr)
        return EXIT_FAILED


def _with_notes(text: str, error: BaseException) -> str:
    """`text` and the progress noted on the error: "interrupted at t = 2 s of 9 s; …"."""
    return " ".join(filter(None, (text, "; ".join(getattr(error, "__notes__", ())))))


class _Parser(argparse.ArgumentParser):
    """A parser that takes whatever begins like a negative number for a value.

    Argparse takes -1e7 and -5mm for options; no option here begins so. Wrong values and unknown
    options are told together, with what is like them.
    """

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self._negative_number_matcher = _NEGATIVE
        self._wrong: list[str] = []

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        """argparse's result; exits with all wrong values and unknown arguments."""
        found, unknown = super().parse_known_args(args, namespace)
        for text in unknown:
            option = text.partition("=")[0]
            known = [name for name in self._option_string_actions if name.startswith("--")]
            remedy = f": {suggestion(option, known)}" if option.startswith("-") else ""
            self._wrong.append(f"unrecognized argument {text}{remedy}")
        if self._wrong:
            self.error("")
        return found, []

    def error(self, message: str) -> NoReturn:
        """Exit with `message` and all that has been found before; an example of a start value."""
        if "--start-value: expected" in message:
            message += ", as in --start-value mass 3"
        found = [*self._wrong, *filter(None, [message])]
        self._wrong = []
        super().error("\n  ".join(found))

    def _get_value(self, action: argparse.Action, arg_string: str) -> object:
        try:
            return super()._get_value(action, arg_string)  # pyright: ignore
        except argparse.ArgumentError as error:
            self._wrong.append(str(error))
            return None

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value is not None and value not in action.choices:
            remedy = suggestion(str(value), map(str, action.choices))
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}; {remedy}")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="m4e-fmi",
        description="Equations of motion, FMUs and co-simulation of multibody systems.",
        epilog="Each command has its own --help.",
    )
    parser.add_argument("--version", action="version", version=f"m4e_fmi {m4e_fmi.__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add(commands)
    return parser
