"""FMUs that several files of tests share, and instances of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from support.browser import Page, browser
from support.driven import driven
from support.fmu3_instance import Instance3
from support.fmu_instance import Instance
from support.native_programs import NATIVE_PROGRAMS, NATIVE_PROGRAMS_3
from support.plane import plane
from support.python_programs import PYTHON_PROGRAMS

from m4e_fmi.fmu import build_fmu


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page of one browser for all tests of a file."""
    with browser(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


@pytest.fixture(scope="session")
def python_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Name of a program → its Python FMU."""
    folder = tmp_path_factory.mktemp("fmus")
    return {
        name: build_fmu(make(), folder / f"{name}.fmu") for name, make in PYTHON_PROGRAMS.items()
    }


@pytest.fixture
def load_python(tmp_path: Path, python_fmus: dict[str, Path]) -> Iterator[Callable[..., Instance]]:
    """`load_python(name or path)` is a fresh instance; all are freed after the test."""
    with ExitStack() as stack:
        count = iter(range(1000))

        def loaded(fmu: str | Path) -> Instance:
            path = python_fmus[fmu] if isinstance(fmu, str) else fmu
            return stack.enter_context(Instance(path, tmp_path / f"unpacked_{next(count)}"))

        yield loaded


@pytest.fixture(scope="session")
def native_fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Name of a program → its native FMU of FMI 2.0; `python` is a Python FMU of `driven`."""
    folder = tmp_path_factory.mktemp("native")
    made = {n: build_fmu(f(), folder / f"{n}.fmu", native=True) for n, f in NATIVE_PROGRAMS.items()}
    made["python"] = build_fmu(driven(), folder / "python.fmu")
    return made


@pytest.fixture
def load_native(native_fmus: dict[str, Path], tmp_path: Path) -> Iterator[Callable[..., Instance]]:
    """`load_native(name)` is a fresh instance; all are freed after the test."""
    opened: list[Instance] = []

    def loaded(name: str = "driven") -> Instance:
        opened.append(Instance(native_fmus[name], tmp_path / f"unpacked_{len(opened)}"))
        return opened[-1]

    yield loaded
    for instance in opened:
        instance.fmu.freeInstance()


@pytest.fixture(scope="session")
def native_fmus_3(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Name of a program → its native FMU of FMI 3.0."""
    folder = tmp_path_factory.mktemp("native3")
    return {
        name: build_fmu(make(), folder / f"{name}.fmu", native=True, fmi="3")
        for name, make in NATIVE_PROGRAMS_3.items()
    }


@pytest.fixture
def load_native_3(
    native_fmus_3: dict[str, Path], tmp_path: Path
) -> Iterator[Callable[..., Instance3]]:
    """`load_native_3(name, …)` is a fresh instance; all are freed after the test."""
    opened: list[Instance3] = []

    def loaded(name: str = "plane", **arguments: Any) -> Instance3:
        opened.append(
            Instance3(native_fmus_3[name], tmp_path / f"unpacked_{len(opened)}", **arguments)
        )
        return opened[-1]

    yield loaded
    for instance in opened:
        instance.fmu.freeInstance()


@pytest.fixture
def older(tmp_path: Path) -> Iterator[Instance]:
    """`plane` in FMI 2.0."""
    path = build_fmu(plane(), tmp_path / "older.fmu", native=True)
    with Instance(path, tmp_path / "older") as instance:
        yield instance
