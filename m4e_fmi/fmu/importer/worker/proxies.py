"""The functions of an FMU in a worker, in the form in which FMPy has those of a loaded library."""

from __future__ import annotations

import ctypes
import functools
import inspect
import types
import typing

from m4e_fmi.fmu.importer.calls.standard import FmpyInstance
from m4e_fmi.fmu.importer.worker.process import function_names, remote_library

Signature = tuple[str, list[str], list[object], object]
"""A function's name in C, names and types of its arguments, type of its result."""


@functools.cache
def _signatures(kind: type) -> dict[str, Signature]:
    """The signatures of all functions, by FMPy's names."""
    found: dict[str, Signature] = {}
    for name, function in inspect.getmembers(kind, inspect.isfunction):
        if not name.startswith("fmi"):
            continue
        signature = inspect.signature(function)
        parameters = [p for p in signature.parameters.values() if p.name != "self"]
        result = signature.return_annotation
        found[name] = (
            name.replace("fmi1", "fmi"),
            [p.name for p in parameters],
            [_type(p.annotation) for p in parameters],
            {bytes: ctypes.c_char_p, int: ctypes.c_int}.get(result, result),
        )
    return found


def _type(annotation: object) -> object:
    return typing.get_args(annotation)[0] if isinstance(annotation, types.UnionType) else annotation


def needed(kind: type, identifier: str) -> list[str]:
    """Names of the functions that a library has to have for FMPy's class `kind`."""
    prefix = f"{identifier}_" if "1" in kind.__name__ else ""
    return [prefix + name for name, *_ in _signatures(kind).values()]


def callable_names(identifier: str, version: str) -> list[str]:
    """The names in a library of the functions that can be called there, "" of other versions."""
    own = {"1.0": "fmi", "2.0": "fmi2", "3.0": "fmi3"}[version]
    prefix = f"{identifier}_" if version == "1.0" else ""
    return [
        prefix + name if name.startswith(own) and name[len(own)].isupper() else ""
        for name in function_names()
    ]


def proxies(kind: type, *, identifier: str, guid: str, folder: str) -> FmpyInstance:
    """FMPy's object of class `kind` for an FMU in a worker.

    Its instance is made in the worker of which `next_instance` was called last in this thread.
    """
    library = remote_library()
    assert library is not None
    found = object.__new__(kind)
    found.guid, found.modelIdentifier, found.unzipDirectory = guid, identifier, folder
    found.instanceName, found.fmiCallLogger, found.requireFunctions = identifier, None, True
    found.component = found.callbacks = None
    found.dll = types.SimpleNamespace()
    found._functions = {}
    prefix = f"{identifier}_" if "1" in kind.__name__ else ""
    for name, (c_name, names, arguments, result) in _signatures(kind).items():
        if c_name not in function_names():
            continue
        function: FmpyInstance = library[f"m4e_remote_{c_name}"]  # a new object each time
        function.argnames, function.argtypes, function.restype = names, arguments, result
        setattr(found.dll, prefix + c_name, function)
        found._functions[name] = function
    return found
