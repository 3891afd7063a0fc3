"""Docstrings for Sphinx.

They are plain text with `names` in backticks; `|v|`, `B*` and `x_` are mathematics in them, not
marks of reStructuredText.
"""

from __future__ import annotations

import re

CODE = re.compile(r"(`+[^`]+`+)")
MARKS = re.compile(r"([|*_])")
EXAMPLE = (">>> ", "... ")


def plain_docstring(
    _app: object, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    """Sphinx's hook `autodoc-process-docstring`: change the lines in place."""
    lines[:] = [escaped(line) for line in lines]


def escaped(line: str) -> str:
    """The line with marks outside of backticks taken as they are; examples stay.

    Names in backticks may be part of a word: `Variable`s.
    """
    if line.lstrip().startswith(EXAMPLE):
        return line
    parts = CODE.split(line)
    texts = [MARKS.sub(r"\\\1", text) for text in parts[::2]]
    for k in range(1, len(texts)):
        if texts[k][:1].isalnum():
            texts[k] = "\\ " + texts[k]
    parts[::2] = texts
    return "".join(parts)
