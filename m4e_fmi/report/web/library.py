"""The plotting library of the pages: the file of plotly.js that the package `plotly` brings."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from m4e_fmi.errors import RunError


def plotly_js() -> bytes:
    """The script plotly.min.js (MIT licence); the package is not imported, which takes a second.

    RunError if it is not there.
    """
    spec = find_spec("plotly")
    for folder in (spec and spec.submodule_search_locations) or ():
        path = Path(folder) / "package_data" / "plotly.min.js"
        if path.is_file():
            return path.read_bytes()
    raise RunError("plotly.js is not installed", "install it with: pip install 'plotly>=7.1,<8'")
