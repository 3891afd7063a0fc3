"""The plotting library of the pages: the file of plotly.js that the package `plotly` brings."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from m4e_fmi.errors import RunError

_BEGIN, _END = b'"use strict";var Plotly=(()=>{', b"window.Plotly = Plotly;"
"""Where the library itself begins and ends in its file."""


def plotly_js() -> bytes:
    """The script plotly.min.js (MIT licence); the package is not imported, which takes a second.

    RunError if it is not there.
    """
    spec = find_spec("plotly")
    for folder in (spec and spec.submodule_search_locations) or ():
        path = Path(folder) / "package_data" / "plotly.min.js"
        if path.is_file():
            return unwrapped(path.read_bytes())
    raise RunError("plotly.js is not installed", "install it with: pip install 'plotly>=7.1,<8'")


def unwrapped(script: bytes) -> bytes:
    """The script without the function around it, that of modules for other environments.

    Browsers parse a function that is an argument twice, before and when it is called: of five
    megabytes that is a third of the time until the first plot. A script that is wrapped in another
    way is left as it is.
    """
    begin, end = script.find(_BEGIN), script.rfind(_END)
    if begin < 0 or end < begin or not script.startswith(b"/**"):
        return script
    licence = script[: script.index(b"*/") + 2]
    return licence + b"\n" + script[begin : end + len(_END)] + b"\n"
