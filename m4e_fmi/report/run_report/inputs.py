"""Input files with their SHA-256, and versions of packages: all that a run was made of."""

from __future__ import annotations

import hashlib
import platform
import re
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

import m4e_fmi
from m4e_fmi.report.run_report.record import LONGEST, InputFile

_NAME = re.compile(r"[\w.-]+")
"""The name that a requirement begins with; `packaging` would be most of a short command's time."""


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
            name, extra = _NAME.match(text), "extra ==" in text
            if name and not extra:
                with suppress(PackageNotFoundError):
                    found[name[0]] = version(name[0])
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
