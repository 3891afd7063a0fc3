"""The last resort: an error that nobody expected becomes one line, and a file to send."""

from __future__ import annotations

import tempfile
import traceback
from collections.abc import Sequence

from m4e_fmi.doctor import versions


def defect_line(error: BaseException, arguments: Sequence[str]) -> str:
    """Text to print of an unexpected error, after the report on it has been written.

    The report has traceback, versions and arguments; nothing of the environment.
    """
    text = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    told = f"failed: {text}\n      this is a defect of m4e_fmi or of a kind, not of your input"
    lines = [
        *(f"{name} {one}" for name, one in versions().items()),
        f"arguments: {list(arguments)!r}",
        "",
        *traceback.format_exception(error),
    ]
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="m4e_fmi_defect_", suffix=".txt", delete=False,
            encoding="utf-8", errors="backslashreplace",
        ) as file:  # fmt: skip
            file.write("\n".join(lines))
    except OSError as reason:
        return f"{told}; no report could be written: {reason}"
    return f"{told}; please send the report {file.name}"
