"""Errors whose messages name the place and the remedy.

`InputError` (exit code 2): the user's input is wrong; it carries every problem found.
`RunError` (exit code 1): the input was right, the work failed.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

Value = TypeVar("Value")
YAML_SUFFIXES = (".yaml", ".yml")
_LONGEST_WORD, _MOST_COMPARED = 100, 5000
"""Characters and number of names that are compared by likeness, which takes long for more."""
_LONGEST_NAME, _LONGEST_PATH = 255, 4000
"""Bytes of the name of a file or folder, and of a path."""
CLOSE = 0.8
"""Likeness (difflib's) of a word that is one letter off."""


class M4eError(Exception):
    """Base of every error that m4e_fmi raises on purpose."""


@dataclass(frozen=True)
class Problem:
    """One thing wrong with an input: what, where (lines and columns count from 1), what to do.

    `keys` lead to its place in a configuration, for whoever knows the file that it was read from.
    """

    message: str
    remedy: str = ""
    file: str = ""
    line: int = 0
    column: int = 0
    source: str = ""
    width: int = 1
    keys: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        lines = [_indented(f"{place}: {self.message}" if place else self.message)]
        if self.source:
            gutter = f"{self.line:>5}"
            lines.append(f"{gutter} | {self.source}")
            lines.append(f"{'':>5} | {' ' * (self.column - 1)}{'^' * max(1, self.width)}")
        if self.remedy:
            lines.append(f"      {_indented(self.remedy)}")
        return "\n".join(lines)


class InputError(M4eError):
    """The input is wrong; `problems` holds all that was found, in order of place."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = sorted(problems, key=lambda p: (p.file, p.line, p.column))
        count = len(self.problems)
        tail = f"\n{count} problems" if count > 1 else ""
        super().__init__("\n".join(str(p) for p in self.problems) + tail)

    @classmethod
    def single(
        cls,
        message: str,
        remedy: str = "",
        file: str = "",
        *,
        keys: tuple[str | int, ...] = (),
    ) -> InputError:
        """The error with one problem."""
        return cls([Problem(message, remedy, file, keys=keys)])

    @classmethod
    def raise_for(cls, problems: Iterable[Problem]) -> None:
        """InputError with these problems, if there are any."""
        if found := list(problems):
            raise cls(found)


class UnknownNameError(InputError, KeyError):
    """A name that is not there; a KeyError as well, for those who catch that."""

    @classmethod
    def of(cls, complaint: str, unknown: Sequence[str], known: Iterable[str]) -> UnknownNameError:
        """`complaint`, the names that are `unknown`, and the nearest that is `known`."""
        return cls([Problem(f"{complaint} {', '.join(unknown)}", suggestion(unknown[0], known))])

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError's is in quotation marks


class Named(dict[str, Value]):
    """Values by name. A name that is not there raises UnknownNameError: `complaint` and the name.

    >>> Named("the buoy has no variable", {"heave": 1.0})["haeve"]
    UnknownNameError: the buoy has no variable haeve
          did you mean 'heave'?
    """

    def __init__(self, complaint: str, members: Mapping[str, Value]) -> None:
        super().__init__(members)
        self.complaint = complaint

    def __missing__(self, name: str) -> Value:
        raise UnknownNameError.of(self.complaint, [str(name)], self)

    def __reduce__(self) -> tuple[object, ...]:
        return Named, (self.complaint, dict(self))


class RunError(M4eError):
    """The work failed: `message` says what, where and when; `remedy` what to try."""

    def __init__(self, message: str, remedy: str = "") -> None:
        self.message = message
        self.remedy = remedy
        super().__init__(_indented(f"{message}\n{remedy}" if remedy else message))


def _indented(text: str) -> str:
    """`text` whose further lines are indented: of what it quotes, none looks like one of ours."""
    return text.replace("\n", "\n      ")


def unknown_names(
    names: Iterable[str], known: Iterable[str], complaint: str, noun: str = ""
) -> list[Problem]:
    """A problem for each of `names` that is not `known`: `complaint`, the name, the nearest one."""
    there = dict.fromkeys(known)
    return [
        Problem(f"{complaint} {name!r}", suggestion(name, there, noun))
        for name in names
        if name not in there
    ]


def is_file(path: Path) -> bool:
    """True if there is a file; False also for a name that no file system takes."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_other(path: Path) -> bool:
    """True for a pipe, a device or a socket: something is there, and it is no file."""
    try:
        return path.exists() and not (path.is_file() or path.is_dir())
    except OSError:
        return False


def missing_file(path: Path, what: str = "file") -> tuple[str, str]:
    """Message and remedy for a path without a file: it or its folder is missing, or it is a folder.

    `what` is the kind of file, as "mesh file".
    """
    folder = path.parent
    text = str(path).encode(errors="replace")
    if len(text) > _LONGEST_PATH or max(map(len, text.split(b"/"))) > _LONGEST_NAME:
        return f"no such {what}: the name has {len(text)} bytes", "no file system takes it"
    if path.is_dir():
        return f"is a folder: {path}", f"name a {what}"
    if is_other(path):
        return f"is a pipe or a device: {path}", f"name a {what}"
    if not folder.is_dir():
        return f"no such folder: {folder}", f"it is to hold the {what} {path.name}"
    suffixes = YAML_SUFFIXES if path.suffix in YAML_SUFFIXES else (path.suffix,)
    names = [other.name for suffix in suffixes for other in folder.glob(f"*{suffix}")]
    return f"no such {what}: {path}", suggestion(path.name, names) if names else ""


def suggestion(word: str, known: Iterable[str], noun: str = "") -> str:
    """A remedy for an unknown `word`: the nearest known one, or a list of what there is.

    Before names that are only somewhat alike come those of which the word is a part, as ``spring``
    of ``torsion_spring``.
    """
    names: Sequence[str] = sorted(known)
    same = [name for name in names if name.lower() == word.lower()]
    whole = [name for name in names if word and word in re.split(r"[._]", name)]
    compared = [] if len(word) > _LONGEST_WORD else names[:_MOST_COMPARED]
    compared = [name for name in compared if len(name) <= _LONGEST_WORD]
    near = difflib.get_close_matches(word, compared, n=3, cutoff=0.6)
    likeness = [difflib.SequenceMatcher(None, name, word).ratio() for name in near]
    likely = same or (whole if len(whole) <= 3 and max(likeness, default=0) < CLOSE else [])
    if likely:
        return f"did you mean {' or '.join(map(repr, likely))}?"
    if near:
        nearest = sorted(n for n, ratio in zip(near, likeness, strict=True) if ratio == likeness[0])
        return f"did you mean {' or '.join(map(repr, nearest))}?"
    if not names:
        return f"there are no {noun} yet" if noun else ""
    shown = ", ".join(name[:_LONGEST_WORD] for name in names[:12]) + (
        ", …" if len(names) > 12 else ""
    )
    return f"known {noun}: {shown}" if noun else f"known: {shown}"
