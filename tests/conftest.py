"""Fixtures that several folders of tests share."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from support.c_fmus.build import build
from support.c_fmus.kinds import build_kinds
from support.c_fmus.versions import build_version


@pytest.fixture(scope="session")
def c_fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """`c_fmu(name)` is the path of the FMU of a C model of tests/support/c_fmus, compiled once.

    ``1:name`` and ``3:name`` are of FMI 1.0 and 3.0.
    """
    folder = tmp_path_factory.mktemp("c_fmus")

    def built(name: str) -> Path:
        version, colon, model = name.partition(":")
        what, *options = (model or name).split("+")
        if what == "kinds":
            return build_kinds(int(version) if colon else 2, options, folder)
        return build_version(version, model, folder) if colon else build(name, folder)

    return cache(built)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update", action="store_true", help="write reference series and golden files anew"
    )
