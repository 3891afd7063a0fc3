"""A program in a file, in its binary form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.files_read import TooLongError, read_bytes
from m4e_fmi.files.limits import LARGEST_PROGRAM
from m4e_fmi.files.writing import written
from m4e_fmi.program.binary_form import decode, encode
from m4e_fmi.program.program import Program


def save_program(program: Program, path: str | Path) -> None:
    """Write a program to a file in its binary form.

    The program that is read back is equal to the saved one and runs to the same bits; only its
    `solutions` and `parts` are not kept. RunError if the file cannot be written.
    """
    with written(path) as part:
        part.write_bytes(encode(program))


def load_program(path: str | Path) -> Program:
    """The program in a file; InputError if there is none, or if it is damaged or foreign."""
    try:
        data = read_bytes(path, largest=LARGEST_PROGRAM)
    except TooLongError as error:
        raise InputError.single(f"is no program: it {error}", "", str(path)) from error
    except OSError as error:
        raise InputError.single(f"{path}: cannot be read: {error.strerror}") from error
    try:
        return decode(data)[0]
    except InputError as error:
        problems = [replace(problem, file=str(path)) for problem in error.problems]
        raise InputError(problems) from error
