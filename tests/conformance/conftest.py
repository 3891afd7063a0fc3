"""FMUs of all kinds that several files of tests share, and instances of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from support.browser import Page, browser
from support.fmu_instances import KINDS, Instance, opened
from support.fmu_programs import PROGRAMS

from m4e_fmi.fmu import build_fmu
from m4e_fmi.program import Program


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page of one browser for all tests of a file."""
    with browser(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """`fmu(kind, program, **options)` is the path of an FMU, built once."""
    folder, number = tmp_path_factory.mktemp("fmus"), count()
    program = cache(lambda name: PROGRAMS[name]())

    @cache
    def built(name: str, native: bool, fmi: str, options: tuple[tuple[str, Any], ...]) -> Path:
        path = folder / str(next(number)) / f"{name}.fmu"
        return build_fmu(program(name), path, native=native, fmi=fmi, **dict(options))

    def found(kind: str, name: str = "driven", **options: Any) -> Path:
        of = KINDS[kind]
        return built(name, of.native, of.fmi, tuple(sorted(options.items())))

    return found


@pytest.fixture
def load(fmu: Callable[..., Path], tmp_path: Path) -> Iterator[Callable[..., Instance]]:
    """`load(kind, what, built=options, …)` is a fresh instance, freed after the test.

    It is of a program by name, of another program, or of the FMU at a path.
    """
    number = count()
    with ExitStack() as stack:

        def loaded(
            kind: str, what: str | Program | Path = "driven", *, built: Any = None, **arguments: Any
        ) -> Instance:
            folder, options = tmp_path / f"unpacked_{next(number)}", built or {}
            if isinstance(what, str):
                what = fmu(kind, what, **options)
            elif isinstance(what, Program):
                path = folder.with_suffix(".fmu")
                what = build_fmu(what, path, **KINDS[kind].build, **options)
            return stack.enter_context(opened(what, folder, KINDS[kind], **arguments))

        yield loaded
