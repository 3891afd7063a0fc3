"""A sheet of HTML with a title, tables and notes.

Texts are escaped and shortened. Colours are those of the notebook, so that it may be light or dark.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from m4e_fmi.shown import one_line

MOST_ROWS = 60
LONGEST = 160
"""Characters of a text."""
FLOAT = ".6g"
# of cells the class is there thrice: the rules of notebooks that align them to the right have two
STYLE = """\
.m4e-fmi{font-size:.92em;line-height:1.4;overflow-x:auto}
.m4e-fmi table{border-collapse:collapse;margin:.3em 0 .8em}
.m4e-fmi.m4e-fmi.m4e-fmi :is(th,td){text-align:left;vertical-align:top;padding:.15em .7em .15em 0;
border-bottom:1px solid rgba(128,128,128,.3);background:none;color:inherit}
.m4e-fmi .scroll{max-height:26em;overflow:auto}
.m4e-fmi.m4e-fmi.m4e-fmi .number.number{text-align:right;
font-variant-numeric:tabular-nums;white-space:nowrap}
.m4e-fmi .note{opacity:.75}
"""


def text(value: object) -> str:
    """`value` as one line of HTML, escaped and shortened."""
    line = one_line(str(value))
    return escape(line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…", quote=True)


class Sheet:
    """Parts of HTML under a title."""

    def __init__(self, title: str, *facts: str) -> None:
        told = " · ".join(text(fact) for fact in facts if fact)
        self._parts = [f"<p><strong>{text(title)}</strong>{'<br>' if told else ''}{told}</p>"]

    def note(self, line: str) -> None:
        """Add a line of text."""
        self._parts.append(f'<p class="note">{text(line)}</p>')

    def lines(self, title: str, lines: Iterable[object]) -> None:
        """Add a list of texts under a title; nothing without lines."""
        self.table((title,), [(line,) for line in lines])

    def table(
        self, heads: Sequence[str], rows: Iterable[Sequence[object]], *, more: int = 0
    ) -> None:
        """Add a table of texts and numbers, without the columns that are empty.

        Floats are numbers; None is a dash. Of many rows the first, and how many further ones there
        are, with `more` that the caller has left out.
        """
        rows = list(rows)
        kept = [k for k in range(len(heads)) if any(row[k] not in ("", None) for row in rows)]
        if not kept:
            return
        numbers = (' class="number"' if isinstance(rows[0][k], float) else "" for k in kept)
        head = "".join(f"<th{c}>{text(heads[k])}</th>" for c, k in zip(numbers, kept, strict=True))
        body = "".join(
            f"<tr>{''.join(_cell(row[k]) for k in kept)}</tr>" for row in rows[:MOST_ROWS]
        )
        self._parts.append(f'<div class="scroll"><table><tr>{head}</tr>{body}</table></div>')
        if left := max(0, len(rows) - MOST_ROWS) + more:
            self.note(f"and {left} more")

    def html(self) -> str:
        """All parts."""
        return f'<div class="m4e-fmi"><style>{STYLE}</style>{"".join(self._parts)}</div>'


def _cell(value: object) -> str:
    if value is None or isinstance(value, float):
        number = "–" if value is None else format(value, FLOAT).replace("-", "−")
        return f'<td class="number">{number}</td>'
    return f"<td>{text(value)}</td>"
