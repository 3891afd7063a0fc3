"""Builds the C libraries, runtime and native FMUs', into the wheel, with the platform's compiler.

Without a compiler the wheel is a pure one: the libraries are then built on the user's machine at
first use, and where that fails too, plain Python does the work. Editable installs build them then.
"""

from __future__ import annotations

import importlib.util
import sysconfig
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

RUNTIME = Path("m4e_fmi") / "runtime"
SHELL = Path("m4e_fmi") / "fmu" / "native"


def _compiler(root: Path) -> ModuleType:
    """The package's module `compiler`, loaded alone: the package itself is not installed yet."""
    spec = importlib.util.spec_from_file_location("compiler", root / RUNTIME / "compiler.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class RuntimeBuildHook(BuildHookInterface):
    """Adds the compiled library to a wheel and marks the wheel with the platform."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if self.target_name != "wheel" or version == "editable":
            return
        compiler = _compiler(Path(self.root))
        # goes with this hook, after the wheel is written
        self._folder = tempfile.TemporaryDirectory()
        libraries = {
            RUNTIME / "_m4e": (sorted(compiler.SOURCES.glob("*.c")), ()),
            SHELL / "_fmi2": (compiler.shell_sources(), compiler.SHELL_FLAGS),
        }
        for place, (sources, flags) in libraries.items():
            library = Path(self._folder.name) / f"{place.name}{compiler.SUFFIX}"
            try:
                compiler.compile_shared(sources, library, flags=flags)
            except compiler.CompilationError as error:
                self.app.display_warning(f"the wheel will have no compiled libraries: {error}")
                return
            build_data["force_include"][str(library)] = str(place.parent / library.name)
        build_data["pure_python"] = False
        # the libraries are no extensions of Python: any version of it can load them
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{platform}"
