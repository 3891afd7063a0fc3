"""The record beside an FMU that was built here: what it was made from, and its own content.

It is in ``name.build.json`` beside ``name.fmu``. A record that does not fit the FMU beside it, as
after a build that was killed or another FMU copied to its place, counts as none. Files of the same
project are recorded by their way from the FMU, so that a project that is moved need not be built
again.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

from pydantic import Field

from m4e_fmi.files.document import Section
from m4e_fmi.files.files_read import are_unchanged, file_hash
from m4e_fmi.files.writing import written

SUFFIX = ".build.json"


class BuildRecord(Section):
    """`fmu` is the SHA-256 of the FMU, `files` those of the files it was made from, by path.

    `made_from` is a hash of all else that it was made from: configuration, options and code; ""
    where that was not told. `warnings` were given while it was made.
    """

    fmu: str
    made_from: str = ""
    files: dict[str, str | None] = Field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def is_current(self, made_from: str) -> bool:
        """True if the FMU is what would be built now: same code and configuration, same files."""
        return self.made_from == made_from != "" and are_unchanged(self.files)


def read_record(fmu: Path) -> BuildRecord | None:
    """The record of an FMU that was built here and is as it was then; None for any other file."""
    try:
        record = BuildRecord.model_validate(json.loads(_place(fmu).read_bytes()))
    except (OSError, ValueError, RecursionError):
        return None
    if record.fmu != file_hash(fmu):
        return None
    here = fmu.absolute().parent
    files = {os.path.normpath(here / path): found for path, found in record.files.items()}
    return record.model_copy(update={"files": files})


def write_record(fmu: Path, record: BuildRecord) -> None:
    """Write the record of `fmu` beside it; RunError if that cannot be."""
    files = {way_to(Path(path), fmu): content for path, content in record.files.items()}
    record = record.model_copy(update={"files": files})
    with written(_place(fmu)) as part:
        part.write_text(json.dumps(record.model_dump(), indent=1) + "\n", encoding="ascii")


def way_to(path: Path, fmu: Path) -> str:
    """`path` by its way from the folder of `fmu`, if both are in one project; else from the root.

    A project is the folder in which the build folder is: its FMUs are in ``build/NAME``.
    """
    path, here = path.absolute(), fmu.absolute().parent
    project = here.parents[1] if len(here.parents) > 1 else here
    if ".." in path.parts or project == project.parent or not path.is_relative_to(project):
        return str(path)
    return os.path.relpath(path, here)


def _place(fmu: Path) -> Path:
    return fmu.with_name(f"{fmu.name.removesuffix('.fmu')}{SUFFIX}")
