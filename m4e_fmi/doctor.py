"""`m4e-fmi doctor`: what is installed, what works here, and what to do about the rest."""

from __future__ import annotations

import platform
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, requires, version
from pathlib import Path

import m4e_fmi

ADAPTER_GROUP = "m4e_fmi.adapters"
KIND_GROUP = "m4e_fmi.fmus"


_NAME = re.compile(r"[\w.-]+")
"""The name that a requirement begins with; `packaging` would be most of a short command's time."""


@cache
def versions() -> dict[str, str]:
    """Versions of m4e_fmi, of Python and the platform, and of the packages that it requires."""
    found = {
        "m4e_fmi": m4e_fmi.__version__,
        "Python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }
    with suppress(PackageNotFoundError):  # a source tree that is not installed
        for text in requires("m4e_fmi") or ():
            name, extra = _NAME.match(text), "extra ==" in text
            if name and not extra:
                with suppress(PackageNotFoundError):
                    found[name[0]] = version(name[0])
    return found


@dataclass(frozen=True)
class Finding:
    """One thing looked at. `needed` things that are not `ok` make the doctor's exit code 1."""

    what: str
    ok: bool
    detail: str
    needed: bool = True


def examine() -> list[Finding]:
    """Everything the doctor looks at, in the order of a report."""
    return [
        *_python(),
        *_packages(),
        *_binaries(),
        *_native(),
        *_temporary(),
        *_plugins(),
    ]


def report(findings: list[Finding]) -> str:
    """The findings as lines of text, one each."""
    width = max(len(f.what) for f in findings)
    mark = {True: "ok     ", False: "MISSING"}
    lines = [
        f"{mark[f.ok] if f.needed or f.ok else 'absent '}  {f.what:<{width}}  {f.detail}"
        for f in findings
    ]
    missing = [f for f in findings if f.needed and not f.ok]
    verdict = f"{len(missing)} of {len(findings)} need attention" if missing else "all is well"
    return "\n".join([*lines, verdict])


def _python() -> Iterator[Finding]:
    good = (3, 11) <= sys.version_info[:2] < (3, 14)
    text = f"{platform.python_version()} on {platform.system()} {platform.machine()}"
    yield Finding("Python", good, text if good else f"{text}; install Python 3.11 to 3.13")


def _packages() -> Iterator[Finding]:
    try:
        wanted = requires("m4e_fmi") or []
    except PackageNotFoundError:
        yield Finding("m4e_fmi", False, "not installed: pip install m4e_fmi, or make demo")
        return
    yield Finding("m4e_fmi", True, version("m4e_fmi"))
    from packaging.requirements import Requirement

    for requirement in map(Requirement, wanted):
        if requirement.marker and not requirement.marker.evaluate({"extra": ""}):
            continue
        try:
            installed = version(requirement.name)
        except PackageNotFoundError:
            yield Finding(requirement.name, False, f"pip install '{requirement}'")
            continue
        good = requirement.specifier.contains(installed)
        detail = installed if good else f"{installed}; pip install '{requirement}'"
        yield Finding(requirement.name, good, detail)


def _binaries() -> Iterator[Finding]:
    """The binary of Python FMUs for this machine."""
    import ctypes

    from m4e_fmi.fmu.export.python_fmu import BINARIES, binary_path

    system = {"Linux": "linux", "Windows": "win", "Darwin": "darwin"}.get(platform.system(), "?")
    here = f"{system}{'64' if sys.maxsize > 2**32 else '32'}"
    detail = "loads in this process"
    if good := here in BINARIES:
        try:
            ctypes.CDLL(str(binary_path(here)))
        except OSError as error:
            good, detail = False, f"{error}; pip install --force-reinstall pythonfmu==0.7.0"
    else:
        detail = f"no Python FMU runs on {here}: use {' or '.join(BINARIES)}"
    yield Finding(f"FMU binary {here}", good, detail)


def _native() -> Iterator[Finding]:
    """The C library, and the platforms that native FMUs are built for."""
    from m4e_fmi.errors import RunError
    from m4e_fmi.runtime.compiler import compiler
    from m4e_fmi.runtime.library import library
    from m4e_fmi.runtime.platforms import packaged_platforms, this_platform

    try:
        library()
        yield Finding("C library", True, "loads in this process")
    except RunError as error:
        yield Finding("C library", False, f"{error.message}; {error.remedy}")
    names = [p.name for p in packaged_platforms()]
    here = this_platform().name
    if here not in names and compiler():
        names.append(f"{here}, compiled here")
    detail = f"for {'; '.join(names)}" if names else "none: install a C compiler, then they can be"
    yield Finding("native FMUs", bool(names), detail, needed=False)


def _temporary() -> Iterator[Finding]:
    folder = Path(tempfile.gettempdir())
    good = str(folder).isascii()
    detail = str(folder) if good else f"{folder} is not ASCII: set TMPDIR to a folder that is"
    yield Finding("temporary folder", good, detail)


def _plugins() -> Iterator[Finding]:
    from m4e_fmi.fmu import FmuKind

    for point in sorted(entry_points(group=KIND_GROUP), key=lambda p: p.name):
        yield Finding(f"FMU kind {point.name}", *_importable(point, FmuKind))
    for point in sorted(entry_points(group=ADAPTER_GROUP), key=lambda p: p.name):
        ok, detail = _importable(point)
        if not ok:
            yield Finding(f"adapter {point.name}", ok, detail)
            continue
        for what, good, text in point.load().requirements():
            yield Finding(f"{point.name}: {what}", good, text)


def _importable(point: EntryPoint, kind: type = object) -> tuple[bool, str]:
    try:
        found = point.load()
    except (ImportError, AttributeError) as error:
        return False, f"{error}; reinstall the package that offers {point.module}"
    if not isinstance(found, kind):
        return False, f"{point.value} is a {type(found).__name__}, not an {kind.__name__}"
    return True, point.module
