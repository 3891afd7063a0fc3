"""Remedies for libraries of FMUs that cannot be loaded."""

from __future__ import annotations

import re

_MISSING = re.compile(
    r"([^\s/:]+): cannot open shared object file|Library not loaded: (?:\S*/)?(\S+)"
)
"""Words of the loaders of Linux and macOS; that of Windows does not name the library."""
_SYMBOL = re.compile(r"(?:undefined symbol: |ymbol not found\D*?[:'] ?'?)(\w+)")


def remedy_for(why: str, version: str) -> str:
    """The remedy where an FMU's library is not loaded, by the loader's words.

    `version` is that of FMI.
    """
    found, symbol = _MISSING.search(why), _SYMBOL.search(why)
    if symbol and "fmi" not in symbol[1]:
        return (
            f"none of the libraries that it needs has {symbol[1]}: one of them is of another "
            "version here, or the FMU was linked without it; ask the FMU's author"
        )
    if not found:
        return f"a library it needs is missing, or it is not an FMI {version} binary"
    name = found[1] or found[2]
    return (
        f"install the package of your system that has {name}, which the FMU needs (on Debian and "
        f"Ubuntu `apt-file search {name}` finds it), or ask the FMU's author for one without"
    )
