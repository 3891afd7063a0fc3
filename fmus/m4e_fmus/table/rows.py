"""The numbers of a time table, from its configuration or from its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.csv_columns import Asked, read_columns, shortened
from m4e_fmus.table.config import ORDER, Config, disorder


@dataclass(frozen=True)
class Rows:
    """`times` [s], which do not descend, and the values of each signal at them, in its unit."""

    times: tuple[float, ...]
    values: dict[str, tuple[float, ...]]


def _asked(config: Config) -> dict[str, Asked]:
    """By the name of a column, who asks for it."""
    found = {
        signal.column or name: Asked(
            f"which the system file asks for as the signal {name!r}",
            f"mend the name in one of the two, or give {name!r} its 'column' in the system file",
        )
        for name, signal in config.signals.items()
    }
    if config.time:
        found[config.time] = Asked(
            "which the system file asks for under 'time'",
            "mend the name in one of the two; without 'time', the first column is taken",
        )
    return found


def read_rows(config: Config, folder: Path) -> Rows:
    """The rows of the table; InputError with all problems of its file, which is in `folder`."""
    if config.file is None:
        given = {name: signal.values or () for name, signal in config.signals.items()}
        return Rows(config.times or (), given)
    path = folder / config.file
    columns = [(signal.column or name, signal.unit) for name, signal in config.signals.items()]
    found = read_columns(path, [(config.time or 0, "s"), *columns], _asked(config))
    if not found.lines:
        raise InputError.single("has no rows below its first", "", str(path))
    times, *values = found.values
    problems = [found.problem(row, message, ORDER) for row, message in disorder(times)]
    if problems:
        raise InputError(shortened(problems))
    return Rows(tuple(times), dict(zip(config.signals, map(tuple, values), strict=True)))
