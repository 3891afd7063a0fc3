"""Sources of the FMUs of components: programs of models and kinds, and Python code."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from m4e_fmi.cosim.system.component import Component, FmuFile, Kind, ModelFile, kind_module
from m4e_fmi.cosim.system.system import System
from m4e_fmi.files.files_read import Files, depends_on, files_read

if TYPE_CHECKING:
    from m4e_fmi.fmu import PythonSource
    from m4e_fmi.program import Program

Tell = Callable[[str], object]
WARNING = "warning"
"""How lines of progress begin that matter to everyone who uses what is built."""


@dataclass(frozen=True)
class Draft:
    """The source of an FMU, and the `files` that were read for it.

    `lines` are messages of progress that were not shown yet.
    """

    made: Program | PythonSource
    files: Files
    lines: tuple[str, ...] = ()


def takes_long(source: FmuFile | ModelFile | Kind) -> bool:
    """True for kinds that may take minutes to make."""
    return isinstance(source, Kind) and getattr(kind_module(source.name), "TAKES_LONG", False)


def drafted(system: System, component: Component, tell: Tell | None = None) -> Draft:
    """The draft of a component that is no FMU; `tell` gets lines of progress, else they are kept.

    InputError and RunError as from reading the model, or from `make` of the kind.
    """
    source, lines = component.source, list[str]()
    assert not isinstance(source, FmuFile)
    with files_read() as files:
        if isinstance(source, Kind):
            for path in named_files(system, source):  # however the kind reads them
                depends_on(path)
        made = _made(system, component.name, source, tell or lines.append)
    return Draft(made, files, tuple(lines))


def _made(system: System, name: str, source: ModelFile | Kind, progress: Tell) -> Any:
    """The Program or PythonSource of a component."""
    if isinstance(source, ModelFile):
        from m4e_fmi.model import load_model
        from m4e_fmi.multibody import model_program

        model = load_model(source.path)
        for warning in model.warnings:
            progress(f"{WARNING}: {warning}")
        return model_program(model)
    module = kind_module(source.name)
    return module.make(source.config, name=name, folder=system.folder, progress=progress)


def named_files(system: System, source: Kind) -> Iterator[Path]:
    """The files that are there and that the configuration of a kind names."""
    for text in _texts(source.config.model_dump(serialize_as_any=True)):
        try:
            path = system.folder / text
            if path.is_file():
                yield path
        except (OSError, ValueError):  # a text that no file can be called by
            continue


def _texts(value: Any) -> Iterator[str | Path]:
    """All texts and paths in plain data."""
    if isinstance(value, str | Path):
        yield value
    elif isinstance(value, Mapping):
        for member in value.values():
            yield from _texts(member)
    elif isinstance(value, list | tuple | set | frozenset):
        for member in value:
            yield from _texts(member)
