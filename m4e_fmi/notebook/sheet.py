"""A sheet of HTML with a title, tables and notes, which is never long.

Texts are escaped and shortened. Colours are those of the notebook, so that it may be light or dark.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from m4e_fmi.shown import one_line

MOST = 80_000
"""Characters of the parts of a sheet; what does not fit is counted."""
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
.m4e-fmi .equations{list-style:none;padding:0}
.m4e-fmi .equations li{display:flex;gap:2em;align-items:center;padding:.2em 0}
.m4e-fmi .equations math{display:inline math;margin:0}
"""


def text(value: object) -> str:
    """`value` as one line of HTML, escaped and shortened."""
    line = one_line(str(value))
    return escape(line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…", quote=True)


class Sheet:
    """Parts of HTML under a title, as many as fit."""

    def __init__(self, title: str, *facts: str) -> None:
        told = " · ".join(text(fact) for fact in facts if fact)
        self._parts = [f"<p><strong>{text(title)}</strong>{'<br>' if told else ''}{told}</p>"]
        self._room = MOST
        self._left_out = 0

    def markup(self, made: str) -> bool:
        """Add a part that is HTML already; False if there is no room for it."""
        if len(made) > self._room:
            self._left_out += 1
            return False
        self._room -= len(made)
        self._parts.append(made)
        return True

    def note(self, line: str) -> None:
        """Add a line of text."""
        self.markup(f'<p class="note">{text(line)}</p>')

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
        made: list[str] = []
        room = min(self._room // 2, 30_000)
        for row in rows[:MOST_ROWS]:
            cells = "".join(_cell(row[k]) for k in kept)
            room -= len(cells)
            if room < 0:
                break
            made.append(f"<tr>{cells}</tr>")
        kinds = (' class="number"' if isinstance(rows[0][k], float) else "" for k in kept)
        head = "".join(f"<th{c}>{text(heads[k])}</th>" for c, k in zip(kinds, kept, strict=True))
        left = len(rows) - len(made) + more
        rest = f'<p class="note">and {left} more</p>' if left else ""
        body = "".join(made)
        self.markup(f'<div class="scroll"><table><tr>{head}</tr>{body}</table></div>{rest}')

    def html(self) -> str:
        """All parts, and how many were left out."""
        parts = list(self._parts)
        if self._left_out:
            parts.append(f'<p class="note">and {self._left_out} further parts</p>')
        return f'<div class="m4e-fmi"><style>{STYLE}</style>{"".join(parts)}</div>'


def _cell(value: object) -> str:
    if value is None or isinstance(value, float):
        number = "–" if value is None else format(value, FLOAT).replace("-", "−")
        return f'<td class="number">{number}</td>'
    return f"<td>{text(value)}</td>"
