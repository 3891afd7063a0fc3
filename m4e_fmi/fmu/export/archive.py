"""The archive of any FMU: identifier, licenses, a GUID made of all its files, and the ZIP."""

from __future__ import annotations

import hashlib
import re
import zipfile
from collections.abc import Iterable, Mapping
from importlib.metadata import distribution
from pathlib import Path

from m4e_fmi.errors import InputError
from m4e_fmi.files.file_names import file_stem
from m4e_fmi.files.writing import written
from m4e_fmi.runtime.platforms import PLATFORMS, START_UP, packaged

EARLIEST_ZIP_DATE = (1980, 1, 1, 0, 0, 0)
LEVEL = 4
"""Of compression: half the time of 6, and 2 % more bytes."""
HASH_LENGTH = 12
LICENSES = "documentation/licenses"
_HOLDS = {
    "m4e_fmi": "m4e_fmi (BSD-3-Clause): the code in binaries, sources and resources",
    "pythonfmu": "PythonFMU (MIT): the libraries in binaries, and resources/pythonfmu",
    "mingw-w64": "mingw-w64 (ZPL 2.1): start-up code in the libraries for Windows",
}

Files = Mapping[str, bytes]
"""Name in the archive → content."""


def model_identifier(name: str) -> str:
    """`name` as a C identifier; InputError if nothing of it is left."""
    identifier = re.sub(r"\W", "_", file_stem(name), flags=re.ASCII)  # files are called so
    if not re.match(r"[A-Za-z]", identifier):
        message = f"{name!r} cannot name an FMU"
        raise InputError.single(message, "use letters, digits and _, a letter first")
    return identifier


def license_files(files: Iterable[str], *, native: bool) -> dict[str, bytes]:
    """Name in the archive → text: an overview, and each license of what the FMU holds.

    Sources: FMI Specification 2.0.4, section 2.3; 3.0.2, section 2.5.1. `files` are the names of
    the others in the archive. The model itself is its author's, who may say more by documentation
    of the same names.
    """
    texts = {
        name: (distribution(name).read_text("licenses/LICENSE") or "").encode()
        for name in (("m4e_fmi",) if native else ("m4e_fmi", "pythonfmu"))
    }
    start_up = packaged("fmi", PLATFORMS["x86_64-windows"], START_UP)
    if native and start_up is not None and any(name.endswith(".dll") for name in files):
        texts["mingw-w64"] = start_up.read_bytes()
    overview = "".join(f"{_HOLDS[name]}; see {name}.txt\n" for name in texts)
    licenses = {f"{LICENSES}/{name}.txt": text for name, text in texts.items()}
    return {f"{LICENSES}/license.txt": f"This FMU holds\n{overview}".encode(), **licenses}


def content_hash(files: Files, *, length: int = HASH_LENGTH) -> str:
    """The first `length` hexadecimal digits of a hash of names and contents, in any order."""
    digest = hashlib.sha256()
    for name in sorted(files):
        for part in (name.encode(), files[name]):
            digest.update(len(part).to_bytes(8, "big"))
            digest.update(part)
    return digest.hexdigest()[:length]


def write_archive(files: Files, path: Path) -> str:
    """Write a ZIP whose bytes depend on `files` only, and return its SHA-256 (hexadecimal).

    RunError if it cannot be written.
    """
    with written(path) as part:
        with zipfile.ZipFile(part, "x") as archive:
            for name in sorted(files):
                info = zipfile.ZipInfo(name, EARLIEST_ZIP_DATE)
                info.compress_type = zipfile.ZIP_DEFLATED
                info.create_system = 3  # Unix, wherever it is written
                info.external_attr = 0o644 << 16
                archive.writestr(info, files[name], compresslevel=LEVEL)
        return hashlib.sha256(part.read_bytes()).hexdigest()
