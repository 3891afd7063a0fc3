"""An algorithm in a file of its own, beside those of the package."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from m4e_fmi.coupling_algorithms import FOLDERS, PACKAGE


@pytest.fixture
def example() -> Iterator[None]:
    """The folder of `tests/support/algorithms` as one of the folders of algorithms."""
    folder = str(Path(__file__).parents[3] / "support" / "algorithms")
    FOLDERS.append(folder)
    yield
    FOLDERS.remove(folder)
    sys.modules.pop(f"{PACKAGE}.last_first", None)
