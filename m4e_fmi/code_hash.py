"""Hashes of the code that makes FMUs: local packages by content, installed ones by version."""

from __future__ import annotations

import ast
import hashlib
import platform
import re
import sys
import time
import uuid
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from importlib.machinery import ModuleSpec
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path

OWN = ("m4e_fmi", "m4e_adapters", "m4e_fmus")
_INSTALLED = {"site-packages", "dist-packages"}
_BEGUN, _PROCESS = time.time(), uuid.uuid4().bytes


@cache
def code_hash(package: str = "") -> str:
    """Hash of all that decides how an FMU is made, but for what it is made from.

    That is: this package with its adapters and FMUs, `package` (a top-level name; it brings a kind)
    with what it imports, and Python. Ours, `package` and local packages that it imports count with
    the content of all their files, installed packages with their versions. What `package` imports
    under a name that it makes up while it runs is not found.
    """
    parts = {"python": platform.python_version()}
    parts |= {f"of {name}": package_hash(name) for name in OWN}
    parts |= {f"version of {name}": _version(name) for name in _required("m4e_fmi")}
    if package and package not in OWN:
        parts |= {f"of {package}": package_hash(package)} | _of_modules(_imports(package))
    return _hash_of(parts)


def imports_hash(sources: Iterable[bytes], own: Collection[str] = ()) -> str:
    """Hash of what Python files with these `sources` import, as `code_hash`; "" of nothing.

    Not that of Python itself, this package, and the modules `own`, which travel with the files.
    """
    names = {name for source in sources for name in _imported(source)}
    return _hash_of(_of_modules(names - {*own})) if names - {*own} else ""


def _of_modules(names: Iterable[str]) -> dict[str, str]:
    """Content of local modules and of those that they import, versions of installed ones.

    Of those whose distribution has another name, the content.
    """
    parts: dict[str, str] = {}
    waiting = list(dict.fromkeys(names))
    for name in waiting:  # grows meanwhile
        if _is_local(_spec(name)):
            parts[f"of {name}"] = package_hash(name)
            waiting += [other for other in _imports(name) if other not in waiting]
        else:
            parts[f"version of {name}"] = _version(name) or package_hash(name)
    return parts


def _hash_of(parts: Mapping[str, str]) -> str:
    text = "\n".join(f"{key}: {parts[key]}" for key in sorted(parts))
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def package_hash(name: str) -> str:
    """Hash of the content of a package, its data included, or of a module; none is empty.

    Files that changed after this process began may not be what it runs: then the hash is one that
    no other process gets.
    """
    digest = hashlib.sha256(name.encode())
    for relative, file in _files(name):
        content = file.read_bytes()
        digest.update(f"\0{relative}\0{len(content)}\0".encode())
        digest.update(content)
        if file.stat().st_mtime > _BEGUN:
            digest.update(_PROCESS)
    return digest.hexdigest()


def _files(name: str) -> list[tuple[str, Path]]:
    """(path in the package, file) of all files of a package, or of a module."""
    spec = _spec(name)
    if spec is None:
        return []
    found = []
    for folder in map(Path, spec.submodule_search_locations or ()):
        relative = ((path.relative_to(folder), path) for path in folder.rglob("*"))
        found += [(r.as_posix(), path) for r, path in relative if _counts(r) and path.is_file()]
    module = Path(spec.origin or "")
    if not found and module.is_file():
        found = [(module.name, module)]
    return sorted(found)


def _counts(path: Path) -> bool:
    return not any(part.startswith(".") or part == "__pycache__" for part in path.parts)


def _imports(name: str) -> set[str]:
    """Top-level names that the Python files of a package import, but for Python's and ours."""
    files = (file for _, file in _files(name) if file.suffix == ".py")
    return {other for file in files for other in _imported(file.read_bytes())} - {name}


def _imported(source: bytes) -> set[str]:
    """Top-level names that Python code imports, but for Python's and ours."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):  # it is not imported, then
        return set()
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.partition(".")[0])
    return found - sys.stdlib_module_names - {*OWN}


def _spec(name: str) -> ModuleSpec | None:
    try:
        return find_spec(name)
    except (ImportError, ValueError):  # of a parent that is not there, or has no spec
        return None


def _is_local(spec: ModuleSpec | None) -> bool:
    """True if a module may change without a new version: it is where nothing is installed."""
    if spec is None:
        return False
    places = [*(spec.submodule_search_locations or ()), spec.origin or ""]
    return not any(_INSTALLED & set(Path(place).parts) for place in places)


def _required(distribution: str) -> Iterable[str]:
    """Names of the distributions that one requires, without those of its extras."""
    try:
        wanted = requires(distribution) or ()
    except PackageNotFoundError:  # a source tree that is not installed
        return ()
    names = (re.match(r"[\w.-]+", text) for text in wanted if "extra ==" not in text)
    return [name[0] for name in names if name]


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""
