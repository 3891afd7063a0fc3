"""Components that run in processes of their own: those whose FMUs were not built here.

An FMU was built here if its record beside it says so and fits its content, or if its library is, to
the last byte, the one that all native FMUs of this package have. What an FMU says of itself counts
for nothing.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from zipfile import ZipFile

import fmpy

from m4e_fmi.cosim.system.component import Component, FmuFile
from m4e_fmi.cosim.system.processes import HERE
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import RunError
from m4e_fmi.fmu.export.build_record import read_record
from m4e_fmi.fmu.export.native import shell_binaries
from m4e_fmi.fmu.importer.opening import opened
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host
from m4e_fmi.fmu.importer.worker.channel import remote_library


def hosts(system: System, descriptions: Mapping[str, Description]) -> dict[str, Host]:
    """The conditions for each component that runs in a process of its own, by name."""
    files = {d.path: d for d in descriptions.values()}
    known = cache(lambda path: _built_here(files[path]))

    def is_apart(component: Component) -> bool:
        if component.process or component.limits:
            return component.process != HERE
        path = descriptions[component.name].path
        return isinstance(component.source, FmuFile) and not known(path)

    return {c.name: system.processes.host(c.limits) for c in system.components if is_apart(c)}


def without_library(hosts: Mapping[str, Host]) -> list[str]:
    """A warning if there are `hosts`, but no processes for them, or no library of C to call by."""
    if not hosts or (remote_library() is not None and hasattr(os, "fork")):
        return []
    why = (
        "other processes need the C library (`m4e-fmi doctor`)"
        if hasattr(os, "fork")
        else "this system has no fork, by which other processes are started"
    )
    return [f"{', '.join(hosts)}: run in this process, where a fault of an FMU ends all: {why}"]


def _built_here(description: Description) -> bool:
    return read_record(description.path) is not None or _has_our_library(description)


def _has_our_library(description: Description) -> bool:
    """True if the library for this machine is that of native FMUs."""
    path = description.path
    fmi3 = description.version == "3.0"
    folder = fmpy.platform_tuple if fmi3 else fmpy.platform
    name = f"binaries/{folder}/{description.identifier}{fmpy.sharedLibraryExtension}"
    try:
        ours = shell_binaries(description.identifier, fmi="3" if fmi3 else "2").get(name)
    except RunError:
        return False
    with opened(path, description.content) as file, ZipFile(file) as archive:
        return ours is not None and name in archive.namelist() and archive.read(name) == ours
