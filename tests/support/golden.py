"""Texts that are kept word for word in a file; ``pytest --update`` writes it anew."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import pytest

from m4e_fmi.errors import InputError

Change = TypeVar("Change")


def check_messages(
    golden: Path,
    cases: Mapping[str, Change],
    message: Callable[[Change], str],
    request: pytest.FixtureRequest,
) -> None:
    """Compare the messages of all `cases`, by name, with the file `golden`."""
    found = "\n".join(f"== {name}\n{message(case)}\n" for name, case in cases.items())
    if request.config.getoption("--update"):
        golden.write_text(found, "utf-8")
    assert found == golden.read_text("utf-8")


def refused(
    path: Path, good: str, changes: Mapping[str, str], read: Callable[[Path], object]
) -> str:
    """The error of the text `good` at `path` with each old text, there once, made the new one."""
    for old, new in changes.items():
        assert good.count(old) == 1, old
        good = good.replace(old, new)
    path.write_text(good, "utf-8")
    with pytest.raises(InputError) as caught:
        read(path)
    return str(caught.value).replace(f"{path.parent}/", "")
