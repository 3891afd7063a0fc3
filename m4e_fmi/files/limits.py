"""Limits of input files: beyond them a file is refused by name, before it takes memory or time.

So are times of runs, and numbers of steps and rows. Each limit is far beyond honest use, whose
largest cases are named beside it, and low enough for a machine with a few GB of memory. The table
in docs/safety.md is made of LIMITS.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from m4e_fmi.units import LARGEST_EXPONENT, LONGEST_UNIT

MB = 1_000_000

LARGEST_YAML = 10 * MB
MOST_WRITTEN = 100_000
MOST_VALUES = 200_000
DEEPEST_YAML = 100
LONGEST_SCALAR = 100_000

LARGEST_XML = 50 * MB
MOST_ELEMENTS = 2_000_000
DEEPEST_XML = 100

LARGEST_UNPACKED = 16_000 * MB
SMALL = 10 * MB
LARGEST_RATIO = 200
MOST_ENTRIES = 100_000
LONGEST_NAME = 255
DEEPEST_FOLDER = 50

LARGEST_TABLE = 20 * MB
LARGEST_RECORD = 500 * MB
LARGEST_LINE_FILE = 10 * MB
LARGEST_MESH = 300 * MB
LARGEST_QTF = 200 * MB
LARGEST_COEFFICIENTS = 500 * MB
LARGEST_PROGRAM = 1_000 * MB
LARGEST_CHECKPOINT = 4_000 * MB
MOST_RESULTS = 2_000_000_000
LARGEST_SCENE = 20 * MB

LARGEST_BITS = 1023

LONGEST_RUN = 4_000_000_000
MOST_STEPS = 10_000_000_000
MOST_ROWS = 100_000_000


class Limit(NamedTuple):
    """A row of the table: kind of file, limited quantity, its size and unit, the reason."""

    file: str
    what: str
    most: int
    unit: str
    reason: str


LIMITS = (
    Limit("YAML, JSON", "size", LARGEST_YAML, "bytes", "a model of 500 bodies has 0.3 MB"),
    Limit("YAML, JSON", "keys and values as written", MOST_WRITTEN, "",
          "a model of 500 bodies has 20,000; each takes 0.1 ms"),
    Limit("YAML, JSON", "values with aliases written out", MOST_VALUES, "",
          "twice as many as can be written: aliases of aliases grow without bound"),
    Limit("YAML, JSON", "depth of nesting", DEEPEST_YAML, "levels", "no format here has over 10"),
    Limit("YAML, JSON", "length of one key or value", LONGEST_SCALAR, "characters",
          "a long description has 2,000"),
    Limit("YAML, JSON", "size of a whole number", LARGEST_BITS, "bits",
          "what a floating-point number holds"),
    Limit("XML in FMUs and SSP packages", "size", LARGEST_XML, "bytes",
          "200,000 variables with descriptions have 40 MB"),
    Limit("XML in FMUs and SSP packages", "elements", MOST_ELEMENTS, "",
          "200,000 variables of FMI 2.0 have 600,000"),
    Limit("XML in FMUs and SSP packages", "depth of nesting", DEEPEST_XML, "levels",
          "FMI has 6, SSP 3 for each level of systems"),
    Limit("FMU, SSP package", "unpacked size", LARGEST_UNPACKED, "bytes",
          "FMUs with 2 GB of resources exist"),
    Limit("FMU, SSP package", f"unpacked over packed size, above {SMALL // MB} MB unpacked",
          LARGEST_RATIO, "", "tables and texts are packed to a tenth, a bomb to a thousandth"),
    Limit("FMU, SSP package", "entries", MOST_ENTRIES, "",
          "an FMU with a Python installation has 20,000"),
    Limit("FMU, SSP package", "length of a file's or folder's name", LONGEST_NAME, "bytes",
          "no usual file system takes more"),
    Limit("FMU, SSP package", "folders in folders", DEEPEST_FOLDER, "levels",
          "a Python installation has 15"),
    Limit("CSV table", "size", LARGEST_TABLE, "bytes",
          "10,000 rows, as many as a table takes, of 100 columns"),
    Limit("CSV of results, to be compared", "size", LARGEST_RECORD, "bytes",
          "an hour of 20 rows a second of 100 variables has 100 MB"),
    Limit("MoorDyn file", "size", LARGEST_LINE_FILE, "bytes", "100 lines have 20 kB"),
    Limit("mesh", "size", LARGEST_MESH, "bytes", "a million triangles as ASCII STL have 270 MB"),
    Limit("WAMIT drift forces", "size", LARGEST_QTF, "bytes",
          "six QTFs of 40 frequencies in 36 directions have 18 MB"),
    Limit("hydrodynamic coefficients", "size", LARGEST_COEFFICIENTS, "bytes",
          "two bodies at 260 frequencies have 2 MB, 36 directions at 500 frequencies 30 MB"),
    Limit("program", "size", LARGEST_PROGRAM, "bytes",
          "the C library of an FMU reads 1,073 MB"),
    Limit("checkpoint", "size", LARGEST_CHECKPOINT, "bytes",
          "that of a ring of 200 FMUs has 2 MB; states of some FMUs are large"),
    Limit("results", "values", MOST_RESULTS, "",
          "a day of 100 rows a second of 100 variables has 900,000,000"),
    Limit("results", "unpacked scene of an animation", LARGEST_SCENE, "bytes",
          "100 meshes of 2,000 triangles have 7 MB"),
    Limit("run, simulation, study", "times", LONGEST_RUN, "s",
          "126 years: nanoseconds that fit twice into 63 bits"),
    Limit("run, simulation, study", "fixed steps of one run", MOST_STEPS, "",
          "a week of 0.1 ms has 6,048,000,000; "
          "steps meant in another unit are a thousand times as many"),
    Limit("run, simulation, study", "rows of one run at a given output interval", MOST_ROWS, "",
          "a day of 1,000 rows a second has 86,400,000"),
    Limit("units", "length", LONGEST_UNIT, "characters", "units of physics have up to 20"),
    Limit("units", "exponent", LARGEST_EXPONENT, "", "units of physics have exponents up to 6"),
)  # fmt: skip


def beyond_limits(
    stop_time: float, *, output_interval: float | None = None, step_size: float | None = None
) -> Iterator[tuple[str, str, str]]:
    """Settings of a run of `stop_time` [s] that are beyond the limits: key, message, remedy.

    Times [s] that are not above 0 have problems of their own, and none here.
    """
    if stop_time > LONGEST_RUN:
        counted = f"times are counted up to {LONGEST_RUN:g} s"
        yield "stop_time", f"stop_time {stop_time:g} s: {counted}", "shorten the run"
        return
    for key, time, most, what in (
        ("output_interval", output_interval, MOST_ROWS, "rows"),
        ("step_size", step_size, MOST_STEPS, "steps"),
    ):
        if time and 0.0 < time * most < stop_time:
            yield (
                key,
                f"{key} {time:g} s: {stop_time / time:.3g} {what} in {stop_time:g} s, "
                f"{most:,} at most",
                f"take {stop_time / most:g} s or more, or a shorter run",
            )
