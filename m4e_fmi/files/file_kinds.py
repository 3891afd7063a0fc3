"""Kinds of files, and one error for a wrong one that names the commands which take it."""

from __future__ import annotations

import os
from collections.abc import Container
from pathlib import Path

from m4e_fmi.errors import InputError, is_file

MODEL, SYSTEM, FMU, YAML_FILE = "a model", "a system", "an FMU", "a YAML file"
_PACKAGE, _RESULTS = "a package of a system", "a file of results"
_CODE = "Python code"
URDF_SUFFIX, SSP_SUFFIX, FMU_SUFFIX = ".urdf", ".ssp", ".fmu"
_OF_SUFFIX = {
    URDF_SUFFIX: MODEL,
    FMU_SUFFIX: FMU,
    SSP_SUFFIX: _PACKAGE,
    ".nc": _RESULTS,
    ".py": _CODE,
}
_REMEDIES = {
    MODEL: "`m4e-fmi info` shows it, `m4e-fmi simulate` simulates it, `m4e-fmi build` builds its "
    "FMU, which `m4e-fmi validate` checks; in a system file it is a component: {model: NAME}",
    SYSTEM: "`m4e-fmi info` shows it, `m4e-fmi run` runs it, `m4e-fmi build` builds its FMUs, "
    "which `m4e-fmi validate` checks",
    FMU: "`m4e-fmi info` shows it, `m4e-fmi simulate` simulates it, `m4e-fmi validate` checks it; "
    "in a system file, which `m4e-fmi run` runs, it is a component: {fmu: NAME}",
    _PACKAGE: "`m4e-fmi info` shows it, `m4e-fmi run` runs it",
    _RESULTS: "`m4e-fmi compare` compares it, `m4e-fmi decay` finds damping in it; `m4e_fmi.load` "
    "reads netCDF in Python",
    _CODE: "in a system file, which `m4e-fmi run` runs and whose FMUs `m4e-fmi build` builds, it "
    "is a component: {kind: python, file: NAME}; `m4e-fmi new controller` writes such a start",
}


def as_path(given: object) -> Path:
    """`given` as a Path; InputError for anything that is not the path of a file."""
    if isinstance(given, (str, os.PathLike)):
        return Path(given)
    message = f"expected the path of a file, got {type(given).__name__}"
    raise InputError.single(message, "give its name, as a text or a Path")


def check_suffix(path: Path, expected: str) -> None:
    """InputError for an existing file whose suffix belongs to another kind than `expected`."""
    if is_file(path):
        _check(path, _OF_SUFFIX.get(path.suffix.lower(), ""), expected)


def check_named(path: Path, suffixes: tuple[str, ...], kind: str) -> None:
    """InputError for an existing file whose suffix does not fit its `kind`.

    Messages quote files, and a file that another one names may have any content: only files with a
    suffix of their kind are read.
    """
    if is_file(path) and path.suffix.lower() not in suffixes:
        message = f"is no {kind} by its name"
        remedy = f"names of such files end in {', '.join(suffixes[:-1])} or {suffixes[-1]}"
        raise InputError.single(message, remedy, str(path))


def check_keys(path: Path, keys: Container[str], expected: str) -> None:
    """InputError for YAML whose top-level `keys` belong to another kind than `expected`."""
    _check(path, kind_of(keys), expected)


def kind_of(keys: Container[str]) -> str:
    """Kind of a YAML file with these top-level keys: MODEL, SYSTEM, or "" if unclear."""
    if "components" in keys:
        return SYSTEM
    return MODEL if any(key in keys for key in ("bodies", "joints", "model")) else ""


def _check(path: Path, kind: str, expected: str) -> None:
    if kind and kind != expected:
        raise InputError.single(f"this is {kind}, not {expected}", _REMEDIES[kind], str(path))
