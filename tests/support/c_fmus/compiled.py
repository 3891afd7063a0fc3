"""Libraries of C models, compiled once for all processes of a run, and for later runs."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import zipfile
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
FMI_HEADERS = files("fmpy") / "c-code"
"""Folder of the standards' own headers."""
KEPT = Path(__file__).parents[3] / "build" / "c_fmus"


def packed(
    folder: Path, name: str, text: str, arguments: Sequence[str], platform: str = fmpy.platform
) -> Path:
    """The FMU `name` with a description and the library that the compiler makes of `arguments`."""
    library = folder / (name + fmpy.sharedLibraryExtension)
    compiled(["-shared", "-fPIC", "-w", f"-I{FMI_HEADERS}", f"-I{HERE}", *arguments], library)
    return archived(library, text, platform)


def archived(library: Path, text: str, platform: str = fmpy.platform) -> Path:
    """The FMU beside a library, of its name, with a description."""
    fmu = library.with_suffix(".fmu")
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(library, f"binaries/{platform}/{library.name}")
    return fmu


def compiled(command: Sequence[str], library: Path) -> None:
    """Write to `library` what ``cc`` makes with the arguments `command`.

    A copy is kept by its command and by all that may be compiled. Commands that name the
    library's own folder have none: they come once.
    """
    if any(str(library.parent) in word for word in command):
        subprocess.run(["cc", *command, "-o", str(library)], check=True)
        return
    kept = KEPT / hashlib.sha256("\0".join([*command, _made_from()]).encode()).hexdigest()
    if not kept.exists():
        KEPT.mkdir(parents=True, exist_ok=True)
        part = kept.with_suffix(f".{os.getpid()}")
        subprocess.run(["cc", *command, "-o", str(part)], check=True)
        part.replace(kept)
    shutil.copy(kept, library)


@cache
def _made_from() -> str:
    """A hash of the sources, with the compiler's and FMPy's versions."""
    version = subprocess.run(["cc", "--version"], stdout=subprocess.PIPE, check=True).stdout
    digest = hashlib.sha256(version + fmpy.__version__.encode())
    for source in sorted([*HERE.glob("*.[ch]"), *HERE.parent.glob("*.[ch]")]):
        digest.update(source.read_bytes())
    return digest.hexdigest()
