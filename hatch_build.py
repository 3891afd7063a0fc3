"""Builds the C libraries, runtime and native FMUs', into the wheel.

With the platform's compiler, or the package ziglang where there is none, for the platform; or,
where $M4E_FMI_PLATFORMS names platforms with commas between them, or "all", for those with the
package ziglang. Such a wheel installs anywhere. Editable installs build the libraries at first use;
without a compiler, they are built beside the sources when installing.
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
sys.path.insert(0, str(Path(__file__).parent))  # the package itself is not installed yet

from m4e_fmi.runtime import platforms  # noqa: E402
from m4e_fmi.runtime.compiler import CompilationError, compiler  # noqa: E402


class RuntimeBuildHook(BuildHookInterface):
    """Adds the compiled libraries to a wheel and marks the wheel with the platform."""

    def dependencies(self) -> list[str]:
        """Packages that an isolated build installs before `initialize` is called."""
        if compiler() is not None and not os.environ.get(CHOSEN):
            return []
        return self.metadata.core.optional_dependencies["platforms"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        editable, names = version == "editable", os.environ.get(CHOSEN, "")
        by_package = (compiler() or [sys.executable])[0] == sys.executable
        if self.target_name != "wheel" or (editable and not by_package):
            return
        here = replace(platforms.this_platform(), target="")
        # goes with this hook, after the wheel is written
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self.root) / BINARIES if editable else Path(self._folder.name)
        try:
            chosen = platforms.chosen(names) if names and not editable else [here]
            platforms.compile_libraries(chosen, folder)
        except CompilationError as error:
            if names:
                raise
            self.app.display_warning(f"there will be no compiled libraries: {error}")
            return
        if editable:
            return
        build_data["force_include"][self._folder.name] = str(BINARIES)
        build_data["pure_python"] = False
        # the libraries are no extensions of Python: any version of it can load them
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{'any' if names else platform}"
