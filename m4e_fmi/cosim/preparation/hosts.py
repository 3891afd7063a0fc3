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

from m4e_fmi.cosim.system.component import HERE, OWN, Component, FmuFile
from m4e_fmi.cosim.system.system import System
from m4e_fmi.errors import InputError, RunError
from m4e_fmi.files.archives import ERRORS
from m4e_fmi.fmu.export.build_record import read_record
from m4e_fmi.fmu.export.native_fmu import shell_binaries
from m4e_fmi.fmu.importer.opening import opened
from m4e_fmi.fmu.importer.reading import Description
from m4e_fmi.fmu.importer.worker import Host


def hosts(system: System, descriptions: Mapping[str, Description]) -> dict[str, Host]:
    """The conditions for each component that runs in a process of its own, by name."""
    files = {d.path: d for d in descriptions.values()}
    known = cache(lambda path: read_record(path) is not None or _has_our_library(files[path]))

    def is_apart(component: Component) -> bool:
        if component.process or component.limits:
            return component.process != HERE
        path = descriptions[component.name].path
        return isinstance(component.source, FmuFile) and not known(path)

    return {c.name: system.processes.host(c.limits) for c in system.components if is_apart(c)}


def available(system: System, hosts: Mapping[str, Host]) -> tuple[dict[str, Host], list[str]]:
    """Those `hosts` that this machine can have, all or none, and a warning if it is none.

    InputError if it is none, and a component asks for a process or for limits.
    """
    if not hosts or hasattr(os, "fork"):
        return dict(hosts), []
    why = "this system has no fork, by which other processes are started"
    parts = [(c, ("components", c.name)) for c in system.components]
    asking = [
        *((*place, "process") for component, place in parts if component.process == OWN),
        *((*place, "limits") for component, place in parts if component.limits),
        *([("limits",)] if system.processes.limits else []),
    ]
    if asking:
        message = f"no FMU can have a process of its own: {why}"
        remedy = "leave this out, or run the system on another machine"
        raise InputError([system.problem(place, message, remedy) for place in asking])
    return {}, [f"{', '.join(hosts)}: run in this process, where a fault of an FMU ends all: {why}"]


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
    try:
        with opened(path, description.content) as file, ZipFile(file) as archive:
            return ours is not None and name in archive.namelist() and archive.read(name) == ours
    except ERRORS:  # damaged, which is told where it is unpacked
        return False
