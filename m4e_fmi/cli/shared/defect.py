"""The last resort: an error that nobody expected becomes one line, and a file to send."""

from __future__ import annotations

import platform
import tempfile
import traceback
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

import m4e_fmi

PACKAGES = ("numpy", "scipy", "sympy", "pydantic", "ruamel.yaml", "lxml", "FMPy", "netCDF4")


def defect_line(error: BaseException, arguments: Sequence[str]) -> str:
    """Text to print of an unexpected error, after the report on it has been written."""
    text = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    told = f"failed: {text}\n      this is a defect of m4e_fmi or of a kind, not of your input"
    try:
        path = write_report(error, arguments)
    except OSError as reason:
        return f"{told}; no report could be written: {reason}"
    return f"{told}; please send the report {path}"


def write_report(error: BaseException, arguments: Sequence[str]) -> str:
    """Path of a new file with traceback, versions and arguments; nothing of the environment."""
    lines = [
        *(f"{name} {one}" for name, one in versions().items()),
        f"arguments: {list(arguments)!r}",
        "",
        *traceback.format_exception(error),
    ]
    with tempfile.NamedTemporaryFile(
        "w", prefix="m4e_fmi_defect_", suffix=".txt", delete=False,
        encoding="utf-8", errors="backslashreplace",
    ) as file:  # fmt: skip
        file.write("\n".join(lines))
    return file.name


def versions() -> dict[str, str]:
    """Versions of m4e_fmi, Python, the platform and the main packages."""
    own = {"m4e_fmi": m4e_fmi.__version__, "Python": platform.python_version()}
    packages = {name: _version(name) for name in PACKAGES}
    return {**own, "platform": platform.platform(), **packages}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
