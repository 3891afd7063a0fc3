"""FMUs unpacked and loaded: a folder for all instances of a file, a copy of its library for each.

All instances in a library share its static variables, which few FMUs declare. In copies that
are separate files (the loader identifies files by inode, or on Windows by path) each instance has
its own static variables, except those of further libraries, which are loaded once.

FMUs that are not built here are loaded in workers, one for each instance: `Hosted`.

Instances share a library that is known to be safe: that of FMUs built here, and PythonFMU's,
which holds the only interpreter. Many copies of short functions would step slower, because they
compete for the processor's cache.
"""

from __future__ import annotations

import ctypes
import inspect
import os
import shutil
from collections.abc import Mapping
from contextlib import ExitStack, closing
from copy import copy
from functools import cache
from pathlib import Path

import fmpy
from fmpy import fmi1, fmi2, fmi3

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.calls.standard import FmpyInstance
from m4e_fmi.fmu.importer.opening import Unpacked, remedy_for
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host, Worker, proxies
from m4e_fmi.threads import PROCESS

CLASSES = {"1.0": fmi1.FMU1Slave, "2.0": fmi2.FMU2Slave, "3.0": fmi3.FMU3Slave}
"""FMPy's, by version of FMI."""
PYTHON = "resources/slavemodule.txt"
"""A file that every FMU of PythonFMU has, and no other."""


class Files:
    """An FMU in a folder of its own, until `close`; RunError if it cannot be unpacked."""

    def __init__(self, description: Description) -> None:
        self._unpacked = Unpacked(description.path, description.content)
        self.folder = self._unpacked.folder
        platform = fmpy.platform_tuple if description.version == "3.0" else fmpy.platform
        name = description.identifier + fmpy.sharedLibraryExtension
        self.library_path = self.folder / "binaries" / platform / name
        self._copies = 0
        self._own = description.is_own
        self.workers: list[Worker] = []

    @property
    def shares_library(self) -> bool:
        """True if instances may share the library: it keeps nothing between calls."""
        return self._own or (self.folder / PYTHON).is_file()

    def library(self) -> Path:
        """A file of the library that nobody else has: itself at first, then copies beside it."""
        path = self.library_path
        if self._copies:
            path = path.with_stem(f"{path.stem}_{self._copies}")
            try:
                shutil.copyfile(self.library_path, path)
            except OSError as error:
                message = (
                    f"{self.library_path.name}: cannot be copied for another instance: {error}"
                )
                raise RunError(message, "free disk space, or set TMPDIR") from error
        self._copies += 1
        return path

    def working_folder(self) -> Path:
        """A new folder for a worker."""
        folder = self.folder / f"worker_{len(self.workers)}"
        folder.mkdir()
        return folder

    def close(self) -> None:
        """Wait for the end of workers, and remove the folder."""
        for worker in self.workers:
            worker.wait()
        self._unpacked.remove()


class Binary:
    """A library of an FMU, loaded by FMPy; `close` it.

    `functions` is FMPy's object for one instance, which is not instantiated: copies of it are.
    `in_use` counts the instances; the library stays loaded if one of them cannot be freed. `worker`
    is the process in which it is loaded, None if that is this one.
    RunError, about `origin`, if it cannot be loaded.
    """

    worker: Worker | None = None

    def __init__(
        self, description: Description, files: Files, *, origin: str, like: Binary | None = None
    ) -> None:
        """`like` is one of the same FMU, whose functions have the same signatures."""
        self.in_use = 0
        self.files = files
        library = files.library()
        with PROCESS:
            here = Path.cwd()
            try:
                self._functions = (
                    _again(like, library) if like else _loaded(description, files, library)
                )
            except Exception as error:
                raise _not_loaded(description, files, origin, str(error)) from error
            finally:
                os.chdir(here)  # loading leaves the process elsewhere when it fails

    @property
    def functions(self) -> FmpyInstance:
        """FMPy's object."""
        return self._functions

    def __enter__(self) -> Binary:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Unload the library."""
        if self.in_use == 0:
            self.functions.freeLibrary()


class Hosted(Binary):
    """The library of one instance of an FMU, loaded in a worker; `functions` waits for that."""

    def __init__(self, description: Description, files: Files, *, origin: str, host: Host) -> None:
        self.in_use = 0
        self.files, self._description, self._origin = files, description, origin
        kind = CLASSES[description.version]
        _keep_signatures(kind)
        self._functions = proxies(
            kind,
            identifier=description.identifier,
            guid=description.guid,
            folder=str(files.folder),
        )
        try:
            self.worker = Worker(
                origin,
                host,
                files.working_folder(),
                clear=str(files.folder.parent),
                library=str(files.library_path),
                needed=self._functions.dll.required_functions,
                functions=self._functions.dll.callable_names(),
            )
        except OSError as error:
            raise _not_started(origin, error) from error
        files.workers.append(self.worker)
        self._waits = True

    @property
    def functions(self) -> FmpyInstance:
        """FMPy's object, once the library is loaded."""
        assert self.worker
        if self._waits:
            self._waits = False
            try:
                why = self.worker.loaded()
            except OSError as error:
                raise _not_started(self._origin, error) from error
            if self.worker.ending:
                why = f"the process {why}"
            if why:
                raise _not_loaded(self._description, self.files, self._origin, why)
        return self._functions

    def close(self) -> None:
        """Have the process end; `Files.close` waits for that."""
        assert self.worker
        self.worker.leave()


def _not_started(origin: str, error: OSError) -> RunError:
    message = f"{origin}: no process can be started for it: {error}"
    return RunError(message, "free disk space, end other programs, or raise limits (`ulimit -a`)")


def _not_loaded(description: Description, files: Files, origin: str, why: str) -> RunError:
    text = why.replace(f"{files.folder}{os.sep}", "")
    remedy = remedy_for(why, description.version)
    return RunError(f"{origin}: its binary cannot be loaded: {text}", remedy)


def _loaded(description: Description, files: Files, library: Path) -> FmpyInstance:
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


def _again(like: Binary, library: Path) -> FmpyInstance:
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
            function.__signature__ = inspect.signature(function)  # pyrefly: ignore[missing-attribute]


def binaries(
    descriptions: Mapping[str, Description],
    stack: ExitStack,
    loaded: Mapping[str, Binary] | None = None,
    hosts: Mapping[str, Host] | None = None,
) -> dict[str, Binary]:
    """Component → a library of its FMU, which `stack` closes; in a worker for those of `hosts`.

    Components of a file share its folder, also with those that are `loaded` already; FMUs that can
    be instantiated only once per process have one each. Some share the library too: see the module.
    """
    known = {descriptions[name].path: binary for name, binary in (loaded or {}).items()}
    found: dict[str, Binary] = {}
    for name, description in descriptions.items():
        origin = f"{name} ({description.path.name})"
        last = None if description.once_per_process else known.get(description.path)
        if host := (hosts or {}).get(name):
            files = last.files if last else stack.enter_context(closing(Files(description)))
            last = stack.enter_context(Hosted(description, files, origin=origin, host=host))
        elif last is None or last.worker or not last.files.shares_library:
            files = last.files if last else stack.enter_context(closing(Files(description)))
            like = None if last and last.worker else last
            last = stack.enter_context(Binary(description, files, origin=origin, like=like))
        found[name] = known[description.path] = last
    for binary in found.values():
        if binary.worker:
            stack.callback(binary.worker.leave)  # all at once, before the first is waited for
    return found


def opened_binary(
    description: Description, files: Files, *, origin: str, host: Host | None
) -> Binary:
    """A library for one instance; in a worker with `host`."""
    if host:
        return Hosted(description, files, origin=origin, host=host)
    return Binary(description, files, origin=origin)
