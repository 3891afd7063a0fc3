"""Rows of numbers in WAMIT's output files, with their lines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from m4e_fmi.errors import InputError, Problem, is_file, missing_file
from m4e_fmi.files.csv_columns import shortened
from m4e_fmi.files.files_read import TooLongError, read_text
from m4e_fmi.files.limits import LARGEST_QTF


@dataclass(frozen=True)
class Rows:
    """Numbers of `path`, row by row; row k stands in line `lines[k]`, from 1."""

    path: Path
    values: Sequence[Sequence[float]] = field(repr=False)
    lines: Sequence[int] = field(repr=False)
    texts: Sequence[str] = field(repr=False)

    def problem(self, row: int, message: str, remedy: str = "") -> Problem:
        """A problem with a row; −1 is the last."""
        return _problem(self.path, self.texts, self.lines[row], message, remedy)


def read_rows(path: Path, names: Sequence[str]) -> Rows:
    """The rows of a file, which have as many numbers as `names`; a title may stand first.

    InputError with all problems: no file, other numbers of numbers, what is no finite number.
    """
    texts = _texts(path)
    values, lines, problems = list[list[float]](), list[int](), list[Problem]()
    for line, text in enumerate(texts, start=1):
        words = text.split()
        if not words or (line == 1 and _number(words[0]) is None):
            continue
        found = [_number(word) for word in words]
        wrong = [w for w, x in zip(words, found, strict=True) if x is None or not math.isfinite(x)]
        if wrong:
            message = f"{wrong[0][:20]!r} is not a finite number"
            problems.append(_problem(path, texts, line, message))
        elif len(words) != len(names):
            message = f"{len(words)} numbers, expected {len(names)}: {' '.join(names)}"
            remedy = "if it is the last line, the file was cut off: copy it again"
            problems.append(_problem(path, texts, line, message, remedy))
        else:
            values.append([x for x in found if x is not None])
            lines.append(line)
    if problems:
        raise InputError(shortened(problems))
    if not values:
        raise InputError.single("has no numbers", f"its rows are {' '.join(names)}", str(path))
    return Rows(path, values, lines, texts)


def _texts(path: Path) -> list[str]:
    if not is_file(path):
        message, remedy = missing_file(path, "file of drift forces")
        raise InputError.single(message, remedy)
    try:
        return read_text(path, largest=LARGEST_QTF).splitlines()
    except UnicodeDecodeError:
        raise InputError.single("is not a text", "", str(path)) from None
    except (TooLongError, OSError) as error:
        raise InputError.single(f"cannot be read: {error}", "", str(path)) from None


def _number(word: str) -> float | None:
    """The number that a word is, D or E before its exponent; None if it is none."""
    try:
        return float(word.replace("D", "E").replace("d", "e"))
    except ValueError:
        return None


def _problem(
    path: Path, texts: Sequence[str], line: int, message: str, remedy: str = ""
) -> Problem:
    text = texts[line - 1] if line <= len(texts) else ""
    column = len(text) - len(text.lstrip()) + 1
    return Problem(message, remedy, str(path), line, column, text, max(1, len(text.strip())))
