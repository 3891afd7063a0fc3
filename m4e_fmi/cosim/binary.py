"""FMUs unpacked and loaded: one folder and one library for all instances of a file."""

from __future__ import annotations

import inspect
import os
from collections.abc import Mapping
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any

from fmpy import fmi1, fmi2, fmi3

from m4e_fmi.errors import RunError
from m4e_fmi.fmu.reading import Description
from m4e_fmi.fmu.unpack import Unpacked

CLASSES = {"1.0": fmi1.FMU1Slave, "2.0": fmi2.FMU2Slave, "3.0": fmi3.FMU3Slave}
"""FMPy's, by version of FMI."""


class Binary:
    """The library of an FMU, loaded by FMPy from a folder of its own; `close` it.

    `functions` is FMPy's object for one instance, which is not instantiated: copies of it are.
    `in_use` counts the instances; the library stays loaded if one of them cannot be freed.
    RunError, about `origin`, if the FMU cannot be unpacked or loaded.
    """

    def __init__(self, description: Description, *, origin: str) -> None:
        self.in_use = 0
        self._unpacked = Unpacked(description.path, description.content)
        _keep_signatures(CLASSES[description.version])
        here = Path.cwd()
        try:
            self.functions: Any = CLASSES[description.version](
                guid=description.guid,
                unzipDirectory=str(self._unpacked.folder),
                modelIdentifier=description.identifier,
                instanceName=description.identifier,
            )
        except Exception as error:
            self._unpacked.remove()
            text = str(error).replace(str(self._unpacked.folder), "")
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
        """Unload the library and remove the folder."""
        if self.in_use == 0:
            self.functions.freeLibrary()
        self._unpacked.remove()


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
    """Component → its FMU's library, which `stack` closes; shared by the components of a file.

    Those that are `loaded` already are shared as well. FMUs that can be instantiated only once per
    process are loaded once for each component and each call.
    """
    shared = {descriptions[name].path: binary for name, binary in (loaded or {}).items()}
    found: dict[str, Binary] = {}
    for name, description in descriptions.items():
        path = description.path
        if path not in shared or description.once_per_process:
            origin = f"{name} ({path.name})"
            shared[path] = stack.enter_context(Binary(description, origin=origin))
        found[name] = shared[path]
    return found
