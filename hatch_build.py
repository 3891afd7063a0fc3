"""Builds the C libraries, runtime and native FMUs', into the wheel.

With the platform's compiler, for the platform; or, where $M4E_FMI_PLATFORMS names platforms with
commas between them, or "all", for those with the package ziglang. Such a wheel installs anywhere.
Without a compiler the wheel is a pure one: the libraries are then built on the user's machine at
first use, and where that fails too, plain Python does the work. Editable installs build them then.
"""

from __future__ import annotations

import os
import sys
import sysconfig
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

CHOSEN = "M4E_FMI_PLATFORMS"
BINARIES = Path("m4e_fmi") / "runtime" / "binaries"


class RuntimeBuildHook(BuildHookInterface):
    """Adds the compiled libraries to a wheel and marks the wheel with the platform."""

    def dependencies(self) -> list[str]:
        """What an isolated build installs before `initialize` is called."""
        if not os.environ.get(CHOSEN):
            return []
        return self.metadata.core.optional_dependencies["platforms"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if self.target_name != "wheel" or version == "editable":
            return
        sys.path.insert(0, self.root)  # the package itself is not installed yet
        from m4e_fmi.runtime import platforms
        from m4e_fmi.runtime.compiler import CompilationError

        names = os.environ.get(CHOSEN, "")
        here = replace(platforms.this_platform(), target="")
        # goes with this hook, after the wheel is written
        self._folder = tempfile.TemporaryDirectory()
        try:
            chosen = platforms.chosen(names) if names else [here]
            platforms.compile_libraries(chosen, Path(self._folder.name))
        except CompilationError as error:
            if names:
                raise
            self.app.display_warning(f"the wheel will have no compiled libraries: {error}")
            return
        build_data["force_include"][self._folder.name] = str(BINARIES)
        build_data["pure_python"] = False
        # the libraries are no extensions of Python: any version of it can load them
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{'any' if names else platform}"
