"""Pages of the scripts in examples/: cells of text and of code, what they print and draw."""

from __future__ import annotations

import contextlib
import io
import re
import runpy
import shutil
from pathlib import Path

ANIMATION = '<iframe class="animation" src="../../{name}" title="{title}"></iframe>\n'
CELL = re.compile(r"^# %%(?: \[(markdown)\])?\n", re.MULTILINE)


def script_text(script: str) -> str:
    """The Markdown of a script in the percent format: cells start with `# %%`.

    A cell of text starts with `# %% [markdown]`, and each of its lines with `#`.
    """
    _, *cells = CELL.split(script)
    parts = []
    for kind, cell in zip(cells[::2], cells[1::2], strict=True):
        if kind:
            parts.append(re.sub(r"^# ?", "", cell.strip(), flags=re.MULTILINE))
        elif cell.strip() and "__main__" not in cell:
            parts.append(f"```python\n{cell.strip()}\n```")
    return "\n\n".join(parts) + "\n"


def write_script_page(script: Path, folder: Path, *, run: bool = True) -> None:
    """Write `folder`/NAME.md from `script`, NAME.py, and run it there as the main program.

    What it prints ends the page, with the pictures and animations that it leaves in its folder
    build/. Pages of animations are expected two folders above that of the page. Without `run` the
    page has nothing of these.
    """
    work = folder / script.stem
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    printed = io.StringIO()
    with contextlib.chdir(work), contextlib.redirect_stdout(printed):
        runpy.run_path(str(script), run_name="__main__" if run else script.stem)
    place = f"This is `examples/{script.parent.name}/{script.name}`."
    title, _, rest = script_text(script.read_text(encoding="utf-8")).partition("\n")
    pictures = sorted(path.relative_to(folder) for path in work.rglob("*.png"))
    animations = sorted(work.rglob("*.html"))
    result = [
        "## What it prints and draws\n",
        f"```text\n{printed.getvalue()}```\n",
        *(f"![{path.stem}]({path})\n" for path in pictures),
        *(ANIMATION.format(name=path.name, title=path.stem) for path in animations),
    ]
    page = "\n".join([title, "", place, rest, *result])
    (folder / f"{script.stem}.md").write_text(page, encoding="utf-8")
