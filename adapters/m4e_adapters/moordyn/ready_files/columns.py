"""The columns of each table of a MoorDyn file, and the check of a row against them.

MoorDyn 2.7.2 reads of a word as many characters as make a number, and 0 where there are none.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from m4e_adapters.moordyn.ready_files.read_file import ReadFile, has_force
from m4e_adapters.moordyn.ready_files.sections import Row, number

FORTRAN = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))[dD]([+-]?\d+)")
"""A number with an exponent that only Fortran knows: 5.83D8."""


@dataclass(frozen=True)
class Column:
    """Name of the numbers in a column, and least and largest value, in `units`.

    `whole` numbers have no decimals; `counts` are how many values, separated by |, may be given.
    """

    name: str
    least: float
    largest: float
    whole: bool = False
    counts: tuple[int, ...] = (1,)
    units: str = "SI units"


PLACE = Column("coordinate", -1e7, 1e7)
ANGLE = Column("angle", -360.0, 360.0, units="degrees")
FORCE = Column("constant force", -1e12, 1e12)
MASS, VOLUME = Column("mass", 0.0, 1e12), Column("volume", 0.0, 1e9)
DIAMETER = Column("diameter", 1e-6, 1e3)
POINT_DRAG = Column("drag area CdA", 0.0, 1e9)
POINT_ADDED_MASS = Column("added mass coefficient CA", 0.0, 1e3)
DRAG = Column("drag coefficient Cd", 0.0, 1e3)
ADDED_MASS = Column("added mass coefficient Ca", 0.0, 1e3)
LINE_TYPE = {
    1: DIAMETER,
    2: Column("mass per length", 1e-6, 1e6),
    3: Column("stiffness EA", 1e-3, 1e15),
    4: Column("damping BA", -1e6, 1e15),  # a negative one is a damping ratio
    5: Column("bending stiffness EI", 0.0, 1e15),
    6: DRAG,
    7: ADDED_MASS,
    8: Column("axial drag coefficient CdAx", 0.0, 1e3),
    9: Column("axial added mass coefficient CaAx", 0.0, 1e3),
}
ROD_TYPE = {
    1: DIAMETER,
    2: Column("mass per length", 0.0, 1e9),
    3: DRAG,
    4: ADDED_MASS,
    5: Column("drag coefficient of the ends CdEnd", 0.0, 1e3),
    6: Column("added mass coefficient of the ends CaEnd", 0.0, 1e3),
}
BODY = {
    **dict.fromkeys((2, 3, 4), PLACE),
    **dict.fromkeys((5, 6, 7), ANGLE),
    8: MASS,
    9: Column("centre of gravity", -1e7, 1e7, counts=(1, 3)),
    10: Column("moment of inertia", 0.0, 1e18, counts=(1, 3)),
    11: VOLUME,
    12: Column("drag area CdA", 0.0, 1e15, counts=(1, 2, 3, 6)),  # of rotations [m⁵], too
    13: Column("added mass coefficient Ca", 0.0, 1e3, counts=(1, 3)),
}
ROD = {
    **dict.fromkeys(range(3, 9), PLACE),
    9: Column("number of segments", 0, 1000, whole=True),  # 0: a rod without length
}
POINT = {**dict.fromkeys((2, 3, 4), PLACE), 5: MASS, 6: VOLUME}
LINE = {
    4: Column("unstretched length", 1e-3, 1e6),
    5: Column("number of segments", 1, 1000, whole=True),
}
WORDS = {"line types": 10, "rod types": 7, "bodies": 14, "rods": 11, "points": 9, "lines": 7}
"""The least number of words in a row of each table."""
TABLES = {"line types": LINE_TYPE, "rod types": ROD_TYPE, "bodies": BODY, "rods": ROD}
TABLES |= {"lines": LINE}


def check_columns(file: ReadFile, section: str, row: Row) -> None:
    """Note the words of `row` that are no number, or none that can be meant."""
    columns = _point(row) if section == "points" else TABLES[section]
    for k, column in columns.items():
        _check_values(file, row, k, column)


def _check_values(file: ReadFile, row: Row, k: int, column: Column) -> None:
    """Note the first value in word `k` that is not one of `column`, or how many there are."""
    word = row.words[k]
    values = word.split("|") if len(column.counts) > 1 else [word]
    if len(values) not in column.counts:
        message = f"{column.name}: {word!r} has {len(values)} values"
        *few, most = map(str, column.counts)
        remedy = f"give {', '.join(few)} or {most} of them, with | in between"
        file.wrong(row, message, remedy, k)
        return
    for value in values:
        fault = _fault(column, value)
        if fault:
            file.wrong(row, *fault, k)
            return


def no_number(name: str, word: str, remedy: str) -> tuple[str, str]:
    """Message and remedy for a `word` that is no number; `remedy` where none is nearer."""
    message = f"{name}: {word!r} is not a number"
    fortran = FORTRAN.fullmatch(word)
    if fortran:
        written = "E".join(fortran.groups())
        return message, f"MoorDyn would read {fortran[1]}: write {written}"
    return message, remedy


def out_of_range(column: Column, word: str) -> tuple[str, str]:
    """Message and remedy for the number `word` outside of the range of `column`."""
    value, name = float(word), column.name
    limits = f"give a value between {column.least:g} and {column.largest:g}, in {column.units}"
    if column.whole:
        limits = f"give a whole number between {column.least:g} and {column.largest:g}"
    if value < 0 <= column.least:
        return f"{name} must not be negative, got {word}", f"check its sign: {limits}"
    if value == 0 < column.least:
        return f"{name} must be positive, got {word}", limits
    return f"{name} {word} cannot be meant", limits


def _point(row: Row) -> dict[int, Column]:
    force = dict.fromkeys((7, 8, 9), FORCE) if has_force(row) else {}
    last = 7 + len(force)
    return {**POINT, **force, last: POINT_DRAG, last + 1: POINT_ADDED_MASS}


def _fault(column: Column, word: str) -> tuple[str, str] | None:
    if not number(word):
        remedy = f"give the {column.name} as a number; tables in other files are not supported"
        return no_number(column.name, word, remedy)
    if not column.least <= float(word) <= column.largest:
        return out_of_range(column, word)
    if column.whole and float(word) != int(float(word)):
        return f"{column.name}: {word} is not a whole number", "give a whole number"
    return None
