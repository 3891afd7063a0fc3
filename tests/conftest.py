"""Fixtures that several folders of tests share."""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from support import defects
from support.c_fmus.build import build
from support.c_fmus.kinds import build_kinds
from support.c_fmus.versions import build_version
from support.python_executor import use_python

from m4e_fmi.cli import COLLECTION
from m4e_fmi.files.files_read import file_hash
from m4e_fmi.fmu.export.build_record import BuildRecord, write_record


@pytest.fixture(scope="session")
def c_fmu(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Callable[[str], Path]:
    """`c_fmu(name)` is the path of the FMU of a C model of tests/support/c_fmus, compiled once.

    ``1:name`` and ``3:name`` are of FMI 1.0 and 3.0, `oscillator` is that of support.defects. They
    count as built here, so that they run in this process, but for those that are armed
    (`test_workers`), and with the option --workers.
    """
    folder = tmp_path_factory.mktemp("c_fmus")
    workers = request.config.getoption("--workers")

    def built(name: str) -> Path:
        fmu = made(name)
        if not workers and "+armed" not in name:
            write_record(fmu, BuildRecord(fmu=file_hash(fmu) or ""))
        return fmu

    def made(name: str) -> Path:
        version, colon, model = name.partition(":")
        what, *options = (model or name).split("+")
        if what == defects.NAME:
            return defects.build(folder)
        if what == "kinds":
            return build_kinds(int(version) if colon else 2, options, folder)
        return build_version(version, model, folder) if colon else build(name, folder)

    return cache(built)


@pytest.fixture
def python_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs exchange values by the loop in Python."""
    use_python(monkeypatch)


@pytest.fixture(params=["C", "Python"])
def loop(request: pytest.FixtureRequest) -> None:
    """Runs exchange values by the loop in C and, again, by that in Python."""
    if request.param == "Python":
        request.getfixturevalue("python_loop")


def pytest_configure() -> None:
    gc.set_threshold(*COLLECTION)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update", action="store_true", help="write reference series and golden files anew"
    )
    parser.addoption(
        "--workers", action="store_true", help="C models run in processes of their own"
    )
