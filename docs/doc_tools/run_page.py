"""Pages whose commands are run: what they show is what comes out.

In such a page

- a `yaml` block that starts with the comment `# NAME.yaml`, a `c` block that starts with
  `/* NAME.c`, and a `none` block that starts with `NAME.txt:` are written to that file, others are
  for reading only;
- of a `sh` block `cp -r`, `cd` and the commands of m4e-fmi are run, but of coupled runs and
  studies, which take long, the files are only read;
- a `console` block holds commands after `$ `, each followed by what it prints;
- a `python` block is run, with the names that earlier ones have made; a `text` block right after it
  is what it prints.

In what is printed, `...` stands for anything, the amount of white space does not matter, and the
last digit of a number with a decimal point may be another by one: it follows the rounding of the
processor. Blocks of other languages are for reading only. The folder examples/ is at hand as in the
repository.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import os
import re
import shlex
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from m4e_fmi import cli
from m4e_fmi.cosim import load_system
from m4e_fmi.study import load_study

EXAMPLES = Path(__file__).parents[2] / "examples"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"\d*\.\d+(?:e[+-]?\d+)?")
FILE = re.compile(r"# (\S+\.yaml)\n|/\* (\S+\.c)\b|(\S+\.txt):")
LENIENT = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


class PageError(Exception):
    """A page shows what does not come out."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, its first line's number in the page."""

    language: str
    text: str
    line: int


def blocks(page: str) -> Iterator[Block]:
    """The fenced blocks of a page, in order."""
    for match in FENCE.finditer(page):
        yield Block(match[1], match[2], page.count("\n", 0, match.start(2)) + 1)


def run_page(page: Path, folder: Path) -> dict[str, Any]:
    """Run what `page` shows in `folder`, which is made anew with a copy of examples/.

    Returns the names that its Python blocks have made. Raises PageError where something else comes
    out, with both texts.
    """
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(
        EXAMPLES, folder / "examples", ignore=shutil.ignore_patterns("build", "__pycache__")
    )
    names: dict[str, Any] = {"__name__": page.stem}
    shown = list(blocks(page.read_text(encoding="utf-8")))
    with contextlib.chdir(folder):
        for block, after in zip(shown, [*shown[1:], None], strict=True):
            place = f"{page.name}:{block.line}"
            if block.language in ("yaml", "c", "none"):
                _write(block)
            elif block.language == "sh":
                _run_shell(block, place)
            elif block.language == "console":
                _run_commands(block, place)
            elif block.language == "python":
                printed = _printed(lambda code=block.text: exec(code, names), place)
                if after and after.language == "text":
                    _compare(after.text, printed, place)
    return names


def _write(block: Block) -> None:
    name = FILE.match(block.text)
    if name:
        Path(name[1] or name[2] or name[3]).write_text(block.text, encoding="utf-8")


def _run_shell(block: Block, place: str) -> None:
    for line in block.text.splitlines():
        match shlex.split(line, comments=True):
            case ["cp", "-r", source, target]:
                shutil.copytree(source, target)
            case ["cd", folder]:
                os.chdir(folder)
            case ["m4e-fmi", "study", file, *_]:
                load_study(file)
            case ["m4e-fmi", "run", file, *_]:
                load_system(file)
            case ["m4e-fmi", *given]:
                _printed(lambda given=given: _succeed(given), f"{place}: {line}")
            case _:
                pass  # for reading only


def _succeed(given: list[str]) -> None:
    if code := cli.main(given):
        raise SystemExit(code)


def _run_commands(block: Block, place: str) -> None:
    first, *sessions = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
    if first:
        raise PageError(f"{place}: a console block starts with a command, after '$ '")
    for session in sessions:
        command, _, expected = session.partition("\n")
        program, *arguments = shlex.split(command)
        if program != "m4e-fmi":
            raise PageError(f"{place}: commands are of m4e-fmi, got {program!r}")
        printed = _printed(lambda given=arguments: cli.main(given), f"{place}: {command}")
        _compare(expected, printed, f"{place}: {command}")


def _printed(action: Callable[[], object], place: str) -> str:
    """What `action` prints: to the standard output or, if nothing there, its errors."""
    output, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            action()
        except (Exception, SystemExit) as error:
            raise PageError(f"{place}: {error!r}\n{errors.getvalue()}") from error
    return output.getvalue() or errors.getvalue()


def _compare(expected: str, printed: str, place: str) -> None:
    printed = _with_digits(printed, NUMBER.findall(expected))
    if not doctest.OutputChecker().check_output(expected, printed, LENIENT):
        raise PageError(f"{place}: the page says\n{expected}\nbut what comes out is\n{printed}")


def _with_digits(printed: str, numbers: Sequence[str]) -> str:
    """The text with each number as `numbers` have it, if they differ by one in the last digit."""

    def known(match: re.Match[str]) -> str:
        given = Decimal(match[0])
        near = min(numbers, key=lambda text: abs(Decimal(text) - given), default=match[0])
        finest = min((Decimal(text).as_tuple().exponent for text in (near, match[0])), key=int)
        return near if abs(Decimal(near) - given) <= Decimal((0, (1,), int(finest))) else match[0]

    return NUMBER.sub(known, printed)
