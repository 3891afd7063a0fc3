"""Names of a package that are imported when they are first used, and packages that are verbs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from inspect import signature
from types import ModuleType


def lazy(
    package: str, modules: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a `package` with the names that its `modules` have.

    A module may be a name itself.
    """
    places = {name: module for module, names in modules.items() for name in names}

    def get(name: str) -> object:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = import_module(f"{package}.{places[name]}")
        value = module if places[name] == name else getattr(module, name)
        setattr(sys.modules[package], name, value)
        return value

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *places})

    return get, listed


def as_verb(package: str, function: Callable[..., object]) -> None:
    """Let a `package` be called like its `function`: one name cannot be both in `m4e_fmi`."""

    class Verb(ModuleType):
        __call__ = staticmethod(function)
        __signature__ = signature(function)

    sys.modules[package].__class__ = Verb
