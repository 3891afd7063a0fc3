"""Native FMUs: FMI 2.0 co-simulation and model exchange, without Python and without a compiler.

`src/` is the shell around the runtime's C library: `instance.h` first, then `fmi2.c`. Both together
are one shared library, the same for every FMU; what a model is lies in `resources/`: `model.m4e`,
the program in its binary form, `tangent.m4e`, its directional derivatives, and `fmu.txt`: the GUID,
the number of the integration method, the default tolerance and the longest step [s] of rk4. Imports
`runtime`, `errors`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from platform import machine

from m4e_fmi.errors import RunError
from m4e_fmi.runtime import compiler

PACKAGED = Path(__file__).with_name(f"_fmi2{compiler.SUFFIX}")
PLATFORM = {"win32": "win64", "darwin": "darwin64"}.get(sys.platform, "linux64")
"""FMI 2.0's name of the folder for this machine's binary."""
PLATFORM_3 = {
    "win64": "x86_64-windows",
    "darwin64": f"{'aarch64' if machine() == 'arm64' else 'x86_64'}-darwin",
    "linux64": f"{machine()}-linux",
}[PLATFORM]
"""FMI 3.0's."""


def shell_binary(identifier: str, *, fmi: str = "2") -> dict[str, bytes]:
    """Name in the archive → content of the shared library for this machine.

    It comes with the package, or is compiled once into the cache; RunError if it cannot be.
    """
    path = PACKAGED if PACKAGED.exists() else _compiled()
    platform = PLATFORM_3 if fmi == "3" else PLATFORM
    return {f"binaries/{platform}/{identifier}{compiler.SUFFIX}": path.read_bytes()}


def _compiled() -> Path:
    try:
        return compiler.cached_shared(
            "m4e_fmi2", compiler.shell_sources(), flags=compiler.SHELL_FLAGS
        )
    except compiler.CompilationError as error:
        message = f"there is no library for native FMUs, and none can be compiled: {error}"
        raise RunError(message, "install a C compiler, or build without --native") from error
