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

import os
import shutil
from collections.abc import Mapping
from contextlib import ExitStack, closing
from pathlib import Path

import fmpy

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.importer.calls import STANDARDS, Loaded
from m4e_fmi.fmu.importer.opening import Unpacked, remedy_for
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host, Worker, function_names
from m4e_fmi.fmu.importer.worker.keeper import load_library
from m4e_fmi.threads import PROCESS

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

    def close(self) -> None:
        """Wait for the end of workers, and remove the folder."""
        for worker in self.workers:
            worker.wait()
        self._unpacked.remove()


class Binary:
    """A library of an FMU; `close` it.

    `in_use` counts the instances; the library stays loaded if one of them cannot be freed. `worker`
    is the process in which it is loaded, None if that is this one.
    RunError, about `origin`, if it cannot be loaded.
    """

    worker: Worker | None = None

    def __init__(self, description: Description, files: Files, *, origin: str) -> None:
        self.in_use = 0
        self.files = files
        path = str(files.library())
        with PROCESS:
            here = Path.cwd()
            try:
                library = load_library(path, _needed(description))
            except Exception as error:
                raise _not_loaded(description, files, origin, str(error)) from error
            finally:
                os.chdir(here)
        self._loaded = Loaded(library, _prefix(description), description.guid, files.folder)

    @property
    def loaded(self) -> Loaded:
        """The library, which may be called."""
        return self._loaded

    def __enter__(self) -> Binary:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Unload the library."""
        if self.in_use == 0:
            fmpy.freeLibrary(self.loaded.library._handle)


class Hosted(Binary):
    """The library of one instance of an FMU, loaded in a worker; `loaded` waits for that."""

    def __init__(self, description: Description, files: Files, *, origin: str, host: Host) -> None:
        self.in_use = 0
        self.files, self._description, self._origin = files, description, origin
        folder = files.folder / f"worker_{len(files.workers)}"
        try:
            folder.mkdir()
            self.worker = Worker(
                origin,
                host,
                folder,
                clear=str(files.folder),
                library=str(files.library_path),
                needed=_needed(description),
                functions=[_prefix(description) + name for name in function_names()],
            )
        except OSError as error:
            raise _not_started(origin, error) from error
        files.workers.append(self.worker)
        runtime = self.worker.runtime
        self._loaded = Loaded(runtime, "m4e_remote_", description.guid, files.folder)
        self._waits = True

    @property
    def loaded(self) -> Loaded:
        """The library, once it is loaded."""
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
        return self._loaded

    def close(self) -> None:
        """Have the process end; `Files.close` waits for that."""
        assert self.worker
        self.worker.leave()


def _prefix(description: Description) -> str:
    """How the names of functions begin in the library of an FMU."""
    return f"{description.identifier}_" if description.version == "1.0" else ""


def _needed(description: Description) -> list[str]:
    """Names of the functions that the library of an FMU has to have."""
    return [_prefix(description) + name for name in STANDARDS[description.version].SIGNATURES]


def _not_started(origin: str, error: OSError) -> RunError:
    message = f"{origin}: no process can be started for it: {error}"
    return RunError(message, "free disk space, end other programs, or raise limits (`ulimit -a`)")


def _not_loaded(description: Description, files: Files, origin: str, why: str) -> RunError:
    text = why.replace(f"{files.folder}{os.sep}", "")
    remedy = remedy_for(why, description.version)
    return RunError(f"{origin}: its binary cannot be loaded: {text}", remedy)


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
        host = (hosts or {}).get(name)
        if host or last is None or last.worker or not last.files.shares_library:
            files = last.files if last else stack.enter_context(closing(Files(description)))
            last = stack.enter_context(opened_binary(description, files, origin=origin, host=host))
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
