"""Fixtures that several folders of tests share."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from support.c_fmus.build import build


@pytest.fixture(scope="session")
def c_fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """`c_fmu(name)` is the path of the FMU of a C model of tests/support/c_fmus, compiled once."""
    folder = tmp_path_factory.mktemp("c_fmus")
    return cache(lambda name: build(name, folder))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update", action="store_true", help="write reference series and golden files anew"
    )
