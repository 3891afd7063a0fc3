"""documentation/licenses: under what the code in an FMU may be passed on.

Source: FMI Specification 2.0.4, section 2.3; 3.0.2, section 2.5.1.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.metadata import distribution

from m4e_fmi.runtime.platforms import PLATFORMS, START_UP, packaged

FOLDER = "documentation/licenses"
_HOLDS = {
    "m4e_fmi": "m4e_fmi (BSD-3-Clause): the code in binaries, sources and resources",
    "pythonfmu": "PythonFMU (MIT): the libraries in binaries, and resources/pythonfmu",
    "mingw-w64": "mingw-w64 (ZPL 2.1): start-up code in the libraries for Windows",
}


def license_files(*, pythonfmu: bool, binaries: Iterable[str]) -> dict[str, bytes]:
    """Name in the archive → text: an overview, and each license of what the FMU holds.

    `binaries` are the names of its libraries in the archive. The model itself is its author's, who
    may say more by documentation of the same names.
    """
    texts = {"m4e_fmi": _license("m4e_fmi")}
    start_up = packaged("fmi", PLATFORMS["x86_64-windows"], START_UP)
    if pythonfmu:
        texts["pythonfmu"] = _license("pythonfmu")
    elif start_up is not None and any(name.endswith(".dll") for name in binaries):
        texts["mingw-w64"] = start_up.read_bytes()
    overview = "".join(f"{_HOLDS[name]}; see {name}.txt\n" for name in texts)
    files = {f"{FOLDER}/{name}.txt": text for name, text in texts.items()}
    return {f"{FOLDER}/license.txt": f"This FMU holds\n{overview}".encode(), **files}


@cache
def _license(package: str) -> bytes:
    """The text that a package is installed with."""
    return (distribution(package).read_text("licenses/LICENSE") or "").encode()
