"""Templates, and small pieces of HTML: tables, lists, folded texts, whose texts are escaped."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files


def text_of(package: str, name: str) -> str:
    """The text of a file in a package."""
    return files(package).joinpath(name).read_text(encoding="utf-8")


def filled(template: str, marks: Mapping[str, str]) -> str:
    """A template with texts in place of its marks, all at once: a text may hold a mark."""
    return re.sub("|".join(marks), lambda mark: marks[mark[0]], template)


def json_text(data: object) -> str:
    """JSON that may stand in a script: no text in it ends that, or begins another."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c")


def escaped(text: object) -> str:
    """Text as HTML."""
    return html.escape(str(text))


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph of a class `kind`."""
    return f'<p class="{kind}">{escaped(text)}</p>' if kind else f"<p>{escaped(text)}</p>"


def facts(rows: Mapping[str, str]) -> str:
    """A table of names and texts, without those that are empty."""
    lines = (
        f'<tr><th scope="row">{escaped(name)}</th><td>{escaped(text)}</td></tr>'
        for name, text in rows.items()
        if text
    )
    return f'<table class="facts"><tbody>{"".join(lines)}</tbody></table>'


def cards(figures: Iterable[tuple[str, str, str]]) -> str:
    """Names, values and details of figures, the values large; nothing without any."""
    items = "".join(
        f'<div><dt>{escaped(name)}</dt><dd class="value">{escaped(value)}</dd>'
        f'<dd class="note">{escaped(detail)}</dd></div>'
        for name, value, detail in figures
    )
    return f'<dl class="cards">{items}</dl>' if items else ""


def table(
    caption: str, heads: Sequence[str], rows: Iterable[Sequence[str]], *, texts: int = 1
) -> str:
    """A table below its caption, whose first `texts` columns are texts and the others numbers.

    Columns without an entry are left out.
    """
    rows = list(rows)
    used = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    heads, rows = [heads[k] for k in used], [[row[k] for k in used] for row in rows]
    texts = sum(k < texts for k in used)
    kinds = [""] * texts + [' class="number"'] * (len(heads) - texts)
    head = "".join(
        f'<th scope="col"{kind}>{escaped(name)}</th>'
        for name, kind in zip(heads, kinds, strict=True)
    )
    body = "".join(
        "<tr>"
        + "".join(f"<td{kind}>{escaped(cell)}</td>" for cell, kind in zip(row, kinds, strict=True))
        + "</tr>"
        for row in rows
    )
    label = f' role="region" aria-label="{escaped(caption)}"' if caption else ""
    return (
        f"{paragraph(caption, 'note') if caption else ''}"
        f'<div class="wide" tabindex="0"{label}><table>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def lines(texts: Iterable[str]) -> str:
    """A list of lines; nothing without any."""
    items = "".join(f"<li>{escaped(text)}</li>" for text in texts if text)
    return f'<ul class="lines">{items}</ul>' if items else ""


def folded(title: str, text: str) -> str:
    """A text as it is, behind its title."""
    return (
        f"<details><summary>{escaped(title)}</summary>"
        f'<pre tabindex="0">{escaped(text)}</pre></details>'
    )
