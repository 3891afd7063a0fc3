"""Loading a system: a YAML file or an SSP package."""

from __future__ import annotations

from pathlib import Path

from m4e_fmi.cosim.ssp.package import SUFFIX
from m4e_fmi.cosim.ssp.read import read_ssp
from m4e_fmi.cosim.system.system import System
from m4e_fmi.cosim.system_file import read_system
from m4e_fmi.files.document import Document
from m4e_fmi.files.file_kinds import as_path


def load_system(path: str | Path) -> System:
    """The system in a YAML file or an SSP package; InputError with all problems found in it."""
    if as_path(path).suffix.lower() == SUFFIX:
        return read_ssp(path)
    return read_system(Document.load(path))
