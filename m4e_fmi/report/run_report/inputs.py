"""Input files with their SHA-256, and versions of packages: all that a run was made of."""

from __future__ import annotations

import hashlib
import platform
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from packaging.requirements import Requirement

import m4e_fmi
from m4e_fmi.report.run_report.record import LONGEST, InputFile


@cache
def versions() -> dict[str, str]:
    """Versions of m4e_fmi, of Python and the platform, and of the packages that it requires."""
    found = {
        "m4e_fmi": m4e_fmi.__version__,
        "Python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }
    with suppress(PackageNotFoundError):  # a source tree that is not installed
        for text in requires("m4e_fmi") or ():
            needed = Requirement(text)
            if needed.marker is None or needed.marker.evaluate({"extra": ""}):
                with suppress(PackageNotFoundError):
                    found[needed.name] = version(needed.name)
    return found


def input_file(path: Path, name: str, *, kept: bool = True) -> InputFile | None:
    """A file, with its text if that is `kept` and not too long; None if it cannot be read."""
    try:
        data = path.read_bytes() if path.is_file() else None
    except (OSError, ValueError):
        return None
    if data is None:
        return None
    text = None
    if kept and len(data) <= LONGEST:
        text = data.decode("utf-8-sig", errors="replace").replace("\r\n", "\n")
    return InputFile(name, hashlib.sha256(data).hexdigest(), text)
