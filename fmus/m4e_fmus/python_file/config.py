"""Keys of a `kind: python` component of a system file."""

from __future__ import annotations

from m4e_fmi.files.document import Section


class Config(Section):
    """A component in one Python `file`, with a class that declares variables and computes.

    `files` are others that it reads or imports, which travel beside it in the FMU. Both are
    relative to the system file's folder. The file is run when the system is read.
    """

    file: str
    files: tuple[str, ...] = ()
