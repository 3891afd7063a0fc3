"""The class of a user's Python file: its declarations, and calls of its methods.

Travels in the FMU, where m4e_fmi is not: it imports the standard library only.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NoReturn

Value = Any
"""A number, a list of them, or what records in their place."""
GROUPS = ("parameters", "inputs", "outputs", "states")
METHODS = ("start", "rates", "calculate", "step")
_NOT_THEIRS = {"m4e_fmi", "m4e_fmus", "m4e_adapters"}
"""Folders of this package's own code, beside a file in a source tree."""


class UserCodeError(Exception):
    """A mistake in the user's code; its text begins with file and line."""


@dataclass(frozen=True)
class Declared:
    """A variable that the class declares; `count` elements of an array, None for a scalar."""

    name: str
    unit: str
    text: str
    start: float
    count: int | None

    def made_at(self, place: str) -> str:
        """Its text with the `place` in the file where its value is returned."""
        return f"{self.text} ({place})" if self.text else place

    @property
    def elements(self) -> tuple[str, ...]:
        """The names of its elements, from 1; its own for a scalar."""
        if self.count is None:
            return (self.name,)
        return tuple(f"{self.name}[{k + 1}]" for k in range(self.count))


class UserClass:
    """The class in `module`, and one object of it.

    `path` is the file; messages show it as `shown`. UserCodeError if there is no such class, or if
    it cannot be instantiated.
    """

    def __init__(self, module: ModuleType, path: Path, shown: str) -> None:
        self.path, self.shown = path, shown
        found = [
            value
            for value in vars(module).values()
            if isinstance(value, type)
            and value.__module__ == module.__name__
            and any(method in vars(value) for method in METHODS)
        ]
        if len(found) != 1:
            names = ", ".join(c.__name__ for c in found) or "none"
            wanted = ", ".join(METHODS[:-1]) + f" or {METHODS[-1]}"
            raise UserCodeError(f"{shown}: one class must have a method {wanted}, found: {names}")
        self.kind = found[0]
        self.object = self.called(self.kind)

    def has(self, method: str) -> bool:
        """True if the class has the method."""
        return callable(getattr(self.kind, method, None))

    def line(self, method: str) -> int:
        """The line of the method's `def`."""
        code = getattr(getattr(self.kind, method, None), "__code__", None)
        return code.co_firstlineno if code else 0

    def called(self, function: Callable[..., Value], *arguments: object) -> Value:
        """The value of `function`; UserCodeError with file and line for whatever it raises."""
        try:
            return function(*arguments)
        except UserCodeError:
            raise
        except (Exception, SystemExit) as error:  # SystemExit would end the host
            raise UserCodeError(error_text(error, self.path, self.shown)) from error

    def results(
        self, method: str, wanted: Mapping[str, Declared], *arguments: object
    ) -> dict[str, Value]:
        """The values by element that the method returns for all of `wanted`: see `taken`."""
        returned = self.called(getattr(self.object, method), *arguments)
        return self.taken(method, returned, wanted)

    def taken(
        self, method: str, returned: object, wanted: Mapping[str, Declared]
    ) -> dict[str, Value]:
        """The values by element in what the method has `returned`.

        UserCodeError with file and line if one is missing, unknown or of another length.
        """
        here = f"{self.shown}:{self.line(method)}: {method}"
        if not isinstance(returned, Mapping):
            kind = type(returned).__name__
            raise UserCodeError(f"{here} returns a value of type {kind}, not a dict by name")
        problems = [f"it does not return {name!r}" for name in wanted if name not in returned]
        problems += [f"{name!r} is not declared" for name in returned if name not in wanted]
        found: dict[str, Value] = {}
        for name in (name for name in wanted if name in returned):
            variable, value = wanted[name], returned[name]
            values = [value] if _is_single(value) else list(value)
            if len(values) != len(variable.elements):
                count = len(variable.elements)
                problems.append(f"{name!r} has {len(values)} values, {count} are declared")
            found.update(zip(variable.elements, values, strict=False))
        if problems:
            raise UserCodeError(f"{here}: {'; '.join(problems)}")
        return found


def _is_single(value: object) -> bool:
    """True of what is no sequence of values; texts and arrays without a dimension are none."""
    without = isinstance(value, str | bytes) or getattr(value, "shape", None) == ()
    return without or not hasattr(value, "__iter__")


class Values:
    """Values of variables by name, as attributes: `v.oil`, `v.rod.vz`; an array is a list."""

    def __init__(self, variables: Mapping[str, Declared]) -> None:
        self.root = VariableGroup("")
        self._places: list[tuple[SimpleNamespace, str, Declared]] = []
        for name, variable in variables.items():
            *path, last = name.split(".")
            group = self.root
            for k, part in enumerate(path, 1):
                if not hasattr(group, part):
                    setattr(group, part, VariableGroup(f"{'.'.join(path[:k])}."))
                group = getattr(group, part)
            self._places.append((group, last, variable))

    def filled(self, values: Mapping[str, Value]) -> SimpleNamespace:
        """The same object each time, with these `values` by element."""
        for group, last, variable in self._places:
            elements = [values[name] for name in variable.elements]
            setattr(group, last, elements if variable.count is not None else elements[0])
        return self.root


class VariableGroup(SimpleNamespace):
    """The variables of a connector, or all; `prefix` is what their names begin with."""

    __slots__ = ("__prefix",)  # no attribute, which a variable may be called like

    def __init__(self, prefix: str) -> None:
        super().__init__()
        self.__prefix = prefix

    def __getattr__(self, name: str) -> Value:
        known = ", ".join(vars(self))
        message = f"no variable {self.__prefix}{name} is declared; there are: {known}"
        raise AttributeError(message)

    def __getitem__(self, name: object) -> NoReturn:
        raise TypeError(f"values are attributes: write v.{self.__prefix}{name}, not v[{name!r}]")


class _Fresh(SourceFileLoader):
    """Reads the source each time: bytecode in a cache is that of the same second and size."""

    def path_stats(self, path: str) -> NoReturn:
        raise OSError(f"no bytecode of {path} is wanted")


def loaded(
    path: Path,
    shown: str,
    name: str,
    prepare: Callable[[ModuleType], None] | None = None,
    *,
    travels: Container[str] | None = None,
) -> ModuleType:
    """The file as a module called `name`, run once; `prepare` gets the module before.

    It may import modules beside it, which nobody else gets: those that it `travels` with, by file
    name (None: all), and no folders. UserCodeError, which shows the file as
    `shown`, for whatever happens when it is run.
    """
    spec = importlib.util.spec_from_file_location(name, path, loader=_Fresh(name, str(path)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if prepare is not None:
        prepare(module)
    folders = set(_folders_beside(path))
    beside = {file.stem for file in path.parent.glob("*.py")} | folders
    others = {key: sys.modules.pop(key) for key in _modules_of(beside)}
    writes, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    sys.modules[name] = module
    sys.path.insert(0, str(path.parent))
    importlib.invalidate_caches()
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise UserCodeError(error_text(error, path, shown)) from error
    finally:
        sys.path.remove(str(path.parent))
        sys.dont_write_bytecode = writes
        imported = {key: sys.modules.pop(key) for key in _modules_of(beside)}
        sys.modules.pop(name, None)
        sys.modules.update(others)
    if travels is None:
        return module
    inside = sorted(
        {
            top
            for key, each in imported.items()
            if (top := key.partition(".")[0]) in folders
            and Path(getattr(each, "__file__", None) or "").is_relative_to(path.parent / top)
        }
    )
    if inside:
        raise UserCodeError(
            f"{shown}: imports from the folder {inside[0]} beside it, but files travel without "
            f"folders: put what it needs beside {shown}, and among its 'files'"
        )
    files = sorted(f"{key}.py" for key in imported.keys() - folders)
    left = [file for file in files if "." not in file[:-3] and file not in travels]
    if left:
        raise UserCodeError(
            f"{shown}: imports {left[0]} beside it, which must be among its 'files'"
        )
    return module


def _folders_beside(path: Path) -> Iterator[str]:
    """Folders of modules beside a file, but for those with the name of a module from elsewhere."""
    names = {file.parent.name for file in path.parent.glob("*/*.py")} - _NOT_THEIRS
    return (n for n in names if n.isidentifier() and not _is_elsewhere(n, path.parent.resolve()))


def _is_elsewhere(name: str, folder: Path) -> bool:
    """True if a module or package of that name is not in `folder`: it is not imported twice."""
    spec = None
    with suppress(ImportError, ValueError):  # of modules that were made without one
        spec = importlib.util.find_spec(name)
    if spec is None:
        return name in sys.modules
    places = [*(spec.submodule_search_locations or ())]
    if spec.has_location and spec.origin:
        places.append(spec.origin)
    return not places or any(not Path(p).resolve().is_relative_to(folder) for p in places)


def _modules_of(names: Container[str]) -> list[str]:
    """The imported modules that are, or are in, those of these names."""
    return [key for key in sys.modules if key.partition(".")[0] in names]


def error_text(error: BaseException, path: Path, shown: str) -> str:
    """File and line where `error` came out of the user's file, its type and its text.

    If it came from a file beside that, also its name and line.
    """
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return f"{shown}:{error.lineno}: not valid Python: {error.msg}"
    frames = [
        (Path(frame.filename), frame.lineno)
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename).parent == path.parent
    ]
    lines = [line for file, line in frames if file == path]
    place = f"{shown}:{lines[-1]}" if lines else shown
    if frames and frames[-1][0] != path:
        file, line = frames[-1]
        place += f": in {file.name}:{line}"
    return f"{place}: {type(error).__name__}: {error}"


def elements(variables: Mapping[str, Declared]) -> Iterator[str]:
    """The names of all elements, in order."""
    for variable in variables.values():
        yield from variable.elements
