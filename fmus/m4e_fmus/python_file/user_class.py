"""The class of a user's Python file: its declarations, and calls of its methods.

Travels in the FMU, where m4e_fmi is not: it imports the standard library only.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NoReturn

Value = Any
"""A number, a list of them, or what records in their place."""
GROUPS = ("parameters", "inputs", "outputs", "states")
METHODS = ("start", "rates", "calculate", "step")


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


def loaded(
    path: Path,
    shown: str,
    name: str,
    prepare: Callable[[ModuleType], None] | None = None,
) -> ModuleType:
    """The file as a module called `name`, run once; `prepare` gets the module before.

    It may import modules beside it, which nobody else gets. UserCodeError, which shows the file as
    `shown`, for whatever happens when it is run.
    """
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if prepare is not None:
        prepare(module)
    beside = {file.stem for file in path.parent.glob("*.py")}
    others = {key: sys.modules.pop(key) for key in _modules_of(beside)}
    # bytecode of one second and size may be that of what was there before
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
        for key in (*_modules_of(beside), name):
            sys.modules.pop(key, None)
        sys.modules.update(others)
    return module


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
    message = str(error)
    if isinstance(error, ModuleNotFoundError):
        message += f": modules beside {shown} must be among its 'files', and travel without folders"
    if frames and frames[-1][0] != path:
        file, line = frames[-1]
        place += f": in {file.name}:{line}"
    return f"{place}: {type(error).__name__}: {message}"
