"""Docstrings for Sphinx.

They are plain text with `names` in backticks; `|v|`, `B*` and `x_` are mathematics in them, not
marks of reStructuredText.
"""

from __future__ import annotations

import re

CODE = re.compile(r"(`+[^`]+`+)")
MARKS = re.compile(r"([|*_])")


def rest_of_docstring(
    _app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Sphinx's hook `autodoc-process-docstring`: change the lines in place."""
    lines[:] = [escaped(line) for line in lines]


def escaped(line: str) -> str:
    """The line with marks outside of backticks taken as they are."""
    parts = CODE.split(line)
    parts[::2] = [MARKS.sub(r"\\\1", part) for part in parts[::2]]
    return "".join(parts)
