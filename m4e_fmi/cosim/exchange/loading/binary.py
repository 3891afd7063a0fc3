"""FMUs unpacked and loaded: a folder for all instances of a file, a copy of its library for each.

Static variables of a library are shared by all instances in it, which few FMUs say. In copies that
are files of their own (the loader tells files by inode, or on Windows by path) each instance has
its own, but for those of further libraries that it needs, which are loaded once.

Instances share a library that is known to do no harm: one that certainly has no static variables
(`static_data`), that of FMUs built here, and PythonFMU's, which keeps the interpreter, and there is
but one of that. Many copies of short functions would step slower: they are in each other's way in
the processor's cache.
"""

from __future__ import annotations

import ctypes
import inspect
import os
import shutil
from collections.abc import Mapping
from contextlib import ExitStack, closing
from copy import copy
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi1, fmi2, fmi3

from m4e_fmi.cosim.exchange.loading.static_data import keeps_nothing
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.unpack import Unpacked

CLASSES = {"1.0": fmi1.FMU1Slave, "2.0": fmi2.FMU2Slave, "3.0": fmi3.FMU3Slave}
"""FMPy's, by version of FMI."""
PYTHON = "resources/slavemodule.txt"
"""A file that every FMU of PythonFMU has, and no other."""
OWN = "m4e_fmi "
"""Beginning of the generation tool of FMUs that are built here; a version follows."""


class Files:
    """An FMU in a folder of its own, until `close`; RunError if it cannot be unpacked."""

    def __init__(self, description: Description) -> None:
        self._unpacked = Unpacked(description.path, description.content)
        self.folder = self._unpacked.folder
        platform = fmpy.platform_tuple if description.version == "3.0" else fmpy.platform
        name = description.identifier + fmpy.sharedLibraryExtension
        self._library = self.folder / "binaries" / platform / name
        self._copies = 0
        self._tool = description.tool

    @cached_property
    def shares_library(self) -> bool:
        """True if instances may share the library: it keeps nothing between calls."""
        is_known = self._tool.startswith(OWN) or (self.folder / PYTHON).is_file()
        return is_known or keeps_nothing(self._library)

    def library(self) -> Path:
        """A file of the library that nobody else has: itself at first, then copies beside it."""
        path = self._library
        if self._copies:
            path = path.with_stem(f"{path.stem}_{self._copies}")
            try:
                shutil.copyfile(self._library, path)
            except OSError as error:
                message = f"{self._library.name}: cannot be copied for another instance: {error}"
                raise RunError(message, "free disk space, or set TMPDIR") from error
        self._copies += 1
        return path

    def close(self) -> None:
        """Remove the folder."""
        self._unpacked.remove()


class Binary:
    """A library of an FMU, loaded by FMPy; `close` it.

    `functions` is FMPy's object for one instance, which is not instantiated: copies of it are.
    `in_use` counts the instances; the library stays loaded if one of them cannot be freed.
    RunError, about `origin`, if it cannot be loaded.
    """

    def __init__(
        self, description: Description, files: Files, *, origin: str, like: Binary | None = None
    ) -> None:
        """`like` is one of the same FMU, whose functions have the same signatures."""
        self.in_use = 0
        self.files = files
        library, here = files.library(), Path.cwd()
        try:
            self.functions = _again(like, library) if like else _loaded(description, files, library)
        except Exception as error:
            text = str(error).replace(str(files.folder), "")
            remedy = (
                f"a library it needs is missing, or it is not an FMI {description.version} binary"
            )
            raise RunError(f"{origin}: its binary cannot be loaded: {text}", remedy) from error
        finally:
            os.chdir(here)  # loading leaves the process elsewhere when it fails

    def __enter__(self) -> Binary:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Unload the library."""
        if self.in_use == 0:
            self.functions.freeLibrary()


def _loaded(description: Description, files: Files, library: Path) -> Any:
    """FMPy's object for a library, with the signatures of all functions."""
    kind = CLASSES[description.version]
    _keep_signatures(kind)
    # FMPy finds FMI 3.0's library by this name, and FMI 1.0's functions
    name = library.stem if description.version == "3.0" else description.identifier
    return kind(
        guid=description.guid,
        unzipDirectory=str(files.folder),
        modelIdentifier=name,
        instanceName=description.identifier,
        libraryPath=str(library),
    )


def _again(like: Binary, library: Path) -> Any:
    """The same for a copy of the library: finding out all signatures takes most of the time."""
    found = copy(like.functions)
    os.chdir(library.parent)  # where some find the libraries that they need
    found.dll = ctypes.cdll.LoadLibrary(str(library))
    found._functions = {}
    for name, known in like.functions._functions.items():
        function = getattr(found.dll, known.__name__)
        for of in ("argnames", "argtypes", "restype"):
            setattr(function, of, getattr(known, of))
        found._functions[name] = function
    return found


@cache
def _keep_signatures(kind: type) -> None:
    """Let the functions of FMPy's class carry their signatures.

    FMPy asks Python for the signatures of all of them whenever it loads a library, which is a third
    of the set-up of many FMUs; Python looks for a kept one first.
    """
    for _, function in inspect.getmembers(kind, inspect.isfunction):
        if function.__name__.startswith("fmi"):
            function.__signature__ = inspect.signature(function)


def binaries(
    descriptions: Mapping[str, Description],
    stack: ExitStack,
    loaded: Mapping[str, Binary] | None = None,
) -> dict[str, Binary]:
    """Component → a library of its FMU, which `stack` closes.

    Components of a file share its folder, also with those that are `loaded` already; FMUs that can
    be instantiated only once per process have one each. Some share the library too: see the module.
    """
    known = {descriptions[name].path: binary for name, binary in (loaded or {}).items()}
    found: dict[str, Binary] = {}
    for name, description in descriptions.items():
        last = None if description.once_per_process else known.get(description.path)
        if last is None or not last.files.shares_library:
            files = last.files if last else stack.enter_context(closing(Files(description)))
            origin = f"{name} ({description.path.name})"
            last = stack.enter_context(Binary(description, files, origin=origin, like=last))
        found[name] = known[description.path] = last
    return found
